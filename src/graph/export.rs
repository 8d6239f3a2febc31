//! The tasks of a graph for people and for programs: a table, JSON. `diagram` adds exchanges, bytes and pictures.
use super::build::TaskGraph;
use super::fuse::{Stage, When};
use super::task::{Access, Domain, Mode};
use petgraph::visit::{EdgeRef, IntoEdgeReferences};
use serde_json::{Value, json};
use std::fmt::Write;

/// How the steps of materials nest, as plain numbers from who knows the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// The most ticks in a step, if materials take steps of their own.
    pub most: Option<u32>,
    /// Estimated size of a tick [s].
    pub tick: f64,
    /// The material that the tick suits.
    pub fastest: usize,
    /// What each material would take now.
    pub own: Vec<OwnStep>,
}

/// An estimated step of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnStep {
    /// Its size [s].
    pub size: f64,
    /// Its size in ticks.
    pub ticks: u64,
}

impl TaskGraph {
    /// One line a task, stage by stage; inside of the tick, if materials take steps of their own.
    pub fn to_text(&self, cycle: &Cycle) -> String {
        let mut out = String::new();
        let indent = if let Some(most) = cycle.most {
            let _ = writeln!(out, "step: until all materials are together again");
            let _ = writeln!(out, "  {}", self.estimate(cycle));
            let times = if most == 1 { "once".to_owned() } else { format!("repeated, at most {most} times") };
            let _ = writeln!(out, "  tick: {times}");
            "    "
        } else {
            ""
        };
        for (number, phase) in self.phases.iter().enumerate() {
            for stage in &phase.stages {
                let material =
                    stage.material.map_or(String::new(), |m| format!(" of {}", self.recipe.materials[m]));
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
                let _ = writeln!(out, "{indent}phase {number}: {how}{material}{when}");
                for &node in &stage.nodes {
                    let declaration = &self.graph[node].declaration;
                    let near =
                        if declaration.domain == Domain::NearParticles { " (near others)" } else { "" };
                    let (reads, writes) = describe(declaration.access);
                    let _ = writeln!(out, "{indent}  {:<20}{reads} -> {writes}{near}", declaration.name);
                }
            }
        }
        let carried: Vec<&str> = self.carried.iter().map(|l| l.name()).collect();
        let next = if cycle.most.is_some() { "tick" } else { "step" };
        let _ = writeln!(out, "carried to the next {next}: {}", carried.join(", "));
        let pruned = if self.pruned.is_empty() { "nothing".to_owned() } else { self.pruned.join(", ") };
        let _ = writeln!(out, "pruned: {pruned}");
        out
    }

    /// The estimated steps of the materials, in a line.
    fn estimate(&self, cycle: &Cycle) -> String {
        let one = |(name, own): (&String, &OwnStep)| match own.ticks {
            1 => format!("{name} 1 tick"),
            n => format!("{name} {n} ticks ({:.3e} s)", own.size),
        };
        let steps: Vec<String> = self.recipe.materials.iter().zip(&cycle.own).map(one).collect();
        format!(
            "rates (estimates at rest; the run decides anew each step): tick {:.3e} s; {}",
            cycle.tick,
            steps.join(", ")
        )
    }

    /// Tasks, stages, edges and rates as JSON.
    pub fn to_json(&self, cycle: &Cycle) -> Value {
        let place = |node| {
            let mut stages =
                self.phases.iter().enumerate().flat_map(|(p, ph)| ph.stages.iter().map(move |s| (p, s)));
            stages.find(|(_, s)| s.nodes.contains(&node))
        };
        let moment = |stage: &Stage| match (stage.domain, stage.when) {
            (Domain::Once | Domain::Nodes, _) => "tick",
            (_, When::Begin) => "begin",
            (_, When::End) => "end",
        };
        let tasks = self.graph.node_indices().map(|n| {
            let node = &self.graph[n];
            let access = node.declaration.access.iter().map(|a| {
                json!({ "label": a.label.name(), "unit": a.label.unit(), "mode": format!("{:?}", a.mode), "ghost": a.ghost })
            });
            json!({
                "id": n.index(), "task": node.declaration.name,
                "material": node.material.map(|m| &self.recipe.materials[m]),
                "domain": format!("{:?}", node.declaration.domain), "phase": place(n).map(|(phase, _)| phase), "when": place(n).map(|(_, stage)| moment(stage)),
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
        let own = self.recipe.materials.iter().zip(&cycle.own);
        let own = own.map(|(name, own)| json!({ "material": name, "step_s": own.size, "ticks": own.ticks }));
        let mode = if cycle.most.is_some() { "per-material" } else { "common" };
        json!({
            "rates": {
                "mode": mode, "most": cycle.most.unwrap_or(1), "tick_s": cycle.tick,
                "estimated_at_rest": own.collect::<Vec<_>>(),
            },
            "tasks": tasks.collect::<Vec<_>>(), "edges": edges.collect::<Vec<_>>(), "pruned": self.pruned,
            "carried": self.carried.iter().map(|l| l.name()).collect::<Vec<_>>(),
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
