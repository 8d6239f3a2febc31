//! Hazards: what the builder does not refuse, and should make one suspicious.
use super::build::TaskGraph;
use super::recipe::TaskNode;
use super::task::{Access, Mode};
use crate::schema::{Combine, Home, LabelId};
use petgraph::algo::has_path_connecting;
use petgraph::stable_graph::NodeIndex;
use std::collections::BTreeSet;
use std::fmt;

/// A hazard in a graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Hazard {
    /// Two tasks touch a label, one of them writes, and nothing says which comes first.
    Race {
        /// One task.
        first: String,
        /// The other one.
        second: String,
        /// The label.
        label: LabelId,
    },
    /// A node label is read before the parts of all blocks are together.
    UndeclaredHalo {
        /// The task that reads it.
        task: String,
        /// The label.
        label: LabelId,
    },
    /// A label is computed, and neither a task, nor the next step, nor an output reads it.
    Idle {
        /// The task that computes it.
        task: String,
        /// The label.
        label: LabelId,
    },
    /// More layers of ghosts than a patch has nodes: the halo would reach beyond its neighbors.
    WideGhost {
        /// The task.
        task: String,
        /// The label.
        label: LabelId,
        /// Layers.
        ghost: u8,
        /// Nodes of the narrowest patch.
        narrowest: usize,
    },
    /// A reduction is read while tasks have still to add to it.
    EarlyReduction {
        /// The task that reads it.
        task: String,
        /// The label.
        label: LabelId,
        /// A task that adds to it at the same time, or later.
        contributor: String,
    },
    /// A task over all materials requires a label that one of several materials computes.
    OneMaterial {
        /// The task.
        task: String,
        /// The label.
        label: LabelId,
        /// The material that has it.
        material: String,
    },
}

impl fmt::Display for Hazard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Hazard::Race { first, second, label } => write!(
                f,
                "race: {first} and {second} both touch {}, one of them writes, and no chain of edges orders them: declare what one needs of the other",
                label.name()
            ),
            Hazard::UndeclaredHalo { task, label } => write!(
                f,
                "undeclared halo: {task} reads {} before the blocks and patches around have given their part: it must not share a phase with those who write it across blocks",
                label.name()
            ),
            Hazard::Idle { task, label } => write!(
                f,
                "idle label: {task} computes {}, and nobody reads it: drop it from the declaration, or the task",
                label.name()
            ),
            Hazard::WideGhost { task, label, ghost, narrowest } => write!(
                f,
                "wide ghost: {task} declares {} with {ghost} layers, but the narrowest patch has {narrowest} nodes across: cut fewer patches",
                label.name()
            ),
            Hazard::EarlyReduction { task, label, contributor } => write!(
                f,
                "early reduction: {task} reads {}, to which {contributor} adds at the same time or later: require the old value, or list {task} after {contributor}",
                label.name()
            ),
            Hazard::OneMaterial { task, label, material } => write!(
                f,
                "one material: {task} requires {} of all materials, but only {material} computes it: the others read zeros",
                label.name()
            ),
        }
    }
}

/// All hazards of a graph whose narrowest patch has `narrowest` nodes across. Labels of `elsewhere` are read by others.
pub fn hazards(graph: &TaskGraph, narrowest: usize, elsewhere: &[LabelId]) -> Vec<Hazard> {
    let check = Check { graph };
    let mut found = check.races();
    found.extend(check.undeclared_halos());
    found.extend(check.idle(elsewhere));
    found.extend(check.wide_ghosts(narrowest));
    found.extend(check.early_reductions());
    found.extend(check.one_material());
    found
}

struct Check<'a> {
    graph: &'a TaskGraph,
}

impl Check<'_> {
    /// All tasks with all that they access, in the order of the recipe.
    fn accesses(&self) -> impl Iterator<Item = (NodeIndex, &TaskNode, &'static Access)> {
        let nodes = self.graph.graph.node_indices().map(|n| (n, &self.graph.graph[n]));
        let all =
            nodes.flat_map(|(n, node)| node.declaration.access.iter().map(move |access| (n, node, access)));
        all.filter(|(_, _, access)| access.mode != Mode::Scratch)
    }

    fn races(&self) -> Vec<Hazard> {
        let mut found = Vec::new();
        let adds = |a: &Access| a.mode == Mode::Computes && a.label.combine() != Combine::None;
        for (first, one, a) in self.accesses() {
            for (second, other, b) in
                self.accesses().filter(|(second, _, b)| first < *second && a.label == b.label)
            {
                let meet = a.label.home() == Home::Run || share_material(one, other);
                let harmless = !(a.mode.writes() || b.mode.writes()) || adds(a) && adds(b);
                let graph = &self.graph.graph;
                if meet && !harmless && !has_path_connecting(graph, first, second, None) {
                    let (first, second) = (one.name.clone(), other.name.clone());
                    found.push(Hazard::Race { first, second, label: a.label });
                }
            }
        }
        found
    }

    /// What tasks give to nodes of other blocks is complete only in a later phase, and only through a halo.
    fn undeclared_halos(&self) -> Vec<Hazard> {
        let mut found = Vec::new();
        let mut spread = BTreeSet::new();
        for phase in &self.graph.phases {
            let nodes: Vec<&TaskNode> =
                phase.stages.iter().flat_map(|s| &s.nodes).map(|&n| &self.graph.graph[n]).collect();
            let mut here = BTreeSet::new();
            for node in &nodes {
                for access in node.declaration.access.iter().filter(|a| a.label.home() == Home::Node) {
                    let label = access.label;
                    let across = access.ghost > 0 || spread.contains(&label);
                    let missing = across && !phase.halos.contains(&label);
                    if access.mode.reads() && (here.contains(&label) || missing) {
                        found.push(Hazard::UndeclaredHalo { task: node.name.clone(), label });
                    }
                    if access.mode == Mode::Computes {
                        spread.remove(&label);
                        if access.ghost > 0 {
                            here.insert(label);
                        }
                    }
                }
            }
            spread.extend(here);
        }
        found
    }

    fn idle(&self, elsewhere: &[LabelId]) -> Vec<Hazard> {
        let read = |from: NodeIndex, label: LabelId| {
            self.graph
                .graph
                .edges(from)
                .any(|e| e.weight().label == label && e.weight().why == super::recipe::Why::Flow)
        };
        let kept = |label: LabelId| {
            self.graph.carried.contains(&label)
                || self.graph.outputs.contains(&label)
                || elsewhere.contains(&label)
        };
        let writes = self.accesses().filter(|(_, _, a)| a.mode == Mode::Computes && !kept(a.label));
        let idle = writes.filter(|&(n, _, a)| !read(n, a.label));
        idle.map(|(_, node, a)| Hazard::Idle { task: node.name.clone(), label: a.label }).collect()
    }

    fn wide_ghosts(&self, narrowest: usize) -> Vec<Hazard> {
        let wide = self.accesses().filter(|(_, _, a)| usize::from(a.ghost) > narrowest);
        let hazard = |(_, node, a): (NodeIndex, &TaskNode, &Access)| {
            let (task, label, ghost) = (node.name.clone(), a.label, a.ghost);
            Hazard::WideGhost { task, label, ghost, narrowest }
        };
        wide.map(hazard).collect()
    }

    fn early_reductions(&self) -> Vec<Hazard> {
        let mut found = Vec::new();
        let shared = |a: &Access| a.label.is_reduced();
        let phase_of =
            |node| self.graph.phases.iter().position(|p| p.stages.iter().any(|s| s.nodes.contains(&node)));
        for (reader, task, a) in self.accesses().filter(|(_, _, a)| shared(a)) {
            if !matches!(a.mode, Mode::RequiresNew | Mode::Requires) {
                continue;
            }
            let adds = |&(n, other, b): &(NodeIndex, &TaskNode, &Access)| {
                n != reader
                    && b.label == a.label
                    && b.mode == Mode::Computes
                    && (a.label.home() == Home::Run || share_material(task, other))
                    && phase_of(n) >= phase_of(reader)
            };
            if let Some((_, contributor, _)) = self.accesses().find(adds) {
                let (task, contributor) = (task.name.clone(), contributor.name.clone());
                found.push(Hazard::EarlyReduction { task, label: a.label, contributor });
            }
        }
        found
    }

    fn one_material(&self) -> Vec<Hazard> {
        let materials = &self.graph.recipe.materials;
        // who has to do with nodes at all
        let on_nodes = self.accesses().filter(|(_, _, a)| a.label.home() == Home::Node);
        let acting: BTreeSet<usize> = on_nodes.filter_map(|(_, node, _)| node.material).collect();
        let mut found = Vec::new();
        for (_, node, a) in self.accesses() {
            if node.material.is_some() || a.mode != Mode::RequiresNew || a.label.home() == Home::Run {
                continue;
            }
            let writers = self.accesses().filter(|(_, _, b)| b.label == a.label && b.mode.writes());
            let having: BTreeSet<Option<usize>> = writers.map(|(_, writer, _)| writer.material).collect();
            if let (Some(&Some(only)), 1, true) = (having.first(), having.len(), acting.len() > 1) {
                let (task, material) = (node.name.clone(), materials[only].clone());
                found.push(Hazard::OneMaterial { task, label: a.label, material });
            }
        }
        found
    }
}

/// Whether two tasks can touch the same material's data.
fn share_material(a: &TaskNode, b: &TaskNode) -> bool {
    a.material.is_none() || b.material.is_none() || a.material == b.material
}
