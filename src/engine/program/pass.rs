//! What passes between graphs: labels that one leaves and another reads, or the same in the next round.
use super::Program;
use super::follow::{Course, LabelRead, follow, keys};
use crate::graph::build::TaskGraph;
use crate::schema::{Home, LabelId, Life};
use petgraph::stable_graph::NodeIndex;
use std::collections::BTreeMap;

/// When what a graph leaves is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Delay {
    /// By a later graph.
    Onward,
    /// In the next round of the innermost loop around both graphs.
    NextRound,
    /// In the next step.
    NextStep,
}

impl Delay {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Delay::Onward => "onward",
            Delay::NextRound => "next round",
            Delay::NextStep => "next step",
        }
    }
}

/// A label that passes from graph to graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pass {
    /// The graph that leaves it, by its number in [`Program::graphs`].
    pub from: usize,
    /// The graph that reads it before it writes it.
    pub to: usize,
    /// When.
    pub delay: Delay,
    /// The label.
    pub label: LabelId,
    /// Whose; `None` for what belongs to no material.
    pub material: Option<usize>,
    /// The tasks that write it last.
    pub writers: Vec<NodeIndex>,
    /// The tasks that read it first.
    pub readers: Vec<NodeIndex>,
}

/// All that passes between the graphs of a program, in the order of reading.
pub fn passes(program: &Program) -> Vec<Pass> {
    let course = follow(program);
    let mut passes: BTreeMap<(usize, usize, Delay, LabelId, usize), Vec<NodeIndex>> = BTreeMap::new();
    for read in &course.reads {
        if let Some((from, delay)) = source(&course, read) {
            let key = (read.graph, from, delay, read.access.label, read.material);
            passes.entry(key).or_default().push(read.task);
        }
    }
    let pass = |((to, from, delay, label, material), mut readers): (_, Vec<NodeIndex>)| {
        readers.dedup();
        let writers = last_writers(course.graphs[from], label, material);
        let material = (label.home() != Home::Run).then_some(material);
        Pass { from, to, delay, label, material, writers, readers }
    };
    passes.into_iter().map(pass).collect()
}

/// The graph that a read has its label from, and when.
fn source(course: &Course<'_>, read: &LabelRead) -> Option<(usize, Delay)> {
    match read.from {
        Some(left) if left.graph < read.graph => Some((left.graph, Delay::Onward)),
        Some(left) => Some((left.graph, Delay::NextRound)),
        None if read.access.label.life() < Life::Carried => None,
        None => {
            course.written.get(&(read.access.label, read.material)).map(|left| (left.graph, Delay::NextStep))
        }
    }
}

/// Tasks that write a label after which no other task of the graph does.
fn last_writers(graph: &TaskGraph, label: LabelId, material: usize) -> Vec<NodeIndex> {
    let writes = |task: NodeIndex| {
        let mut access = graph.graph[task].declaration.access.iter();
        access.any(|a| a.label == label && a.mode.writes())
            && keys(graph, task, label).contains(&(label, material))
    };
    let overwritten = |task: NodeIndex| {
        let mut after = graph.graph.neighbors(task);
        label.is_reduced() || after.all(|next| next == task || !writes(next))
    };
    graph.graph.node_indices().filter(|&task| writes(task) && overwritten(task)).collect()
}
