//! Follows a program as it runs: who has left what a graph reads before it writes it.
use super::{Loop, Program, ProgramNode};
use crate::graph::build::TaskGraph;
use crate::graph::recipe::Why;
use crate::graph::task::Access;
use crate::schema::{Home, LabelId, Life};
use petgraph::Direction;
use petgraph::stable_graph::NodeIndex;
use std::collections::BTreeMap;

/// A label, and whose; labels of the run are of material 0.
pub(super) type Key = (LabelId, usize);

/// Who has left a label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Written {
    /// The last graph that wrote it, by number.
    pub(super) graph: usize,
    /// A graph that has moved particles since.
    pub(super) moved: Option<usize>,
}

/// A task reads what no task of its graph has written before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LabelRead {
    /// The graph, by number.
    pub(super) graph: usize,
    /// The task.
    pub(super) task: NodeIndex,
    /// How.
    pub(super) access: Access,
    /// Whose label.
    pub(super) material: usize,
    /// Who has left it in this step.
    pub(super) from: Option<Written>,
}

/// A program that has been followed through a step.
pub(super) struct Course<'a> {
    /// Its graphs.
    pub(super) graphs: Vec<&'a TaskGraph>,
    /// All reads, each once from each source.
    pub(super) reads: Vec<LabelRead>,
    /// What is left at the end.
    pub(super) written: BTreeMap<Key, Written>,
}

/// Follows a program. Two rounds of a loop tell all: later ones find what the second finds.
pub(super) fn follow(program: &Program) -> Course<'_> {
    let mut course = Course { graphs: program.graphs(), reads: Vec::new(), written: BTreeMap::new() };
    course.nodes(&program.nodes, 0);
    course
}

impl Course<'_> {
    /// Follows parts of which the first graph has the number `next`; returns the number after the last one.
    fn nodes(&mut self, nodes: &[ProgramNode], mut next: usize) -> usize {
        for node in nodes {
            next = match node {
                ProgramNode::Graph(_) => self.graph(next),
                ProgramNode::Loop(it) => self.rounds(it, next),
            };
        }
        next
    }

    fn rounds(&mut self, it: &Loop, first: usize) -> usize {
        let next = self.nodes(&it.body, first);
        if it.most > 1 { self.nodes(&it.body, first) } else { next }
    }

    fn graph(&mut self, number: usize) -> usize {
        let graph = self.graphs[number];
        for (task, access) in reads_first(graph) {
            self.read(number, task, access);
        }
        for (task, node) in graph.graph.node_indices().map(|task| (task, &graph.graph[task])) {
            for access in node.declaration.access.iter().filter(|a| a.mode.writes()) {
                for key in keys(graph, task, access.label) {
                    self.written.insert(key, Written { graph: number, moved: None });
                }
            }
        }
        if graph.moves_particles() {
            let nodes = self.written.iter_mut().filter(|((label, _), _)| label.home() == Home::Node);
            nodes.for_each(|(_, left)| left.moved = Some(number));
        }
        number + 1
    }

    /// A task of all materials reads those that somebody has left, and none if nobody has left any.
    fn read(&mut self, graph: usize, task: NodeIndex, access: Access) {
        let keys = keys(self.graphs[graph], task, access.label);
        let found: Vec<_> = keys.iter().filter_map(|key| Some((key.1, *self.written.get(key)?))).collect();
        let mut add = |material, from| {
            let read = LabelRead { graph, task, access, material, from };
            if !self.reads.contains(&read) {
                self.reads.push(read);
            }
        };
        match (&found[..], keys.first()) {
            ([], Some(&(_, material))) => add(material, None),
            _ => found.into_iter().for_each(|(material, left)| add(material, Some(left))),
        }
    }
}

/// What a task's access concerns.
pub(super) fn keys(graph: &TaskGraph, task: NodeIndex, label: LabelId) -> Vec<Key> {
    match (label.home(), graph.graph[task].material) {
        (Home::Chunk, _) => Vec::new(),
        (Home::Run, _) => vec![(label, 0)],
        (_, Some(material)) => vec![(label, material)],
        (_, None) => (0..graph.recipe.materials.len()).map(|material| (label, material)).collect(),
    }
}

/// What tasks read before any task of the graph writes it.
fn reads_first(graph: &TaskGraph) -> Vec<(NodeIndex, Access)> {
    let mut found = Vec::new();
    for task in graph.graph.node_indices() {
        for access in graph.graph[task].declaration.access.iter().filter(|a| a.mode.reads()) {
            let mut incoming = graph.graph.edges_directed(task, Direction::Incoming);
            let fed = incoming.any(|e| e.weight().label == access.label && e.weight().why == Why::Flow);
            if !fed && access.label.life() > Life::Chunk {
                found.push((task, *access));
            }
        }
    }
    found
}
