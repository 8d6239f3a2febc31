//! One page that needs nothing else: pictures, and a script that explains what is pointed at.
use super::Chart;
use crate::lab::diagram::svg::escape;
use crate::lab::diagram::{Diagram, ESTIMATE, Item, Link, words};
use engine::graph::recipe::Why;
use engine::schema::LabelId;
use serde_json::{Map, Value, json};

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/style.css");
/// The picture in its window; what is said; what is chosen, by mouse and keys; search.
const SCRIPT: [&str; 4] = [
    include_str!("page/view.js"),
    include_str!("page/tell.js"),
    include_str!("page/walk.js"),
    include_str!("page/find.js"),
];

impl Chart<'_> {
    /// A page with this chart, and with another form of it to change to.
    ///
    /// # Errors
    /// More items than a picture can show.
    pub fn to_html(&self, title: &str, other: Option<&Chart<'_>>) -> Result<String, String> {
        self.drawable()?;
        let forms: Vec<&Chart<'_>> =
            std::iter::once(self).chain(other.filter(|o| o.drawable().is_ok())).collect();
        let pictures: String = forms
            .iter()
            .enumerate()
            .map(|(number, form)| {
                let hidden = if number > 0 { " hidden=\"hidden\"" } else { "" };
                format!(
                    "<div class=\"picture\" id=\"form{number}\"{hidden}>{}</div>\n",
                    form.draw(&format!("f{number}-"))
                )
            })
            .collect();
        let (tasks, graphs): (Vec<_>, Vec<_>) =
            (0..self.diagrams.len()).map(|it| self.graph_data(it)).unzip();
        let why = [Why::Flow, Why::WriteAfterRead, Why::WriteAfterWrite];
        let why: Map<String, Value> =
            why.map(|it| (it.name().to_owned(), json!(words::why(it)))).into_iter().collect();
        let data = json!({
            "tasks": tasks.concat(), "graphs": graphs, "passes": self.json_passes(), "outline": self.program.to_string(),
            "labels": self.label_data(), "why": why, "when": words::WHEN.into_iter().collect::<std::collections::BTreeMap<_, _>>(),
            "forms": forms.iter().map(|form| form.data()).collect::<Vec<_>>(),
        });
        // JSON that is neither markup nor the end of the script, whatever the scene's names are
        let data = data.to_string().replace('&', "\\u0026").replace('<', "\\u003c").replace('>', "\\u003e");
        let title = escape(title);
        let places = [
            ("TITLE@", &*title),
            ("STYLE@", STYLE),
            ("PICTURES@", &pictures),
            ("DATA@", &data),
            ("SCRIPT@", &SCRIPT.concat()),
        ];
        Ok(fill(PAGE, &places))
    }

    /// The tasks of a graph, and what else the page tells about it in any form.
    fn graph_data(&self, number: usize) -> (Vec<Value>, Value) {
        let diagram = &self.diagrams[number];
        let json = diagram.shown().to_json();
        let mut tasks = json["tasks"].as_array().cloned().unwrap_or_default();
        for (task, node) in tasks.iter_mut().zip(diagram.graph.graph.node_weights()) {
            let access = node.declaration.access.iter().map(|a| {
                json!({
                    "label": a.label.name(), "how": words::mode(a), "writes": a.mode.writes(), "ghosts": words::ghosts(a.ghost),
                })
            });
            task["access"] = access.collect();
            task["over"] = json!(words::over(node.declaration.domain));
            task["graph"] = json!(number);
            if let Some(all) = task.as_object_mut() {
                // for programs
                all.remove("domain");
            }
            if diagram.cycle.most.is_none() {
                // all materials take the same step: there is no other time to run
                task["when"] = Value::Null;
            }
        }
        (tasks, json!({ "name": self.name(number), "pruned": json["pruned"] }))
    }

    /// What the labels of all tasks are, by name.
    fn label_data(&self) -> Map<String, Value> {
        let nodes = self.diagrams.iter().flat_map(|it| it.graph.graph.node_weights());
        let labels = nodes.flat_map(|node| node.declaration.access.iter().map(|access| access.label));
        let tell = |label: LabelId| {
            let told =
                json!({ "meaning": label.meaning(), "unit": label.unit(), "kept": words::label(label) });
            (label.name().to_owned(), told)
        };
        labels.map(tell).collect()
    }

    /// What the page tells about a form.
    fn data(&self) -> Value {
        let (mut items, mut links, mut graphs) = (Vec::new(), Vec::new(), Vec::new());
        for (number, it) in self.diagrams.iter().enumerate() {
            items.extend(it.items.iter().map(|item| item_data(it, item, number)));
            links.extend(it.links.iter().map(|link| link_data(it, link)));
            graphs.push(json!({ "span": it.span(), "path_ns": it.path_ns, "report": it.report() }));
        }
        let (expanded, measured) =
            self.diagrams.first().map_or((false, false), |it| (it.expanded, it.measured.is_some()));
        json!({
            "name": if expanded { "a box a task and patch" } else { "a box a task" }, "expanded": expanded,
            "items": items, "links": links, "graphs": graphs,
            "costs": if measured { "measured, where the trace has it; split among the tasks of a stage as estimated" } else { self.diagrams.first().map_or(ESTIMATE, |it| &it.estimate) },
        })
    }
}

/// What the page tells about an item, without what its task tells.
fn item_data(diagram: &Diagram<'_>, item: &Item, graph: usize) -> Value {
    let mut json = diagram.json_item(item);
    json["graph"] = json!(graph);
    json["kind_words"] = json!(words::kind(item.kind));
    let tells = json.get("task").is_some();
    if let Some(all) = json.as_object_mut().filter(|_| tells) {
        all.remove("about");
    }
    json
}

/// What the page tells about a link, without what its label tells.
fn link_data(diagram: &Diagram<'_>, link: &Link) -> Value {
    let mut json = diagram.json_link(link);
    if let Some(all) = json.as_object_mut() {
        ["unit", "critical"].into_iter().for_each(|key| drop(all.remove(key)));
        all.retain(|_, value| !value.is_null() && *value != 0);
    }
    json
}

/// Puts texts into the places of a page: what a text says is no place.
fn fill(page: &str, places: &[(&str, &str)]) -> String {
    let (mut filled, mut rest) = (String::new(), page);
    while let Some((before, after)) = rest.split_once('@') {
        filled += before;
        match places.iter().find(|(name, _)| after.starts_with(name)) {
            Some((name, text)) => {
                filled += text;
                rest = &after[name.len()..];
            }
            None => {
                filled.push('@');
                rest = after;
            }
        }
    }
    filled + rest
}
