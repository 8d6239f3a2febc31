//! Hazards between graphs and rounds: labels that are read where nobody has left them whole.
use super::follow::{Course, LabelRead, Written, follow};
use super::{Loop, Program};
use crate::graph::build::TaskGraph;
use crate::graph::task::{Domain, Mode};
use crate::schema::{Crossing, Home, LabelId, Life};
use std::fmt;

/// A task that reads a label which its graph has not written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Site {
    /// The graph.
    pub graph: String,
    /// The task.
    pub task: String,
    /// The label.
    pub label: LabelId,
}

/// What is wrong between graphs, or between the rounds of a loop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RoundHazard {
    /// No graph before, in this round or the one before, leaves it, and no step before carries it.
    NotLeft(Site),
    /// In the first round nobody has left it; later ones find what a round leaves.
    FirstRound {
        /// Who reads what.
        site: Site,
        /// The graph of the round that leaves it.
        from: String,
    },
    /// An earlier graph, or the round before, writes it, but it does not live so long.
    ShortLived {
        /// Who reads what.
        site: Site,
        /// The graph that writes it.
        from: String,
    },
    /// Nodes had it before particles went to other blocks: nodes that are new do not have it.
    Moved {
        /// Who reads what.
        site: Site,
        /// The graph that leaves it.
        from: String,
        /// The graph that moves particles.
        by: String,
    },
    /// It is read with ghosts, and no exchange brings those that other patches have.
    NotSent(Site),
    /// No round computes the label that ends a loop.
    Endless {
        /// The label.
        label: LabelId,
        /// The graphs of a round.
        graphs: Vec<String>,
    },
}

impl fmt::Display for Site {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of graph {} reads {}", self.task, self.graph, self.label.name())
    }
}

impl fmt::Display for RoundHazard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotLeft(site) => write!(
                f,
                "not left: {site}, which neither a task before it, nor an earlier graph, nor the last step leaves: compute it before, or let it be carried"
            ),
            Self::FirstRound { site, from } => write!(
                f,
                "first round: {site}, which graph {from} leaves for the next round, but nobody for the first: compute it before the loop, too"
            ),
            Self::ShortLived { site, from } => write!(
                f,
                "short-lived: {site} of graph {from}, but it lives for a {}: let it live for a step",
                span(site.label.life())
            ),
            Self::Moved { site, from, by } => write!(
                f,
                "moved: {site} of graph {from}, but graph {by} moves particles in between, and nodes that they come to do not have it: compute it after that"
            ),
            Self::NotSent(site) => write!(
                f,
                "not sent: {site} with ghosts, but no exchange before it brings those of other patches: let it live for a step"
            ),
            Self::Endless { label, graphs } => write!(
                f,
                "endless: a loop waits for {}, which no task of a round computes (graphs {}): compute it there",
                label.name(),
                graphs.join(", ")
            ),
        }
    }
}

fn span(life: Life) -> &'static str {
    match life {
        Life::Chunk => "chunk",
        Life::Stage => "stage",
        Life::Tick => "graph",
        Life::Step | Life::Carried => "step",
    }
}

/// All hazards between the graphs and rounds of a program.
pub fn hazards(program: &Program) -> Vec<RoundHazard> {
    let course = follow(program);
    let mut found = Vec::new();
    for read in &course.reads {
        let hazard = hazard(&course, read);
        found.extend(hazard.filter(|hazard| !found.contains(hazard)));
    }
    found.extend(program.loops().into_iter().filter_map(endless));
    found
}

fn hazard(course: &Course<'_>, read: &LabelRead) -> Option<RoundHazard> {
    let (graph, label) = (course.graphs[read.graph], read.access.label);
    if begins(graph, read) {
        return None;
    }
    let name = |number: usize| course.graphs[number].name.to_owned();
    let site = Site { graph: name(read.graph), task: graph.graph[read.task].name.clone(), label };
    let Some(Written { graph: from, moved }) = read.from else {
        return nobody(course, read, site);
    };
    match (label.life(), moved) {
        (Life::Carried, _) => (!sent(graph, read)).then_some(RoundHazard::NotSent(site)),
        (Life::Chunk | Life::Stage | Life::Tick, _) => {
            Some(RoundHazard::ShortLived { site, from: name(from) })
        }
        (Life::Step, Some(by)) => Some(RoundHazard::Moved { site, from: name(from), by: name(by) }),
        (Life::Step, None) => (!sent(graph, read)).then_some(RoundHazard::NotSent(site)),
    }
}

/// Where materials take steps of their own, tasks over nodes are told where one begins, and begin what they modify there.
fn begins(graph: &TaskGraph, read: &LabelRead) -> bool {
    let nodes = graph.graph[read.task].declaration.domain == Domain::Nodes;
    let modifies = nodes && read.access.label.home() == Home::Node && read.access.mode == Mode::Modifies;
    modifies && graph.schema().roles.rates.is_some()
}

/// Nobody has left it in this step: what the last step carries is there; what only a later graph leaves is missing once.
fn nobody(course: &Course<'_>, read: &LabelRead, site: Site) -> Option<RoundHazard> {
    if site.label.life() == Life::Carried {
        return None;
    }
    let same =
        |other: &&LabelRead| (other.graph, other.task, other.access) == (read.graph, read.task, read.access);
    let later = course.reads.iter().filter(same).find_map(|other| other.from);
    let brief = || in_vain(course, read).filter(|_| site.label.life() < Life::Step);
    match later.map(|left| left.graph).or_else(brief).map(|from| course.graphs[from].name.to_owned()) {
        Some(from) if site.label.life() < Life::Step => Some(RoundHazard::ShortLived { site, from }),
        Some(from) => Some(RoundHazard::FirstRound { site, from }),
        None => Some(RoundHazard::NotLeft(site)),
    }
}

/// Another graph whose recipe writes what a read wants: if it lives too short, nobody there reads it, and the task is pruned.
fn in_vain(course: &Course<'_>, read: &LabelRead) -> Option<usize> {
    let writes = |number: &usize| {
        let entries = &course.graphs[*number].recipe.entries;
        let mut access = entries.iter().flat_map(|entry| entry.task.declaration().access);
        *number != read.graph && access.any(|a| a.label == read.access.label && a.mode.writes())
    };
    let (before, after) = (0..read.graph, read.graph..course.graphs.len());
    before.rev().chain(after.rev()).find(writes)
}

/// Whether the ghosts that a task reads of what an earlier graph left have been sent.
fn sent(graph: &TaskGraph, read: &LabelRead) -> bool {
    let label = read.access.label;
    let phase =
        graph.phases.iter().position(|phase| phase.stages.iter().any(|s| s.nodes.contains(&read.task)));
    let mut opening = graph.exchanges.iter().filter(|exchange| exchange.from.is_none());
    read.access.ghost == 0
        || !matches!(label.crossing(), Crossing::Values(_))
        || opening
            .any(|exchange| exchange.labels.contains(&label) && phase.is_some_and(|it| exchange.to <= it))
}

fn endless(it: &Loop) -> Option<RoundHazard> {
    let graphs = it.graphs();
    let names = || graphs.iter().map(|graph| graph.name.to_owned()).collect();
    let computed = graphs.iter().any(|graph| graph.computes(it.until));
    (!computed).then(|| RoundHazard::Endless { label: it.until, graphs: names() })
}
