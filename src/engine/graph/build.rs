//! Edges from declarations. Recipe order is the meaning; edges only say what of it is needed.
use super::error::GraphError;
use super::exchange::{self, Exchange};
use super::fuse;
use super::phase::{Phase, Stage};
use super::prune;
use super::recipe::{Edge, Graph, Recipe, TaskNode, Why, everywhere, over_particles};
use super::task::{Access, Domain, Mode};
use super::usage;
use crate::schema::{Combine, Home, LabelId, Life, Schema};
use petgraph::stable_graph::NodeIndex;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// A graph that runs.
pub struct TaskGraph {
    /// Its name in dumps.
    pub name: &'static str,
    /// Its number in the program, in order.
    pub number: usize,
    /// The recipe it was built from.
    pub recipe: Recipe,
    /// Tasks and edges that survived pruning.
    pub graph: Graph,
    /// Fused stages, in groups that may run at the same time.
    pub phases: Vec<Phase>,
    /// The phases again, in groups that may follow one another layer by layer of blocks.
    pub waves: Vec<Range<usize>>,
    /// What ranks exchange between the phases.
    pub exchanges: Vec<Exchange>,
    /// Labels reduced over all blocks whose parts come together at the end.
    pub at_end: Vec<LabelId>,
    /// Tasks that nothing needs.
    pub pruned: Vec<String>,
    /// Labels whose value passes from step to step.
    pub carried: BTreeSet<LabelId>,
    /// Labels that are wanted besides.
    pub outputs: Vec<LabelId>,
}

impl TaskGraph {
    /// The tasks of a stage.
    pub fn tasks_of(&self, stage: &Stage) -> Vec<&'static str> {
        stage.nodes.iter().map(|&node| self.graph[node].declaration.name).collect()
    }

    /// What a stage is called: its task, or the first and the last of them.
    pub fn name_of(&self, stage: &Stage) -> String {
        match self.tasks_of(stage)[..] {
            [] => String::new(),
            [one] => one.to_owned(),
            [first, .., last] => format!("{first} … {last}"),
        }
    }

    /// Builds the graph of `recipe` on `patches` patches. `outputs` are wanted besides what the next step reads.
    ///
    /// # Errors
    /// See [`GraphError`].
    pub fn build(recipe: Recipe, outputs: &[LabelId], patches: usize) -> Result<Self, GraphError> {
        let (graph, refusals) = Self::inspect(recipe, outputs, patches);
        match refusals.into_iter().next() {
            Some(refusal) => Err(refusal),
            None => Ok(graph),
        }
    }

    /// The graph of a recipe with all that is to be refused in it. A graph that is refused shows what is there; it must
    /// not run.
    pub fn inspect(recipe: Recipe, outputs: &[LabelId], patches: usize) -> (Self, Vec<GraphError>) {
        let (mut graph, mut refusals) = derive(&recipe, patches);
        let (pruned, carried) = prune::prune(&mut graph, outputs);
        let (mut phases, escapes) = fuse::fuse(&graph, &recipe, patches);
        refusals.extend(escapes);
        let (exchanges, mut at_end) = exchange::derive(recipe.schema, &mut phases);
        // what nobody reads, and no checkpoint, need not come together: a label that this recipe fills in vain
        at_end.retain(|label| {
            carried.contains(label) || outputs.contains(label) || label.life() == Life::Carried
        });
        refusals.extend(usage::escapes(&graph, &phases, patches));
        refusals.extend(usage::never_summed(&graph, &phases));
        refusals.extend(usage::added_after_move(&graph, &phases, recipe.schema.roles.extent));
        refusals.extend(usage::added_after_reduction(&graph, &phases));
        let waves = fuse::waves(&phases);
        let outputs = outputs.to_vec();
        (
            Self {
                name: "",
                number: 0,
                recipe,
                graph,
                phases,
                waves,
                exchanges,
                at_end,
                pruned,
                carried,
                outputs,
            },
            refusals,
        )
    }

    /// The same, with a name.
    pub fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// Whether it moves particles, so that they may have to change their block, patch and rank.
    pub fn moves_particles(&self) -> bool {
        self.computes(self.schema().roles.extent)
    }

    /// Whether some task writes a label.
    pub fn computes(&self, label: LabelId) -> bool {
        let mut stages = self.phases.iter().flat_map(|phase| &phase.stages);
        stages.any(|stage| stage.touches(label, Mode::writes))
    }

    /// Whether a phase before the given one (`None`: any) contributes to a shared label, for a material (0 for labels of the run).
    pub fn contributes(&self, before: Option<usize>, label: LabelId, material: usize) -> bool {
        let phases = &self.phases[..before.unwrap_or(self.phases.len())];
        phases.iter().any(|phase| phase.afresh.contains(&(label, material)))
    }

    /// All labels of the application.
    pub fn schema(&self) -> &'static Schema {
        self.recipe.schema
    }

    /// Labels that the surviving tasks use.
    pub fn labels(&self) -> BTreeSet<LabelId> {
        self.graph.node_weights().flat_map(|n| n.declaration.access.iter().map(|a| a.label)).collect()
    }

    /// Particle labels that the surviving tasks of `material` use.
    pub fn particle_labels(&self, material: usize) -> BTreeSet<LabelId> {
        let mine = self.graph.node_weights().filter(|n| n.material == Some(material));
        let labels = mine.flat_map(|n| n.declaration.access.iter().map(|a| a.label));
        labels.filter(|l| l.home() == Home::Particle).collect()
    }
}

/// What has happened to one label of one material so far in the recipe.
#[derive(Default)]
struct Slot {
    writers: Vec<NodeIndex>,
    readers: Vec<NodeIndex>,
    /// Those of the readers that adapt copies of it.
    adapters: Vec<NodeIndex>,
}

type Key = (LabelId, usize);

struct Derivation<'a> {
    recipe: &'a Recipe,
    graph: Graph,
    slots: BTreeMap<Key, Slot>,
    everywhere: String,
}

fn derive(recipe: &Recipe, patches: usize) -> (Graph, Vec<GraphError>) {
    let (graph, slots, everywhere) = (Graph::new(), BTreeMap::new(), everywhere(patches));
    let mut derivation = Derivation { recipe, graph, slots, everywhere };
    let mut refusals = Vec::new();
    for (index, entry) in recipe.entries.iter().enumerate() {
        let declaration = entry.task.declaration();
        let name = match entry.material {
            Some(m) => format!("{}[{}]", declaration.name, recipe.materials[m]),
            None => declaration.name.to_owned(),
        };
        let node = TaskNode { declaration, entry: index, material: entry.material, name };
        let node = derivation.graph.add_node(node);
        for (at, access) in declaration.access.iter().enumerate() {
            if declaration.access[..at].iter().any(|other| other.label == access.label) {
                let task = derivation.graph[node].name.clone();
                refusals.push(GraphError::DeclaredTwice { task, label: access.label });
            }
        }
        for access in declaration.access.iter().filter(|a| a.mode != Mode::Scratch) {
            refusals.extend(derivation.check_ghost(node, access).err());
            refusals.extend(usage::check(&derivation.graph[node], access).err());
            refusals.extend(derivation.add_access(node, access).err());
        }
    }
    (derivation.graph, refusals)
}

impl Derivation<'_> {
    fn name(&self, node: NodeIndex) -> String {
        self.graph[node].name.clone()
    }

    fn check_ghost(&self, node: NodeIndex, access: &Access) -> Result<(), GraphError> {
        let stored = access.label.ghosts();
        if access.ghost <= stored {
            return Ok(());
        }
        let (task, label, asked) = (self.name(node), access.label, access.ghost);
        Err(GraphError::GhostTooWide { task, label, asked, stored, patch: 0 })
    }

    /// The slots that an access concerns: a particle task's own material, or all.
    fn keys(&self, node: NodeIndex, label: LabelId) -> Vec<Key> {
        match (label.home(), self.graph[node].material) {
            (Home::Run, _) => vec![(label, 0)],
            (_, Some(material)) => vec![(label, material)],
            (_, None) => (0..self.recipe.materials.len()).map(|m| (label, m)).collect(),
        }
    }

    fn add_access(&mut self, node: NodeIndex, access: &Access) -> Result<(), GraphError> {
        let keys = self.keys(node, access.label);
        if matches!(access.mode, Mode::RequiresNew | Mode::Adapts)
            && !keys.iter().any(|key| self.slots.get(key).is_some_and(|s| !s.writers.is_empty()))
        {
            return Err(self.missing(node, access.label));
        }
        for key in keys {
            self.add_to_slot(node, access, key)?;
        }
        Ok(())
    }

    fn add_to_slot(&mut self, node: NodeIndex, access: &Access, key: Key) -> Result<(), GraphError> {
        let (label, domain) = (access.label, self.graph[node].declaration.domain);
        let mut slot = self.slots.remove(&key).unwrap_or_default();
        let sums = label.combine() != Combine::None;
        if let Some(&writer) = slot.writers.last() {
            if access.mode == Mode::RequiresOld {
                let (task, writer, patches) = (self.name(node), self.name(writer), self.everywhere.clone());
                return Err(GraphError::OldAfterWrite { task, label, writer, patches });
            }
            if access.mode == Mode::Computes
                && slot.readers.is_empty()
                && !sums
                && label.home() != Home::Chunk
            {
                let (task, producer, patches) = (self.name(node), self.name(writer), self.everywhere.clone());
                return Err(GraphError::TwoProducers { task, label, producer, patches });
            }
        }
        let edge = |why, ghost| Edge { label, material: key.1, why, ghost };
        let why = if access.mode.reads() { Why::Flow } else { Why::WriteAfterWrite };
        for &writer in slot.writers.iter().filter(|_| access.mode.reads() || !sums) {
            self.graph.add_edge(writer, node, edge(why, access.ghost));
        }
        if access.mode.reads() && over_particles(domain) {
            for &adapter in &slot.adapters {
                self.graph.add_edge(adapter, node, edge(Why::Flow, access.ghost));
            }
        }
        if access.mode == Mode::Adapts {
            slot.adapters.push(node);
        }
        if domain == Domain::Buffers && access.mode == Mode::Computes && label.home() == Home::Node {
            // it changes what its block's particles have added: who reads the sums, reads its
            for writer in slot.writers.drain(..) {
                self.graph.add_edge(writer, node, edge(Why::Flow, 0));
            }
        }
        if access.mode.writes() {
            slot.adapters.clear();
            for reader in slot.readers.drain(..).filter(|&r| r != node) {
                self.graph.add_edge(reader, node, edge(Why::WriteAfterRead, 0));
            }
            if !(sums && access.mode == Mode::Computes) {
                slot.writers.clear();
            }
            slot.writers.push(node);
        } else {
            slot.readers.push(node);
        }
        self.slots.insert(key, slot);
        Ok(())
    }

    fn missing(&self, node: NodeIndex, label: LabelId) -> GraphError {
        let (task, patches) = (self.name(node), self.everywhere.clone());
        let material = self.graph[node].material;
        let same = |m: Option<usize>| m.is_none() || material.is_none() || m == material;
        let later = self.recipe.entries[self.graph[node].entry + 1..].iter().find(|entry| {
            let access = entry.task.declaration().access;
            same(entry.material) && access.iter().any(|a| a.label == label && a.mode.writes())
        });
        match later {
            Some(entry) => {
                let producer = entry.task.declaration().name.to_owned();
                GraphError::RequiresBeforeComputes { task, label, producer, patches }
            }
            None => GraphError::NoProducer { task, label, patches },
        }
    }
}
