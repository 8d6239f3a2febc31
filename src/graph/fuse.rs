//! Joins neighbors of the recipe into stages, and independent stages into phases.
//!
//! A stage's tasks run together, chunk by chunk of particles or block by block of nodes, so that what passes
//! between them stays in cache. A node label that particles fill needs all blocks first: it ends a stage.
use super::error::GraphError;
use super::recipe::{Graph, Recipe, Why, everywhere, over_particles};
use super::task::{Access, Domain, Mode};
use crate::data::label::{Home, Reduce};
use crate::data::labels::LabelId;
use petgraph::Direction;
use petgraph::stable_graph::NodeIndex;
use petgraph::visit::EdgeRef;
use std::collections::BTreeSet;
use std::ops::Range;

/// Tasks that run together.
#[derive(Clone, Debug)]
pub struct Stage {
    /// What they run over (`Particles` also for tasks on near particles only).
    pub domain: Domain,
    /// The material of particle stages.
    pub material: Option<usize>,
    /// Their lines of the recipe, in order.
    pub entries: Vec<usize>,
    /// Their nodes in the graph, in the same order.
    pub nodes: Vec<NodeIndex>,
    /// Labels touched, each once, with the strongest access.
    pub touched: Vec<Access>,
    /// At which end of a material's own step they run (particle stages).
    pub when: When,
    /// Whether all node stages of the tick come before: nobody needs what particles gave to nodes any more.
    pub after_nodes: bool,
}

/// When in the step of a material a stage runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum When {
    /// When it begins: what particles give to the nodes.
    Begin,
    /// When it ends: what they take from them.
    End,
}

impl Stage {
    /// Whether some task of the stage touches `label` in a way that `test` accepts.
    pub fn touches(&self, label: LabelId, test: impl Fn(Mode) -> bool) -> bool {
        self.touched.iter().any(|a| a.label == label && test(a.mode))
    }
}

/// Stages without edges between them.
#[derive(Clone, Debug, Default)]
pub struct Phase {
    /// The stages: several only if all run over particles, of different materials.
    pub stages: Vec<Stage>,
    /// Labels of home `Material` and `Global` that they touch, and whether they reduce them.
    pub shared: Vec<(LabelId, bool)>,
    /// Labels of those that no earlier phase reduces.
    pub afresh: Vec<LabelId>,
    /// Whether it decides which materials act in the phases that follow.
    pub decides: bool,
    /// Whether it is the last one over nodes: they have gone through the tick then.
    pub settles: bool,
    /// Node labels that it reads across the faces of patches: other ranks must have sent theirs.
    pub halos: Vec<LabelId>,
    /// Node labels of which it is the last to write what a later phase reads across the faces of patches.
    pub sends: Vec<LabelId>,
    /// Labels that earlier phases reduced and that it reads: the parts of all ranks must be together.
    pub reductions: Vec<LabelId>,
}

impl Phase {
    /// Fills in what follows from the stages; `begun` are the labels that earlier phases reduce.
    fn complete(&mut self, begun: &mut BTreeSet<LabelId>) {
        let touched = self.stages.iter().flat_map(|s| &s.touched);
        let shared: BTreeSet<_> = touched
            .filter(|a| matches!(a.label.home(), Home::Material | Home::Global))
            .map(|a| (a.label, a.mode == Mode::Computes && a.label.reduce() != Reduce::No))
            .collect();
        self.shared = shared.into_iter().collect();
        let reduced = self.shared.iter().filter(|(_, reduces)| *reduces).map(|&(label, _)| label);
        self.afresh = reduced.filter(|&label| begun.insert(label)).collect();
        self.decides = self.stages.iter().any(|s| s.touches(LabelId::Step, Mode::writes));
    }
}

/// Stages and phases of a pruned graph, and what is to be refused: [`GraphError::ChunkLabelEscapes`].
pub fn fuse(graph: &Graph, recipe: &Recipe, patches: usize) -> (Vec<Phase>, Vec<GraphError>) {
    let (mut stages, mut refusals): (Vec<Stage>, _) = (Vec::new(), Vec::new());
    for node in graph.node_indices() {
        let (entry, material) = (graph[node].entry, graph[node].material);
        let declared = recipe.entries[entry].task.declaration().domain;
        let domain = if over_particles(declared) { Domain::Particles } else { declared };
        let joins = stages.last().is_some_and(|s| {
            domain != Domain::Once
                && (s.domain, s.material) == (domain, material)
                && !needs_all_blocks(graph, node, s)
        });
        if !joins {
            stages.push(Stage {
                domain,
                material,
                entries: vec![],
                nodes: vec![],
                touched: vec![],
                when: When::End,
                after_nodes: false,
            });
        }
        let Some(stage) = stages.last_mut() else { continue };
        stage.entries.push(entry);
        stage.nodes.push(node);
        graph[node].declaration.access.iter().for_each(|&access| merge(&mut stage.touched, access));
        if domain == Domain::Particles && gives(graph[node].declaration.access) {
            stage.when = When::Begin;
        }
        refusals.extend(check_chunk_labels(graph, node, stage, patches).err());
    }
    (group(graph, stages), refusals)
}

/// Whether a task over particles adds to nodes.
fn gives(access: &[Access]) -> bool {
    access.iter().any(|a| a.label.home() == Home::Node && a.mode.writes())
}

/// Whether `node` depends on something that is complete only when `stage` has run on all blocks.
fn needs_all_blocks(graph: &Graph, node: NodeIndex, stage: &Stage) -> bool {
    let complete_later = |home| match home {
        Home::Node => stage.domain == Domain::Particles,
        Home::Material | Home::Global => true,
        _ => false,
    };
    graph.edges_directed(node, Direction::Incoming).any(|e| {
        stage.nodes.contains(&e.source())
            && e.weight().why == Why::Flow
            && complete_later(e.weight().label.home())
    })
}

fn check_chunk_labels(
    graph: &Graph,
    node: NodeIndex,
    stage: &Stage,
    patches: usize,
) -> Result<(), GraphError> {
    let escaped = graph.edges_directed(node, Direction::Incoming).find(|e| {
        e.weight().why == Why::Flow
            && e.weight().label.home() == Home::Chunk
            && !stage.nodes.contains(&e.source())
    });
    escaped.map_or(Ok(()), |e| {
        let (task, producer) = (graph[node].name.clone(), graph[e.source()].name.clone());
        let (label, patches) = (e.weight().label, everywhere(patches));
        Err(GraphError::ChunkLabelEscapes { task, label, producer, patches })
    })
}

fn group(graph: &Graph, stages: Vec<Stage>) -> Vec<Phase> {
    let mut phases: Vec<Phase> = Vec::new();
    for stage in stages {
        let independent = |other: &Stage| {
            other.domain == Domain::Particles
                && other.material != stage.material
                && !stage.nodes.iter().any(|&n| {
                    graph.edges_directed(n, Direction::Incoming).any(|e| other.nodes.contains(&e.source()))
                })
        };
        match phases.last_mut() {
            Some(phase) if stage.domain == Domain::Particles && phase.stages.iter().all(independent) => {
                phase.stages.push(stage);
            }
            _ => phases.push(Phase { stages: vec![stage], ..Phase::default() }),
        }
    }
    let mut begun = BTreeSet::new();
    phases.iter_mut().for_each(|phase| phase.complete(&mut begun));
    let over_nodes = |phase: &Phase| phase.stages.iter().any(|s| s.domain == Domain::Nodes);
    if let Some(last) = phases.iter().rposition(over_nodes) {
        phases[last].settles = true;
        let after = phases[last + 1..].iter_mut().flat_map(|phase| &mut phase.stages);
        after.for_each(|stage| stage.after_nodes = true);
    }
    phases
}

/// Groups phases over blocks that may follow one another as a wave: as soon as one has done a layer of blocks and those
/// beside it, the next may do that layer. What is reduced over all blocks may not be read in the same wave.
pub fn waves(phases: &[Phase]) -> Vec<Range<usize>> {
    let over_blocks = |phase: &Phase| phase.stages.iter().all(|s| s.domain != Domain::Once);
    let conflict = |a: &Phase, b: &Phase| {
        a.shared.iter().any(|(label, reduces)| b.shared.iter().any(|(l, r)| l == label && r != reduces))
    };
    let mut waves: Vec<Range<usize>> = Vec::new();
    for (number, phase) in phases.iter().enumerate() {
        match waves.last_mut() {
            Some(wave)
                if phases[wave.clone()].iter().all(|p| over_blocks(p) && !conflict(p, phase))
                    && over_blocks(phase) =>
            {
                wave.end = number + 1;
            }
            _ => waves.push(number..number + 1),
        }
    }
    waves
}

fn merge(touched: &mut Vec<Access>, access: Access) {
    match touched.iter_mut().find(|a| a.label == access.label) {
        Some(known) if !known.mode.writes() && access.mode.writes() => known.mode = Mode::Modifies,
        Some(known) => known.ghost = known.ghost.max(access.ghost),
        None => touched.push(access),
    }
}
