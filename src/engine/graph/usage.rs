//! Whether a task may use a label as it declares: by what the task runs over, and where the label is.
use super::error::GraphError;
use super::phase::{Phase, Stage};
use super::recipe::{Graph, TaskNode, Why, everywhere, over_particles};
use super::task::{Access, Domain, Mode};
use crate::schema::{Combine, Crossing, Home, LabelId, Life, Roles};
use petgraph::visit::{EdgeRef, IntoEdgeReferences};
use std::collections::{BTreeMap, BTreeSet};

/// What a task does, and what to do instead.
type Misuse = (&'static str, &'static str);

/// Whether there are data of the label where the task runs.
///
/// # Errors
/// [`GraphError::Misuse`], [`GraphError::NoGhosts`].
pub fn check(node: &TaskNode, access: &Access) -> Result<(), GraphError> {
    let (task, label, domain) = (node.name.clone(), access.label, node.declaration.domain);
    if let Some((what, remedy)) = misuse(domain, access) {
        return Err(GraphError::Misuse { task, label, what, remedy });
    }
    let has = |mode: Mode| node.declaration.access.iter().any(|other| other.mode == mode);
    if access.mode == Mode::Adapts && has(Mode::Computes) {
        let (what, remedy) = (
            "changes what particles have added and adapts",
            "one is done after its particles, the other before: make two tasks of it",
        );
        return Err(GraphError::Misuse { task, label, what, remedy });
    }
    if over_particles(domain) && label.home() == Home::Node && access.ghost == 0 {
        return Err(GraphError::NoGhosts { task, label, most: label.ghosts() });
    }
    Ok(())
}

fn misuse(domain: Domain, access: &Access) -> Option<Misuse> {
    match (access.label.home(), domain) {
        (Home::Run | Home::Material, Domain::Once) => None,
        (_, Domain::Once) => Some((
            "runs once and declares",
            "it has no place where one of particles, chunks, nodes or blocks would be: reduce to a label of the run",
        )),
        (Home::Run | Home::Material, _) => shared(access),
        (Home::Node, Domain::Nodes) => nodes(access),
        (Home::Node, Domain::Buffers) if access.mode == Mode::Adapts => adapted(access),
        (Home::Node, _) => nodes_of_particles(access),
        (_, Domain::Nodes) => Some((
            "runs over nodes and declares",
            "there are no particles where it runs: let particles add to a label of nodes, with partials",
        )),
        (_, Domain::Buffers) => Some((
            "runs over buffers and declares",
            "there are the nodes around a block, and no particles: let a task over particles declare it",
        )),
        _ => None,
    }
}

fn adapted(access: &Access) -> Option<Misuse> {
    let read = matches!(access.label.crossing(), Crossing::Values(_));
    (!read).then_some((
        "runs over buffers and adapts",
        "particles do not read it there: give its row values(n), or compute it to change what they have added",
    ))
}

/// Blocks and threads have copies of shared labels: only contributions come back.
fn shared(access: &Access) -> Option<Misuse> {
    let reduces = access.mode == Mode::Computes && access.label.combine() != Combine::None;
    (access.mode.writes() && !reduces).then_some((
        "runs over blocks and overwrites",
        "each has a copy of it: let a task that runs once do it, or compute a label whose contributions combine",
    ))
}

fn nodes(access: &Access) -> Option<Misuse> {
    match access.mode {
        Mode::Adapts => {
            Some(("runs over nodes and adapts", "it has no copy of them: modify them where they are"))
        }
        _ if access.ghost > 0 => Some((
            "runs over nodes and declares ghosts of",
            "it sees the nodes of its block alone: declare it without @",
        )),
        Mode::Computes if access.label.is_partial() => Some((
            "runs over nodes and computes",
            "particles add to it: modify the sums, or compute a label of another row",
        )),
        _ => None,
    }
}

fn nodes_of_particles(access: &Access) -> Option<Misuse> {
    match (access.mode, access.label.crossing()) {
        (Mode::Computes, Crossing::Partials(_)) => None,
        (Mode::Adapts, _) => Some((
            "runs over particles and adapts",
            "the buffer belongs to the whole block: let a task over buffers do it",
        )),
        (Mode::Computes, _) => Some((
            "runs over particles and computes",
            "blocks have no partial sums of it: give its row partials(n)",
        )),
        (Mode::Modifies, _) => Some((
            "runs over particles and modifies",
            "particles only add to nodes: compute a label with partials(n), and modify in a task over nodes",
        )),
        (_, Crossing::Values(_)) => None,
        (_, Crossing::Partials(_)) => Some((
            "runs over particles and reads",
            "it is a sum of which each block has a part: let a task over nodes compute a label with values(n) of it",
        )),
        (_, Crossing::None) => {
            Some(("runs over particles and reads", "it does not leave its nodes: give its row values(n)"))
        }
    }
}

/// Labels that live for a stage, changed in one and read in another.
pub fn escapes(graph: &Graph, phases: &[Phase], patches: usize) -> Vec<GraphError> {
    let stages = || phases.iter().flat_map(|phase| &phase.stages);
    let mut found = Vec::new();
    for edge in graph.edge_references() {
        let (source, label) = (&graph[edge.source()], edge.weight().label);
        let stays = label.home() != Home::Node
            || label.life() != Life::Stage
            || edge.weight().why != Why::Flow
            || source.declaration.domain != Domain::Nodes;
        let [from, to] = [edge.source(), edge.target()].map(|n| stages().position(|s| s.nodes.contains(&n)));
        if !stays && from != to {
            let (task, writer) = (graph[edge.target()].name.clone(), source.name.clone());
            let escape = GraphError::StageLabelEscapes { task, label, writer, patches: everywhere(patches) };
            if !found.contains(&escape) {
                found.push(escape);
            }
        }
    }
    found
}

/// The name of the first task of a stage that uses a label in some way.
fn user(graph: &Graph, stage: &Stage, label: LabelId, wanted: fn(Mode) -> bool) -> Option<String> {
    let uses = |a: &Access| a.label == label && wanted(a.mode);
    let task = stage.nodes.iter().find(|node| graph[**node].declaration.access.iter().any(uses));
    task.map(|node| graph[*node].name.clone())
}

/// Sums to which particles add while others are open to which they have added before they moved: a block knows one set of nodes
/// that its particles touch.
pub fn added_after_move(graph: &Graph, phases: &[Phase], extent: LabelId) -> Vec<GraphError> {
    // by material: who has moved the particles while a sum was open, and which
    let (mut open, mut moved) = (BTreeSet::new(), BTreeMap::new());
    let mut found = Vec::new();
    for stage in phases.iter().flat_map(|phase| &phase.stages) {
        open.retain(|(_, label)| !stage.sums.contains(label));
        moved.retain(|material, _| open.iter().any(|(other, _)| other == material));
        let Some(material) = stage.material else { continue };
        for &label in &stage.adds {
            if let Some((mover, open)) = moved.get(&material)
                && let Some(task) = user(graph, stage, label, Mode::writes)
            {
                let mover = String::clone(mover);
                found.push(GraphError::AddsAfterMove { task, label, open: *open, mover });
            }
            open.insert((material, label));
        }
        let first = open.iter().find(|(other, _)| *other == material);
        if let (Some(mover), Some(&(_, label))) = (user(graph, stage, extent, Mode::writes), first) {
            moved.insert(material, (mover, label));
        }
    }
    found
}

/// Sums that ranks have brought together for a phase, and to which a task adds in it or after it.
pub fn added_after_reduction(graph: &Graph, phases: &[Phase]) -> Vec<GraphError> {
    let mut whole: BTreeMap<LabelId, String> = BTreeMap::new();
    let mut found = Vec::new();
    for phase in phases {
        for &label in phase.reductions.iter().filter(|label| label.combine().is_sum()) {
            let reader = phase.stages.iter().find_map(|stage| user(graph, stage, label, Mode::reads));
            whole.insert(label, reader.unwrap_or_default());
        }
        for (label, reader) in &whole {
            let adds = |stage: &Stage| user(graph, stage, *label, |mode| mode == Mode::Computes);
            let task = phase.stages.iter().filter(|stage| stage.domain != Domain::Once).find_map(adds);
            if let Some(task) = task {
                found.push(GraphError::AddsAfterReduction { task, label: *label, reader: reader.clone() });
            }
        }
    }
    found
}

/// Tasks that move particles without widening the extents of their blocks.
pub fn moves_unseen(graph: &Graph, roles: &Roles) -> Vec<GraphError> {
    let Roles { position, extent, .. } = *roles;
    let writes = |node: &TaskNode, label| {
        node.declaration.access.iter().any(|access| access.label == label && access.mode.writes())
    };
    let unseen = graph.node_weights().filter(|node| writes(node, position) && !writes(node, extent));
    unseen.map(|node| GraphError::MovesUnseen { task: node.name.clone(), position, extent }).collect()
}

/// Partial sums that are to outlive the graph, and that no stage over nodes adds up.
pub fn never_summed(graph: &Graph, phases: &[Phase]) -> Vec<GraphError> {
    let sums = |from: usize, label: &LabelId| {
        phases[from..].iter().flat_map(|phase| &phase.stages).any(|stage| stage.sums.contains(label))
    };
    let mut found = Vec::new();
    for (number, phase) in phases.iter().enumerate() {
        for stage in &phase.stages {
            for &label in stage.adds.iter().filter(|label| label.life() >= Life::Step && !sums(number, label))
            {
                let task = user(graph, stage, label, Mode::writes).unwrap_or_default();
                found.push(GraphError::NeverSummed { task, label });
            }
        }
    }
    found
}
