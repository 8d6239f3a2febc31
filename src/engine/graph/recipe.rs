//! What a recipe is, and the nodes and edges that come of it.
use super::task::{Declaration, Domain, Runnable};
use crate::schema::{LabelId, Schema, Tiles};
use petgraph::stable_graph::StableDiGraph;

/// One line of a recipe.
pub struct RecipeLine {
    /// The task.
    pub task: Box<dyn Runnable>,
    /// The material whose particles it runs over; `None`: all materials, or none.
    pub material: Option<usize>,
    /// Dotted key of the scene line that asked for it; empty: every simulation needs it.
    pub because: String,
}

/// Tasks in the order of the algorithm.
pub struct Recipe {
    /// All labels of the application.
    pub schema: &'static Schema,
    /// The lines.
    pub entries: Vec<RecipeLine>,
    /// Names of the materials, for messages and dumps.
    pub materials: Vec<String>,
    /// How many tiles labels have whose rows leave that open.
    pub tiles: Tiles,
}

impl Recipe {
    /// A recipe without lines.
    pub fn new(schema: &'static Schema, materials: Vec<String>) -> Self {
        Self { schema, entries: Vec::new(), materials, tiles: Tiles::default() }
    }

    /// Adds a task over the particles of a material. `because` is the dotted key of the scene line that asked for it.
    pub fn add(&mut self, material: usize, because: &str, task: impl Runnable + 'static) {
        self.push(Some(material), because, task);
    }

    /// Adds a task over the nodes of all fields, or once.
    pub fn all(&mut self, because: &str, task: impl Runnable + 'static) {
        self.push(None, because, task);
    }

    /// A label has so many tiles; all recipes of a warehouse say the same.
    ///
    /// # Panics
    /// See [`Tiles::set`].
    pub fn tiles(&mut self, label: LabelId, count: usize) {
        self.tiles.set(label, count);
    }

    fn push(&mut self, material: Option<usize>, because: &str, task: impl Runnable + 'static) {
        let because = because.to_owned();
        self.entries.push(RecipeLine { task: Box::new(task), material, because });
    }
}

/// Why an edge is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Why {
    /// Reads what the source wrote.
    Flow,
    /// Overwrites what the source read.
    WriteAfterRead,
    /// Overwrites, or adds to, what the source wrote.
    WriteAfterWrite,
}

impl Why {
    /// What it is for, in a word.
    pub fn name(self) -> &'static str {
        match self {
            Why::Flow => "flow",
            Why::WriteAfterRead => "write after read",
            Why::WriteAfterWrite => "write after write",
        }
    }
}

/// A derived dependency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The label.
    pub label: LabelId,
    /// Whose.
    pub material: usize,
    /// Why.
    pub why: Why,
    /// Ghost layers that the target reads.
    pub ghost: u8,
}

/// A task in the graph.
#[derive(Clone, Debug)]
pub struct TaskNode {
    /// What it declared.
    pub declaration: Declaration,
    /// Its line of the recipe.
    pub entry: usize,
    /// Its material, if it runs over one.
    pub material: Option<usize>,
    /// Name with the material, for messages.
    pub name: String,
}

/// The dependency graph over tasks.
pub type Graph = StableDiGraph<TaskNode, Edge>;

/// Whether the task runs over particles, or what they add and read.
pub fn over_particles(domain: Domain) -> bool {
    matches!(domain, Domain::Particles | Domain::NearParticles | Domain::Buffers)
}

/// All of `patches` patches, in messages.
pub fn everywhere(patches: usize) -> String {
    match patches {
        1 => "patch 0".to_owned(),
        n => format!("patches 0 to {}", n - 1),
    }
}
