//! Why something is in the graph: the line of the scene behind a task, who makes and reads a label, what an edge is for.
use super::build::TaskGraph;
use super::recipe::TaskNode;
use crate::schema::Life;
use petgraph::algo::astar;
use petgraph::stable_graph::NodeIndex;

impl TaskGraph {
    /// Which scene line asked for the tasks called `name`: (task with material, dotted key; empty: always there).
    pub fn why(&self, name: &str) -> Vec<(String, String)> {
        let matching = self.graph.node_weights().filter(|n| n.declaration.name.eq_ignore_ascii_case(name));
        matching.map(|n| (n.name.clone(), self.recipe.entries[n.entry].because.clone())).collect()
    }

    /// What the task called `name` does; none for a name that is no task of this graph.
    pub fn about(&self, name: &str) -> Option<&'static str> {
        let mut matching = self.graph.node_weights().map(|node| node.declaration);
        matching.find(|it| it.name.eq_ignore_ascii_case(name)).map(|it| it.about)
    }

    /// What a label is, and who writes and reads it, in lines; none for a name that is no label of this graph.
    pub fn why_label(&self, name: &str) -> Vec<String> {
        let Some(label) = self.schema().find(name) else {
            return Vec::new();
        };
        let accesses = self.graph.node_weights().flat_map(|node| {
            let mine = node.declaration.access.iter().filter(move |a| a.label == label);
            mine.map(move |access| (node, access))
        });
        let lines: Vec<String> = accesses
            .map(|(node, access)| {
                format!("  {:?} by {}{}", access.mode, node.name, with_ghosts(access.ghost))
            })
            .collect();
        if lines.is_empty() {
            return lines;
        }
        let head = format!("{} [{}]: {}", label.name(), label.unit(), label.meaning());
        let kept = match label.life() {
            Life::Carried => "  carried to the next step",
            _ => "  left by an earlier graph or round",
        };
        let kept = self.carried.contains(&label).then(|| kept.to_owned());
        std::iter::once(head).chain(lines).chain(kept).collect()
    }

    /// Why a task called `from` comes before one called `to` (with or without `[material]`): their edges, or the shortest
    /// chain of edges between them; in lines.
    pub fn why_edge(&self, from: &str, to: &str) -> Vec<String> {
        let named = |name: &str| -> Vec<NodeIndex> {
            let wanted = |node: &TaskNode| {
                node.name.eq_ignore_ascii_case(name) || node.declaration.name.eq_ignore_ascii_case(name)
            };
            self.graph.node_indices().filter(|&n| wanted(&self.graph[n])).collect()
        };
        let mut lines = Vec::new();
        for source in named(from) {
            for target in named(to).into_iter().filter(|&target| target != source) {
                let chain = astar(&self.graph, source, |n| n == target, |_| 1, |_| 0);
                for pair in chain.map(|(_, nodes)| nodes).unwrap_or_default().windows(2) {
                    lines.extend(self.edges_between(pair[0], pair[1]));
                }
            }
        }
        lines
    }

    fn edges_between(&self, from: NodeIndex, to: NodeIndex) -> Vec<String> {
        let edges = self.graph.edges_connecting(from, to).map(|edge| {
            let it = edge.weight();
            let ghost = with_ghosts(it.ghost);
            let material = &self.recipe.materials[it.material];
            let (from, to, label) = (&self.graph[from].name, &self.graph[to].name, it.label.name());
            format!("{from} -> {to}: {}, {label} of {material}{ghost}", it.why.name())
        });
        let mut lines: Vec<String> = edges.collect();
        lines.sort();
        lines
    }
}

/// The ghost layers of an access in words, if it has any.
fn with_ghosts(layers: u8) -> String {
    if layers > 0 { format!(" with {layers} ghost layers") } else { String::new() }
}
