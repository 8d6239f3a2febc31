//! The graph for people and for programs: text, dot, JSON.
use super::build::TaskGraph;
use super::recipe::Why;
use super::task::{Access, Domain, Mode};
use petgraph::visit::{EdgeRef, IntoEdgeReferences};
use serde_json::{Value, json};
use std::fmt::Write;

impl TaskGraph {
    /// One line a task, stage by stage.
    pub fn to_text(&self) -> String {
        let mut out = String::new();
        for (number, phase) in self.phases.iter().enumerate() {
            for stage in &phase.stages {
                let material =
                    stage.material.map_or(String::new(), |m| format!(" of {}", self.recipe.materials[m]));
                let how = match stage.domain {
                    Domain::Nodes => "node blocks of all materials, fused block by block",
                    Domain::Once => "once",
                    _ => "particles, fused chunk by chunk",
                };
                let _ = writeln!(out, "phase {number}: {how}{material}");
                for &node in &stage.nodes {
                    let declaration = &self.graph[node].declaration;
                    let near =
                        if declaration.domain == Domain::NearParticles { " (near others)" } else { "" };
                    let (reads, writes) = describe(declaration.access);
                    let _ = writeln!(out, "  {:<20}{reads} -> {writes}{near}", declaration.name);
                }
            }
        }
        let carried: Vec<&str> = self.carried.iter().map(|l| l.name()).collect();
        let _ = writeln!(out, "carried to the next step: {}", carried.join(", "));
        let pruned = if self.pruned.is_empty() { "nothing".to_owned() } else { self.pruned.join(", ") };
        let _ = writeln!(out, "pruned: {pruned}");
        out
    }

    /// Graphviz, one cluster a fused stage: solid edges carry data, dashed ones protect what is still read.
    pub fn to_dot(&self) -> String {
        let mut out =
            String::from("digraph step {\n  rankdir=LR;\n  node [shape=box, fontname=\"sans-serif\"];\n");
        let stages = self.phases.iter().flat_map(|p| &p.stages);
        for (number, stage) in stages.enumerate() {
            let material = stage.material.map_or("all materials", |m| &self.recipe.materials[m]);
            let _ = writeln!(out, "  subgraph cluster_{number} {{ label=\"{:?}, {material}\";", stage.domain);
            for &node in &stage.nodes {
                let _ =
                    writeln!(out, "    t{} [label=\"{}\"];", node.index(), self.graph[node].declaration.name);
            }
            out.push_str("  }\n");
        }
        for edge in self.graph.edge_references() {
            let ghost = match edge.weight().ghost {
                0 => String::new(),
                n => format!(" @{n}"),
            };
            let style = if edge.weight().why == Why::Flow { "solid" } else { "dashed" };
            let (from, to) = (edge.source().index(), edge.target().index());
            let label = edge.weight().label.name();
            let _ = writeln!(out, "  t{from} -> t{to} [label=\"{label}{ghost}\", style={style}];");
        }
        out.push_str("}\n");
        out
    }

    /// Tasks, stages and edges as JSON.
    pub fn to_json(&self) -> Value {
        let place = |node| {
            let mut stages =
                self.phases.iter().enumerate().flat_map(|(p, ph)| ph.stages.iter().map(move |s| (p, s)));
            stages.find(|(_, s)| s.nodes.contains(&node)).map(|(p, _)| p)
        };
        let tasks = self.graph.node_indices().map(|n| {
            let node = &self.graph[n];
            let access = node.declaration.access.iter().map(|a| {
                json!({ "label": a.label.name(), "unit": a.label.unit(), "mode": format!("{:?}", a.mode), "ghost": a.ghost })
            });
            json!({
                "id": n.index(), "task": node.declaration.name,
                "material": node.material.map(|m| &self.recipe.materials[m]),
                "domain": format!("{:?}", node.declaration.domain), "phase": place(n),
                "because": self.recipe.entries[node.entry].because,
                "access": access.collect::<Vec<_>>(),
            })
        });
        let edges = self.graph.edge_references().map(|e| {
            let w = e.weight();
            json!({
                "from": e.source().index(), "to": e.target().index(), "label": w.label.name(),
                "material": self.recipe.materials.get(w.material), "why": format!("{:?}", w.why), "ghost": w.ghost,
            })
        });
        json!({
            "tasks": tasks.collect::<Vec<_>>(), "edges": edges.collect::<Vec<_>>(), "pruned": self.pruned,
            "carried": self.carried.iter().map(|l| l.name()).collect::<Vec<_>>(),
        })
    }

    /// Which scene line asked for the tasks called `name`: (task with material, dotted key; empty: always there).
    pub fn why(&self, name: &str) -> Vec<(String, String)> {
        let matching = self.graph.node_weights().filter(|n| n.declaration.name.eq_ignore_ascii_case(name));
        matching.map(|n| (n.name.clone(), self.recipe.entries[n.entry].because.clone())).collect()
    }
}

fn describe(access: &[Access]) -> (String, String) {
    let list = |wanted: &dyn Fn(Mode) -> bool| {
        let one = |a: &Access| match (a.mode, a.ghost) {
            (Mode::RequiresOld, 0) => format!("old {}", a.label.name()),
            (Mode::RequiresOld, n) => format!("old {}@{n}", a.label.name()),
            (_, 0) => a.label.name().to_owned(),
            (_, n) => format!("{}@{n}", a.label.name()),
        };
        access.iter().filter(|a| wanted(a.mode)).map(one).collect::<Vec<_>>().join(", ")
    };
    (list(&Mode::reads), list(&Mode::writes))
}
