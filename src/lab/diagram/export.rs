//! The tasks of a graph for people and for programs: a table, JSON. `diagram` adds exchanges, bytes and pictures.
use crate::simulation::rates::{Cycle, StepAtRest};
use engine::graph::build::TaskGraph;
use engine::graph::phase::{Stage, When};
use engine::graph::task::{Access, Domain, Mode};
use petgraph::visit::{EdgeRef, IntoEdgeReferences};
use serde_json::{Value, json};
use std::fmt::Write;

/// A graph with the way in which its steps nest.
pub struct Shown<'a> {
    /// The graph.
    pub graph: &'a TaskGraph,
    /// How the steps of materials nest.
    pub cycle: &'a Cycle,
}

impl Shown<'_> {
    /// One line a task, stage by stage.
    pub fn to_text(&self) -> String {
        let Self { graph, cycle } = self;
        let mut out = String::new();
        if cycle.most.is_some() {
            let _ = writeln!(out, "{}", self.estimate());
        }
        for (number, phase) in graph.phases.iter().enumerate() {
            for stage in &phase.stages {
                let material =
                    stage.material.map_or(String::new(), |m| format!(" of {}", graph.recipe.materials[m]));
                let how = match stage.domain {
                    Domain::Nodes => "node blocks of all materials, fused block by block",
                    Domain::Once => "once",
                    _ => "particles, fused chunk by chunk",
                };
                let when = match (cycle.most, stage.domain) {
                    (None, _) => String::new(),
                    (_, Domain::Once) => format!(" {}", when(stage)),
                    _ => format!(": {}", when(stage)),
                };
                let _ = writeln!(out, "phase {number}: {how}{material}{when}");
                for &node in &stage.nodes {
                    let declaration = &graph.graph[node].declaration;
                    let near = match declaration.domain {
                        Domain::NearParticles => " (near others)",
                        Domain::Buffers => " (once a block)",
                        _ => "",
                    };
                    let (reads, writes) = describe(declaration.access);
                    let _ = writeln!(out, "  {:<20}{reads} -> {writes}{near}", declaration.name);
                }
            }
        }
        let pruned = if graph.pruned.is_empty() { "nothing".to_owned() } else { graph.pruned.join(", ") };
        let _ = writeln!(out, "pruned: {pruned}");
        out
    }

    /// The estimated steps of the materials, in a line.
    fn estimate(&self) -> String {
        let Self { graph, cycle } = self;
        let one = |(name, own): (&String, &StepAtRest)| match own.ticks {
            1 => format!("{name} 1 tick"),
            n => format!("{name} {n} ticks ({:.3e} s)", own.size),
        };
        let steps: Vec<String> = graph.recipe.materials.iter().zip(&cycle.own).map(one).collect();
        format!(
            "rates (estimates at rest; the run decides anew each step): tick {:.3e} s; {}",
            cycle.tick,
            steps.join(", ")
        )
    }

    /// Tasks, stages, edges and rates as JSON.
    pub fn to_json(&self) -> Value {
        let Self { graph, cycle } = self;
        let place = |node| {
            let mut stages =
                graph.phases.iter().enumerate().flat_map(|(p, ph)| ph.stages.iter().map(move |s| (p, s)));
            stages.find(|(_, s)| s.nodes.contains(&node))
        };
        let moment = |stage: &Stage| match (stage.domain, stage.when) {
            (Domain::Once | Domain::Nodes, _) => "tick",
            (_, When::Begin) => "begin",
            (_, When::End) => "end",
        };
        let tasks = graph.graph.node_indices().map(|n| {
            let node = &graph.graph[n];
            let access = node.declaration.access.iter().map(|a| {
                json!({
                    "label": a.label.name(), "unit": a.label.unit(), "meaning": a.label.meaning(), "mode": format!("{:?}", a.mode),
                    "ghost": a.ghost,
                })
            });
            json!({
                "id": n.index(), "task": node.declaration.name, "about": node.declaration.about,
                "material": node.material.map(|m| &graph.recipe.materials[m]),
                "domain": format!("{:?}", node.declaration.domain), "phase": place(n).map(|(phase, _)| phase), "when": place(n).map(|(_, stage)| moment(stage)),
                "because": graph.recipe.entries[node.entry].because,
                "access": access.collect::<Vec<_>>(),
            })
        });
        let edges = graph.graph.edge_references().map(|e| {
            let w = e.weight();
            json!({
                "from": e.source().index(), "to": e.target().index(), "label": w.label.name(),
                "material": graph.recipe.materials.get(w.material), "why": format!("{:?}", w.why), "ghost": w.ghost,
            })
        });
        let own = graph.recipe.materials.iter().zip(&cycle.own);
        let own = own.map(|(name, own)| json!({ "material": name, "step_s": own.size, "ticks": own.ticks }));
        let mode = if cycle.most.is_some() { "per-material" } else { "common" };
        json!({
            "rates": {
                "mode": mode, "most": cycle.most.unwrap_or(1), "tick_s": cycle.tick,
                "estimated_at_rest": own.collect::<Vec<_>>(),
            },
            "tasks": tasks.collect::<Vec<_>>(), "edges": edges.collect::<Vec<_>>(), "pruned": graph.pruned,
            "carried": graph.carried.iter().map(|l| l.name()).collect::<Vec<_>>(),
        })
    }
}

/// When a stage runs, where materials take steps of their own.
fn when(stage: &Stage) -> &'static str {
    match (stage.domain, stage.when) {
        (Domain::Once, _) => "each tick",
        (Domain::Nodes, _) => "in blocks where the step of a material ends",
        (_, When::Begin) => "when its step begins",
        (_, When::End) => "when its step ends",
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
