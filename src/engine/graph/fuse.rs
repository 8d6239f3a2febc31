//! Joins neighbors of the recipe into stages, and independent stages into phases.
//!
//! A stage's tasks run together, chunk by chunk of particles or block by block of nodes, so that what passes
//! between them stays in cache. A node label that particles fill needs all blocks first: it ends a stage. So does a task that
//! moves particles, before one that has to do with nodes.
use super::error::GraphError;
use super::phase::{Phase, Stage};
use super::recipe::{Edge, Graph, Recipe, TaskNode, Why, everywhere, over_particles};
use super::task::{Access, Declaration, Domain, Mode};
use crate::schema::Home;
use petgraph::Direction;
use petgraph::stable_graph::{EdgeReference, NodeIndex};
use petgraph::visit::EdgeRef;
use std::collections::BTreeSet;
use std::ops::Range;

/// Stages and phases of a pruned graph, and what is to be refused: [`GraphError::ChunkLabelEscapes`].
pub fn fuse(graph: &Graph, recipe: &Recipe, patches: usize) -> (Vec<Phase>, Vec<GraphError>) {
    let (mut stages, mut refusals): (Vec<Stage>, _) = (Vec::new(), Vec::new());
    for node in graph.node_indices() {
        let material = graph[node].material;
        let declared = graph[node].declaration.domain;
        let domain = if over_particles(declared) { Domain::Particles } else { declared };
        let joins = stages.last().is_some_and(|s| {
            let moves = s.touches(recipe.schema.roles.extent, Mode::writes);
            domain != Domain::Once
                && (s.domain, s.material) == (domain, material)
                && !needs_all_blocks(graph, node, s)
                && !out_of_order(&graph[node], s, graph)
                && !reads_and_reduces(&s.touched, graph[node].declaration.access)
                && (!moves || !at_nodes(&graph[node]))
        });
        if !joins {
            stages.push(Stage::new(domain, material));
        }
        let Some(stage) = stages.last_mut() else { continue };
        stage.push(node, &graph[node]);
        refusals.extend(check_chunk_labels(graph, node, stage, patches).err());
        refusals.extend(check_copies(graph, node, stage).err());
    }
    (group(graph, recipe, stages), refusals)
}

/// Whether one reads a shared label that the other contributes to: a worker has a copy of what there is, or room for a part.
fn reads_and_reduces(one: &[Access], other: &[Access]) -> bool {
    let mixed = |a: &Access| {
        let same = other.iter().find(|b| b.label == a.label);
        a.label.is_shared() && same.is_some_and(|b| a.reduces() != b.reduces())
    };
    one.iter().any(mixed)
}

/// Whether a task has to do with nodes: which ones its particles touch has to be known before the stage.
fn at_nodes(node: &TaskNode) -> bool {
    node.declaration.access.iter().any(|a| a.label.home() == Home::Node)
}

/// Whether a task would run too early or too late in a stage: buffers are adapted before the chunks of particles, and what was
/// added is changed after them.
fn out_of_order(node: &TaskNode, stage: &Stage, graph: &Graph) -> bool {
    let Declaration { domain, access, .. } = node.declaration;
    let has = |label, test: fn(Mode) -> bool| access.iter().any(|a| a.label == label && test(a.mode));
    let read_before = stage.touched.iter().any(|a| a.mode.reads() && has(a.label, |m| m == Mode::Adapts));
    let changed = |n: &NodeIndex| {
        let it = &graph[*n].declaration;
        let mut writes = it.access.iter().filter(|a| a.mode.writes());
        it.domain == Domain::Buffers && writes.any(|a| has(a.label, Mode::writes))
    };
    read_before || domain != Domain::Buffers && stage.nodes.iter().any(changed)
}

/// Whether an edge is about what a block has in its buffer, and needs no other block.
fn in_buffer(graph: &Graph, edge: EdgeReference<'_, Edge>) -> bool {
    let changes = |a: &Access| a.label == edge.weight().label && a.mode == Mode::Computes;
    let target = &graph[edge.target()].declaration;
    is_copy(graph, edge) || target.domain == Domain::Buffers && target.access.iter().any(changes)
}

/// Whether an edge is about the copy that its source has changed in the buffer of a block.
fn is_copy(graph: &Graph, edge: EdgeReference<'_, Edge>) -> bool {
    let mut access = graph[edge.source()].declaration.access.iter();
    access.any(|a| a.label == edge.weight().label && a.mode == Mode::Adapts)
}

/// A copy in the buffer of a block is gone with the stage.
fn check_copies(graph: &Graph, node: NodeIndex, stage: &Stage) -> Result<(), GraphError> {
    let mut copies = graph
        .edges_directed(node, Direction::Incoming)
        .filter(|e| e.weight().why == Why::Flow && is_copy(graph, *e));
    let escaped = copies.find(|e| !stage.nodes.contains(&e.source()));
    escaped.map_or(Ok(()), |e| {
        let (task, adapter) = (graph[node].name.clone(), graph[e.source()].name.clone());
        Err(GraphError::CopyEscapes { task, label: e.weight().label, adapter })
    })
}

/// Whether `node` depends on something that is complete only when `stage` has run on all blocks.
fn needs_all_blocks(graph: &Graph, node: NodeIndex, stage: &Stage) -> bool {
    let complete_later = |home| match home {
        Home::Node => stage.domain == Domain::Particles,
        Home::Material | Home::Run => true,
        _ => false,
    };
    graph.edges_directed(node, Direction::Incoming).any(|e| {
        stage.nodes.contains(&e.source())
            && e.weight().why == Why::Flow
            && complete_later(e.weight().label.home())
            && !in_buffer(graph, e)
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

fn group(graph: &Graph, recipe: &Recipe, stages: Vec<Stage>) -> Vec<Phase> {
    let mut phases: Vec<Phase> = Vec::new();
    for stage in stages {
        let independent = |other: &Stage| {
            other.domain == Domain::Particles
                && other.material != stage.material
                && !reads_and_reduces(&other.touched, &stage.touched)
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
    // they do not depend on one another; blocks are gone through in this order
    phases.iter_mut().for_each(|phase| phase.stages.sort_by_key(|stage| stage.material));
    let mut begun = BTreeSet::new();
    let materials = recipe.materials.len();
    phases.iter_mut().for_each(|phase| phase.complete(recipe.schema, materials, &mut begun));
    if let Some(last) = phases.iter().rposition(Phase::is_over_nodes) {
        phases[last].settles = true;
    }
    phases
}

/// Groups phases over blocks that may follow one another as a wave: as soon as one has done a layer of blocks and those
/// beside it, the next may do that layer. What is reduced over all blocks may not be read in the same wave, and what other ranks
/// have reduced comes together before a wave. Nothing follows
/// particles that read nodes of the same wave: those at the rim of a rank do so last.
pub fn waves(phases: &[Phase]) -> Vec<Range<usize>> {
    let over_blocks = |phase: &Phase| phase.stages.iter().all(|s| s.domain != Domain::Once);
    let conflict = |a: &Phase, b: &Phase| {
        a.shared.iter().any(|(label, reduces)| b.shared.iter().any(|(l, r)| l == label && r != reduces))
    };
    let mut waves: Vec<Range<usize>> = Vec::new();
    for (number, phase) in phases.iter().enumerate() {
        let joins = |wave: &Range<usize>| {
            let nodes_then_particles = wave.len() > 1 && !phases[wave.end - 1].is_over_nodes();
            over_blocks(phase)
                && phase.reductions.is_empty()
                && !nodes_then_particles
                && phases[wave.clone()].iter().all(|p| over_blocks(p) && !conflict(p, phase))
        };
        match waves.last_mut() {
            Some(wave) if joins(wave) => wave.end = number + 1,
            _ => waves.push(number..number + 1),
        }
    }
    waves
}
