//! The graph as it is shown: tasks and exchanges as items in columns, with what passes between them. Collapsed, a task is
//! one item; expanded, it is one a patch, and exchanges are one a rank or pair of ranks.
mod build;
mod chart;
mod cost;
mod critical;
mod dot;
mod edges;
pub mod export;
mod json;
mod layout;
mod select;
mod svg;
mod text;
mod words;

pub use chart::Chart;
pub use cost::ESTIMATE;
pub use select::MOST_DRAWN;

use crate::output::trace::measured::Measured;
use crate::simulation::rates::Cycle;
use engine::graph::build::TaskGraph;
use engine::graph::recipe::Why;
use engine::graph::traffic::{Messages, Traffic};
use engine::schema::LabelId;
use export::Shown;
use petgraph::stable_graph::NodeIndex;

/// What an item is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// A task.
    Task(NodeIndex),
    /// What a phase needs of other patches.
    Halo(usize),
    /// What a phase needs of all blocks together; `None`: at the end of the tick.
    Reduction(Option<usize>),
    /// Particles that go to other blocks.
    Relocation,
}

/// How a step runs a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Runs {
    /// Once, and nothing else.
    Alone,
    /// Once, among others.
    Once,
    /// In the rounds of a loop.
    Rounds,
}

/// A node of the diagram.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Unique in the diagram.
    pub id: String,
    /// What it is.
    pub kind: Kind,
    /// Task, or exchange with its labels.
    pub name: String,
    /// Labels that are exchanged.
    pub labels: Vec<LabelId>,
    /// Its material, if it has one.
    pub material: Option<usize>,
    /// Its column.
    pub column: usize,
    /// Its box.
    pub group: usize,
    /// Its patch, in an expanded diagram.
    pub patch: Option<usize>,
    /// Its rank, in an expanded diagram; the sender of a halo.
    pub rank: Option<usize>,
    /// The rank that a halo goes to.
    pub to_rank: Option<usize>,
    /// Particles or nodes that it runs over.
    pub work: u64,
    /// Messages that it stands for, all ranks together.
    pub messages: Messages,
    /// What it takes, measured in a step or estimated for one round [ns].
    pub cost: f64,
    /// Idle time of workers beside it in a step [ns], if measured.
    pub idle: Option<f64>,
    /// Where `cost` is from.
    pub source: Source,
    /// Whether it lies on the critical path.
    pub critical: bool,
}

/// Where a time is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// From what it touches.
    Estimated,
    /// The share of a stage's measured time that a task has in an estimate.
    Split,
    /// From a trace.
    Measured,
}

impl Source {
    /// In a word.
    pub fn word(self) -> &'static str {
        match self {
            Source::Estimated => "estimated",
            Source::Split => "split",
            Source::Measured => "measured",
        }
    }
}

/// Something that passes from item to item, or keeps their order.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Index of the source.
    pub from: usize,
    /// Index of the target.
    pub to: usize,
    /// The label.
    pub label: LabelId,
    /// Whose; `None` for what belongs to no material.
    pub material: Option<usize>,
    /// Why it is there.
    pub why: Why,
    /// Ghost layers.
    pub ghost: u8,
    /// Bytes that pass.
    pub bytes: u64,
    /// Whether it lies on the critical path.
    pub critical: bool,
}

/// Items that are drawn in one box: a fused stage, or exchanges.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// Title.
    pub title: String,
    /// Its column.
    pub column: usize,
    /// Its lane.
    pub lane: usize,
    /// Its items, in order.
    pub items: Vec<usize>,
    /// Whether it is a fused stage.
    pub stage: bool,
}

/// A row of boxes through all columns: everything; or what every tick has, and what waits; or a patch; or a rank.
#[derive(Clone, Debug, PartialEq)]
pub struct Lane {
    /// Title; may be empty.
    pub title: String,
    /// The rank of a patch.
    pub rank: Option<usize>,
}

/// Tasks, exchanges, and what passes between them.
pub struct Diagram<'a> {
    /// The graph that it shows.
    pub graph: &'a TaskGraph,
    /// How steps nest.
    pub cycle: &'a Cycle,
    /// What patches and ranks send each other.
    pub traffic: &'a Traffic,
    /// Measured times, if there are any.
    pub measured: Option<&'a Measured>,
    /// How other times are estimated, in words.
    pub estimate: String,
    /// Whether a task is one item a patch.
    pub expanded: bool,
    /// How a step runs the graph.
    pub runs: Runs,
    /// What ids begin with.
    pub prefix: String,
    /// Titles of the columns.
    pub columns: Vec<String>,
    /// The lanes.
    pub lanes: Vec<Lane>,
    /// The boxes.
    pub groups: Vec<Group>,
    /// The nodes.
    pub items: Vec<Item>,
    /// The edges.
    pub links: Vec<Link>,
    /// Items of the critical path, in order.
    pub path: Vec<usize>,
    /// What it takes [ns].
    pub path_ns: f64,
}

impl Diagram<'_> {
    /// The graph alone.
    fn shown(&self) -> Shown<'_> {
        Shown { graph: self.graph, cycle: self.cycle }
    }

    /// What times of items and of the critical path are about.
    pub fn span(&self) -> &'static str {
        match (self.runs, self.measured) {
            (Runs::Alone, _) => "a step",
            (Runs::Once, _) => "its run in a step",
            (Runs::Rounds, None) => "one round",
            (Runs::Rounds, Some(_)) => "a step, all its rounds together",
        }
    }

    /// What an item does: the sentence of its task, or what an exchange is for.
    pub fn about(&self, item: &Item) -> &'static str {
        match item.kind {
            Kind::Task(node) => self.graph.graph[node].declaration.about,
            kind => words::about(kind),
        }
    }

    /// The items of a kind.
    pub fn of(&self, kind: Kind) -> impl Iterator<Item = &Item> {
        self.items.iter().filter(move |item| item.kind == kind)
    }

    /// The name of a material.
    fn material(&self, material: Option<usize>) -> &str {
        material.map_or("", |m| &self.graph.recipe.materials[m])
    }

    /// Name, material and place of an item in a line.
    pub fn title(&self, item: &Item) -> String {
        let mut title = item.name.clone();
        if let Some(m) = item.material {
            title += &format!("[{}]", self.graph.recipe.materials[m]);
        }
        match (item.patch, item.rank, item.to_rank) {
            (Some(patch), Some(rank), _) => title += &format!(" on patch {patch}, rank {rank}"),
            (_, Some(rank), Some(to)) => title += &format!(" from rank {rank} to {to}"),
            (_, Some(rank), _) => title += &format!(" on rank {rank}"),
            _ => {}
        }
        title
    }
}

/// Bytes for people.
pub fn bytes(bytes: u64) -> String {
    match bytes as f64 {
        b if b < 1e3 => format!("{bytes} B"),
        b if b < 1e6 => format!("{:.1} kB", b / 1e3),
        b if b < 1e9 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.2} GB", b / 1e9),
    }
}

/// Nanoseconds for people.
pub fn time(ns: f64) -> String {
    match ns {
        ns if ns < 1e3 => format!("{ns:.0} ns"),
        ns if ns < 1e6 => format!("{:.1} µs", ns / 1e3),
        ns if ns < 1e9 => format!("{:.2} ms", ns / 1e6),
        ns => format!("{:.2} s", ns / 1e9),
    }
}
