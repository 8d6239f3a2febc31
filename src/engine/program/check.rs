//! Hazards between graphs and rounds: a label that is read before anybody has left it.
use super::{Loop, Node, Program};
use crate::graph::build::TaskGraph;
use crate::graph::recipe::Why;
use crate::graph::task::Mode;
use crate::schema::{Home, LabelId, Life};
use petgraph::Direction;
use std::collections::BTreeSet;
use std::fmt;

/// A label that something reads and nothing has left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RoundHazard {
    /// No graph before, in this round or the one before, leaves it, and no step before carries it.
    NotLeft {
        /// The graph.
        graph: String,
        /// A task that reads it.
        task: String,
        /// The label.
        label: LabelId,
    },
    /// An earlier graph leaves it, but it does not live so long.
    ShortLived {
        /// The graph.
        graph: String,
        /// A task that reads it.
        task: String,
        /// The label.
        label: LabelId,
    },
    /// No round computes the label that ends the loop.
    Endless {
        /// The label.
        label: LabelId,
    },
}

impl fmt::Display for RoundHazard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotLeft { graph, task, label } => write!(
                f,
                "not left: {task} of graph {graph} reads {} before it is written, and neither an earlier graph, nor the round before, nor the last step leaves it: compute it before the loop or in it",
                label.name()
            ),
            Self::ShortLived { graph, task, label } => write!(
                f,
                "short-lived: {task} of graph {graph} reads {} of an earlier graph, but it lives for a tick: let it live for a step",
                label.name()
            ),
            Self::Endless { label } => {
                write!(f, "endless: a loop waits for {}, which no task of a round computes", label.name())
            }
        }
    }
}

/// All hazards between the graphs and rounds of a program.
pub fn hazards(program: &Program) -> Vec<RoundHazard> {
    let mut found = Vec::new();
    follow(&program.nodes, &mut BTreeSet::new(), &mut found);
    found
}

/// Follows some parts; `left` are the labels that earlier parts leave.
fn follow(nodes: &[Node], left: &mut BTreeSet<LabelId>, found: &mut Vec<RoundHazard>) {
    for node in nodes {
        match node {
            Node::Graph(graph) => {
                for (task, label) in reads_first(graph) {
                    found.extend(hazard(graph, task, label, left));
                }
                left.extend(written(graph));
            }
            Node::Loop(it) => follow_loop(it, left, found),
        }
    }
}

/// In its first round a loop has what came before, in the second also what the first has left: both are followed, and what is
/// missing in the first is a hazard.
fn follow_loop(it: &Loop, left: &mut BTreeSet<LabelId>, found: &mut Vec<RoundHazard>) {
    let before = left.clone();
    follow(&it.body, left, found);
    let computed = left.contains(&it.until) && !before.contains(&it.until);
    let mut graphs = Vec::new();
    it.body.iter().for_each(|node| node.graphs(&mut graphs));
    if !computed && !graphs.iter().any(|graph| written(graph).contains(&it.until)) {
        found.push(RoundHazard::Endless { label: it.until });
    }
}

fn hazard(graph: &TaskGraph, task: String, label: LabelId, left: &BTreeSet<LabelId>) -> Option<RoundHazard> {
    let graph = graph.name.to_owned();
    match (label.life(), left.contains(&label)) {
        (Life::Carried, _) | (Life::Step, true) => None,
        (Life::Step, false) => Some(RoundHazard::NotLeft { graph, task, label }),
        (_, true) => Some(RoundHazard::ShortLived { graph, task, label }),
        (_, false) => Some(RoundHazard::NotLeft { graph, task, label }),
    }
}

/// Labels that tasks read before any task of the graph writes them, each with one such task.
fn reads_first(graph: &TaskGraph) -> Vec<(String, LabelId)> {
    let mut found: Vec<(String, LabelId)> = Vec::new();
    for node in graph.graph.node_indices() {
        for access in graph.graph[node].declaration.access {
            let mut incoming = graph.graph.edges_directed(node, Direction::Incoming);
            let fed = incoming.any(|e| e.weight().label == access.label && e.weight().why == Why::Flow);
            // who begins a label by modifying it writes all of it
            let reads = matches!(access.mode, Mode::RequiresOld | Mode::Requires);
            let chunk = access.label.home() == Home::Chunk;
            if reads && !fed && !chunk && !found.iter().any(|(_, label)| *label == access.label) {
                found.push((graph.graph[node].name.clone(), access.label));
            }
        }
    }
    found
}

fn written(graph: &TaskGraph) -> BTreeSet<LabelId> {
    let access = graph.graph.node_weights().flat_map(|node| node.declaration.access);
    access.filter(|a| a.mode.writes()).map(|a| a.label).collect()
}
