//! Items, links and what goes with them as JSON.
use super::{Diagram, Item, Kind, Link};
use engine::graph::traffic::{Messages, Pairs};
use serde_json::{Value, json};

impl Diagram<'_> {
    /// Tasks and edges as [`super::export::Shown::to_json`] has them, with all that the diagram adds.
    pub fn to_json(&self) -> Value {
        let mut json = self.shown().to_json();
        json["name"] = json!(self.graph.name);
        json["form"] = json!(if self.expanded { "expanded" } else { "collapsed" });
        json["ranks"] = json!(self.traffic.ranks);
        json["rank_of_patch"] = json!(self.traffic.rank_of);
        json["items"] = self.items.iter().map(|item| self.json_item(item)).collect();
        json["links"] = self.links.iter().map(|link| self.json_link(link)).collect();
        json["stages"] = self
            .groups
            .iter()
            .filter(|group| group.stage && !group.items.is_empty())
            .map(|group| {
                let items: Vec<&str> = group.items.iter().map(|&at| self.items[at].id.as_str()).collect();
                json!({ "title": group.title, "items": items })
            })
            .collect();
        json["messages"] = self.json_messages();
        let path: Vec<&str> = self.path.iter().map(|&at| self.items[at].id.as_str()).collect();
        let how = if self.measured.is_some() { "measured where the trace has it" } else { &self.estimate };
        json["critical_path"] = json!({ "items": path, "ns": self.path_ns, "of": self.span(), "costs": how });
        if let Some(measured) = self.measured {
            json["measured"] = json!({
                "steps": measured.steps, "ms_a_step": 1e-6 * measured.per_step(measured.span_ns),
                "lost_events": measured.lost,
                "workers": measured.workers.iter().map(|w| json!({
                    "rank": w.rank, "thread": w.thread, "busy_ns": measured.per_step(w.busy_ns),
                    "wait_ns": measured.per_step(w.wait_ns), "idle_ns": measured.per_step(w.idle_ns),
                })).collect::<Vec<_>>(),
            });
        }
        json
    }

    /// An item with all its details.
    pub(super) fn json_item(&self, item: &Item) -> Value {
        let mut json = json!({
            "id": item.id, "kind": word(item.kind), "name": item.name, "title": self.title(item), "about": self.about(item),
            "cost_ns": item.cost, "cost_is": item.source.word(), "critical": item.critical,
        });
        let mut add = |key: &str, value: Value| {
            if !value.is_null() {
                json[key] = value;
            }
        };
        add("patch", json!(item.patch));
        add("rank", json!(item.rank));
        add("to_rank", json!(item.to_rank));
        add("idle_ns", json!(item.idle));
        add("material", json!(item.material.map(|m| &self.graph.recipe.materials[m])));
        if let Kind::Task(node) = item.kind {
            let it = &self.graph.graph[node];
            add("task", json!(node.index()));
            add("work", json!(item.work));
            add("because", json!(self.graph.recipe.entries[it.entry].because));
        } else {
            add("labels", item.labels.iter().map(|label| label.name()).collect());
            add("messages", json!(item.messages.count));
            add("bytes", json!(item.messages.bytes));
        }
        json
    }

    /// A link with all its details.
    pub(super) fn json_link(&self, link: &Link) -> Value {
        json!({
            "from": self.items[link.from].id, "to": self.items[link.to].id, "label": link.label.name(),
            "unit": link.label.unit(), "material": link.material.map(|m| &self.graph.recipe.materials[m]),
            "why": link.why.name(), "ghost": link.ghost, "bytes": link.bytes, "critical": link.critical,
        })
    }

    fn json_messages(&self) -> Value {
        let pairs = |pairs: Pairs| -> Value {
            let one = |((from, to), m): ((usize, usize), Messages)| json!({ "from": from, "to": to, "count": m.count, "bytes": m.bytes });
            pairs.into_iter().map(one).collect()
        };
        let causes = self.traffic.by_cause(self.graph);
        causes.into_iter().map(|(cause, list)| json!({ "about": cause, "pairs": pairs(list) })).collect()
    }
}

/// The kind of an item in a word.
pub(super) fn word(kind: Kind) -> &'static str {
    match kind {
        Kind::Task(_) => "task",
        Kind::Halo(_) => "halo",
        Kind::Reduction(_) => "reduction",
        Kind::Relocation => "relocation",
    }
}
