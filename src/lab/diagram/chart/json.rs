//! A program as JSON.
use super::Chart;
use engine::program::{Pass, ProgramNode};
use serde_json::{Value, json};

impl Chart<'_> {
    /// `program` is the tree: its `name`, and `nodes` that are graphs (`kind`, `name`, and the number of the `graph`) or loops
    /// (`kind`, `until`, `most`, `body`; `most` is null where nothing bounds it). `passes` says what passes between the graphs:
    /// `from` and `to` by number, `when`, `label`, `unit`, `material`, and the tasks that write it last and read it first.
    /// What is known of a graph stands beside these where the program has one, in the list `graphs` where it has several.
    pub fn to_json(&self) -> Value {
        let mut json = match &self.diagrams[..] {
            [only] => only.to_json(),
            several => json!({ "graphs": several.iter().map(|it| it.to_json()).collect::<Vec<_>>() }),
        };
        let nodes = tree(&self.program.nodes, &mut 0);
        json["program"] = json!({ "name": self.program.name, "nodes": nodes });
        json["passes"] = self.json_passes();
        json
    }

    /// All passes.
    pub(super) fn json_passes(&self) -> Value {
        self.passes.iter().map(|pass| self.json_pass(pass)).collect()
    }

    fn json_pass(&self, pass: &Pass) -> Value {
        let materials = &self.diagrams[pass.from].graph.recipe.materials;
        let ids = |nodes: &[petgraph::stable_graph::NodeIndex]| -> Vec<usize> {
            nodes.iter().map(|node| node.index()).collect()
        };
        json!({
            "from": pass.from, "to": pass.to, "when": pass.delay.name(), "label": pass.label.name(),
            "unit": pass.label.unit(), "material": pass.material.map(|m| &materials[m]),
            "writers": ids(&pass.writers), "readers": ids(&pass.readers),
        })
    }
}

fn tree(nodes: &[ProgramNode], next: &mut usize) -> Vec<Value> {
    let mut list = Vec::new();
    for node in nodes {
        list.push(match node {
            ProgramNode::Graph(graph) => {
                *next += 1;
                json!({ "kind": "graph", "name": graph.name, "graph": *next - 1 })
            }
            ProgramNode::Loop(it) => {
                let most = (it.most < u64::MAX).then_some(it.most);
                json!({ "kind": "loop", "until": it.until.name(), "most": most, "body": tree(&it.body, next) })
            }
        });
    }
    list
}
