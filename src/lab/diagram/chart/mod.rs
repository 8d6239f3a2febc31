//! A program as it is shown: a diagram a graph, in the tree of loops, with what passes from graph to graph and round to round.
mod arrows;
mod dot;
mod flows;
mod html;
mod json;
mod place;
mod svg;
mod text;

use super::select::drawable;
use super::{Diagram, Item, Runs};
use crate::output::trace::measured::Measured;
use crate::simulation::rates::Cycle;
use engine::graph::traffic::Traffic;
use engine::program::{Pass, Program, ProgramNode, passes};

/// A program with a diagram of each of its graphs.
pub struct Chart<'a> {
    /// The program.
    pub program: &'a Program,
    /// Its graphs, in order.
    pub diagrams: Vec<Diagram<'a>>,
    /// What passes between them.
    pub passes: Vec<Pass>,
    /// The loops around each graph, outer ones first, by their number in [`Program::loops`].
    pub around: Vec<Vec<usize>>,
}

impl<'a> Chart<'a> {
    /// One item a task and exchange; expanded, one a task and patch, rank, or pair of ranks.
    pub fn new(
        program: &'a Program,
        cycle: &'a Cycle,
        traffic: &'a Traffic,
        measured: Option<&'a Measured>,
        expanded: bool,
    ) -> Self {
        let make = if expanded { Diagram::expanded } else { Diagram::collapsed };
        let graphs = program.graphs().into_iter();
        let mut diagrams: Vec<_> = graphs.map(|graph| make(graph, cycle, traffic, measured)).collect();
        let (mut around, mut path, mut next) = (Vec::new(), Vec::new(), 0);
        surround(&program.nodes, &mut path, &mut next, &mut around);
        let (loops, several) = (program.loops(), diagrams.len() > 1);
        for (number, (diagram, around)) in diagrams.iter_mut().zip(&around).enumerate() {
            diagram.runs = match around.iter().any(|&it| loops[it].most > 1) {
                true => Runs::Rounds,
                false if several => Runs::Once,
                false => Runs::Alone,
            };
            if several {
                diagram.rename(&format!("g{number}"));
            }
        }
        Self { program, diagrams, passes: passes(program), around }
    }

    /// Scales the estimates of tasks by a factor, of which `words` say where it is from.
    pub fn set_pace(&mut self, factor: f64, words: &str) {
        self.diagrams.iter_mut().for_each(|diagram| diagram.set_pace(factor, words));
    }

    /// The estimated work of all tasks, each graph once [ns].
    pub fn work_ns(&self) -> f64 {
        self.diagrams.iter().map(Diagram::work_ns).sum()
    }

    /// Keeps the items that are `wanted`, and what is next to them: see [`Diagram::keep`].
    pub fn keep(&mut self, wanted: impl Fn(&Item) -> bool) {
        self.diagrams.iter_mut().for_each(|diagram| diagram.keep(&wanted));
    }

    /// Whether there is more than one graph.
    fn several(&self) -> bool {
        self.diagrams.len() > 1
    }

    /// The name of a graph.
    fn name(&self, graph: usize) -> &str {
        self.diagrams[graph].graph.name
    }

    /// Refuses pictures of more items than anyone can look at.
    fn drawable(&self) -> Result<(), String> {
        drawable(self.diagrams.iter().map(|diagram| diagram.items.len()).sum())
    }
}

/// The loops around each graph.
fn surround(nodes: &[ProgramNode], path: &mut Vec<usize>, next: &mut usize, around: &mut Vec<Vec<usize>>) {
    for node in nodes {
        match node {
            ProgramNode::Graph(_) => around.push(path.clone()),
            ProgramNode::Loop(it) => {
                path.push(*next);
                *next += 1;
                surround(&it.body, path, next, around);
                path.pop();
            }
        }
    }
}
