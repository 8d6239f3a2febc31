//! What runs, as a small tree: graphs in sequence, and loops until a label says that it is enough. A step of an explicit
//! method is one, with the ticks of materials that take steps of their own as a loop; so are a Newton iteration around a
//! Krylov iteration, and constraints between bodies that converge.
mod check;
mod follow;
mod outline;
mod pass;

pub use check::{RoundHazard, Site, hazards};
pub use pass::{Delay, Pass, passes};

use crate::graph::build::TaskGraph;
use crate::graph::error::GraphError;
use crate::graph::recipe::Recipe;
use crate::graph::usage;
use crate::schema::{Combine, Home, LabelId, Life};
use std::collections::BTreeSet;

/// A named sequence of graphs and loops.
pub struct Program {
    /// Its name in dumps.
    pub name: String,
    /// What it does, in order.
    pub nodes: Vec<ProgramNode>,
}

/// A part of a program.
pub enum ProgramNode {
    /// Runs a graph once.
    Graph(Box<TaskGraph>),
    /// Runs some parts again and again.
    Loop(Loop),
}

/// A loop.
pub struct Loop {
    /// What a round does.
    pub body: Vec<ProgramNode>,
    /// A label of the run that a round computes: the loop ends with the round that leaves another first number than zero.
    pub until: LabelId,
    /// The most rounds; what happens when they were not enough is for the application to say.
    pub most: u64,
}

/// A program before its graphs are built.
pub enum Script {
    /// A graph by name.
    Graph(&'static str, Recipe),
    /// A loop.
    Loop {
        /// What a round does.
        body: Vec<Script>,
        /// See [`Loop::until`].
        until: LabelId,
        /// See [`Loop::most`].
        most: u64,
    },
}

impl Program {
    /// Builds the graphs of a script on `patches` patches. `outputs` are wanted besides what later graphs, rounds and steps read.
    ///
    /// # Errors
    /// What a graph refuses, and a loop that waits for a label that is none of the run.
    pub fn build(
        name: &str,
        script: Vec<Script>,
        outputs: &[LabelId],
        patches: usize,
    ) -> Result<Self, GraphError> {
        let (program, refusals) = Self::inspect(name, script, outputs, patches);
        match refusals.into_iter().next() {
            Some(refusal) => Err(refusal),
            None => Ok(program),
        }
    }

    /// The program of a script with all that is to be refused in it. A program that is refused shows what is there; it must
    /// not run.
    pub fn inspect(
        name: &str,
        script: Vec<Script>,
        outputs: &[LabelId],
        patches: usize,
    ) -> (Self, Vec<GraphError>) {
        let mut wanted: BTreeSet<LabelId> = outputs.iter().copied().collect();
        script.iter().for_each(|part| part.wants(&mut wanted));
        let wanted: Vec<LabelId> = wanted.into_iter().collect();
        let mut refusals = Vec::new();
        let nodes = script.into_iter().map(|part| part.inspect(&wanted, patches, &mut refusals)).collect();
        let mut program = Self { name: name.to_owned(), nodes };
        program.graphs_mut().into_iter().enumerate().for_each(|(number, graph)| graph.number = number);
        (program, refusals)
    }

    /// A program of one graph.
    pub fn of(name: &str, graph: TaskGraph) -> Self {
        Self { name: name.to_owned(), nodes: vec![ProgramNode::Graph(Box::new(graph))] }
    }

    /// All its graphs, in order.
    pub fn graphs(&self) -> Vec<&TaskGraph> {
        let mut graphs = Vec::new();
        self.nodes.iter().for_each(|node| node.graphs(&mut graphs));
        graphs
    }

    /// All its graphs, in order, to change what is known of them.
    pub fn graphs_mut(&mut self) -> Vec<&mut TaskGraph> {
        let mut graphs = Vec::new();
        self.nodes.iter_mut().for_each(|node| node.graphs_mut(&mut graphs));
        graphs
    }

    /// All its loops, outer ones before those in them.
    pub fn loops(&self) -> Vec<&Loop> {
        let mut loops = Vec::new();
        self.nodes.iter().for_each(|node| node.loops(&mut loops));
        loops
    }

    /// The only graph of a program that has one.
    ///
    /// # Panics
    /// Never: a program has a graph.
    pub fn main_graph(&self) -> &TaskGraph {
        self.graphs()[0]
    }

    /// The same, without the rest.
    pub fn into_main_graph(mut self) -> TaskGraph {
        loop {
            match self.nodes.swap_remove(0) {
                ProgramNode::Graph(graph) => return *graph,
                ProgramNode::Loop(it) => self.nodes = it.body,
            }
        }
    }

    /// Labels that its graphs use.
    pub fn labels(&self) -> BTreeSet<LabelId> {
        self.graphs().into_iter().flat_map(TaskGraph::labels).collect()
    }

    /// Particle labels of a material that its graphs use.
    pub fn particle_labels(&self, material: usize) -> BTreeSet<LabelId> {
        self.graphs().into_iter().flat_map(|graph| graph.particle_labels(material)).collect()
    }
}

impl Script {
    /// What the graphs of the script read before they write it, and what loops wait for: earlier ones must leave it.
    fn wants(&self, wanted: &mut BTreeSet<LabelId>) {
        match self {
            Script::Graph(_, recipe) => {
                let access = recipe.entries.iter().flat_map(|entry| entry.task.declaration().access);
                let outlives = |label: LabelId| label.home() != Home::Chunk && label.life() >= Life::Step;
                wanted.extend(access.filter(|a| a.mode.reads() && outlives(a.label)).map(|a| a.label));
            }
            Script::Loop { body, until, .. } => {
                wanted.insert(*until);
                body.iter().for_each(|part| part.wants(wanted));
            }
        }
    }

    fn inspect(self, wanted: &[LabelId], patches: usize, refusals: &mut Vec<GraphError>) -> ProgramNode {
        match self {
            Script::Graph(name, recipe) => {
                let (graph, refused) = TaskGraph::inspect(recipe, wanted, patches);
                refusals.extend(refused);
                refusals.extend(usage::moves_unseen(&graph.graph, &graph.schema().roles));
                ProgramNode::Graph(Box::new(graph.named(name)))
            }
            Script::Loop { body, until, most } => {
                if until.home() != Home::Run || until.combine() != Combine::None {
                    refusals.push(GraphError::UntilWhat { label: until });
                }
                if most == 0 {
                    refusals.push(GraphError::NoRounds { label: until });
                }
                let body = body.into_iter().map(|part| part.inspect(wanted, patches, refusals)).collect();
                ProgramNode::Loop(Loop { body, until, most })
            }
        }
    }
}

impl Loop {
    /// The graphs of a round, in order.
    pub fn graphs(&self) -> Vec<&TaskGraph> {
        let mut graphs = Vec::new();
        self.body.iter().for_each(|node| node.graphs(&mut graphs));
        graphs
    }
}

impl ProgramNode {
    fn graphs<'a>(&'a self, graphs: &mut Vec<&'a TaskGraph>) {
        match self {
            ProgramNode::Graph(graph) => graphs.push(graph),
            ProgramNode::Loop(it) => it.body.iter().for_each(|node| node.graphs(graphs)),
        }
    }
    fn graphs_mut<'a>(&'a mut self, graphs: &mut Vec<&'a mut TaskGraph>) {
        match self {
            ProgramNode::Graph(graph) => graphs.push(graph),
            ProgramNode::Loop(it) => it.body.iter_mut().for_each(|node| node.graphs_mut(graphs)),
        }
    }

    fn loops<'a>(&'a self, loops: &mut Vec<&'a Loop>) {
        if let ProgramNode::Loop(it) = self {
            loops.push(it);
            it.body.iter().for_each(|node| node.loops(loops));
        }
    }
}
