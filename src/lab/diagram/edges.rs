//! Links of a diagram: the edges of the graph, through halos and reductions where data pass them.
use super::build::{Builder, Place};
use super::{Kind, Link};
use engine::graph::recipe::{Edge, Why};
use engine::graph::task::{Domain, Mode};
use engine::graph::traffic::LINE;
use engine::schema::Home;
use petgraph::stable_graph::NodeIndex;
use petgraph::visit::{EdgeRef, IntoEdgeReferences};
use std::collections::BTreeMap;

impl Builder<'_> {
    /// Links for all edges.
    pub(super) fn edges(&mut self) {
        let graph = self.diagram.graph;
        let mut phase_of = BTreeMap::new();
        for (number, phase) in graph.phases.iter().enumerate() {
            phase.stages.iter().flat_map(|s| &s.nodes).for_each(|&node| {
                phase_of.insert(node, number);
            });
        }
        let spread = |node: NodeIndex, label| {
            let access = graph.graph[node].declaration.access.iter();
            access.filter(|a| a.label == label && a.mode.writes()).map(|a| a.ghost).max().unwrap_or(0)
        };
        for edge in graph.graph.edge_references() {
            let (from, to, mut weight) = (edge.source(), edge.target(), *edge.weight());
            let (Some(&before), Some(&phase)) = (phase_of.get(&from), phase_of.get(&to)) else { continue };
            let crosses = weight.why == Why::Flow && before < phase;
            if crosses && graph.phases[phase].halos.contains(&weight.label) {
                weight.ghost = weight.ghost.max(spread(from, weight.label));
                self.through_halo(from, to, phase, &weight);
            } else if crosses && graph.phases[phase].reductions.contains(&weight.label) {
                self.reduce_from(from, Some(phase), &weight);
                self.reduced_to(to, phase, &weight);
            } else {
                self.direct(from, to, &weight);
            }
        }
        self.openings();
        self.ends();
    }

    /// Links from halos that bring what earlier graphs have left.
    fn openings(&mut self) {
        let graph = self.diagram.graph;
        for exchange in graph.exchanges.iter().filter(|exchange| exchange.from.is_none()) {
            let nodes = graph.phases[exchange.to].stages.iter().flat_map(|stage| &stage.nodes);
            for (&node, &label) in nodes.flat_map(|node| exchange.labels.iter().map(move |it| (node, it))) {
                let mut access = graph.graph[node].declaration.access.iter();
                let Some(access) = access.find(|a| a.label == label && a.mode.reads()) else { continue };
                let ghost = access.ghost;
                let materials = match graph.graph[node].material {
                    Some(material) => material..material + 1,
                    None => 0..graph.recipe.materials.len(),
                };
                for material in materials {
                    let edge = Edge { label, material, why: Why::Flow, ghost };
                    self.out_of_halo(node, exchange.to, &edge);
                }
            }
        }
    }

    /// Links to what happens at the end of a tick.
    fn ends(&mut self) {
        let graph = self.diagram.graph;
        for node in graph.graph.node_indices() {
            let it = &graph.graph[node];
            for access in it.declaration.access.iter().filter(|a| a.mode.writes()) {
                let material = it.material.unwrap_or(0);
                let edge = Edge { label: access.label, material, why: Why::Flow, ghost: 0 };
                if access.mode == Mode::Computes && graph.at_end.contains(&access.label) {
                    self.reduce_from(node, None, &edge);
                }
                if access.label.home() == Home::Block {
                    for (place, from) in self.places(node) {
                        let to = self.seat(Kind::Relocation, place);
                        self.link(from, to, &edge, self.resident(node, &edge, place));
                    }
                }
            }
        }
    }

    /// The items of a task.
    fn places(&self, node: NodeIndex) -> Vec<(Place, usize)> {
        let first = (Kind::Task(node), (None, None, None));
        let items = self.at.range(first..).take_while(|((kind, _), _)| *kind == Kind::Task(node));
        items.map(|((_, place), &item)| (*place, item)).collect()
    }

    /// The item of a rank that belongs to a place.
    fn seat(&self, kind: Kind, (_, rank, _): Place) -> Option<usize> {
        self.at.get(&(kind, (None, rank, None))).copied()
    }

    /// What stays on a patch, or concerns all of a rank.
    fn direct(&mut self, from: NodeIndex, to: NodeIndex, edge: &Edge) {
        let targets = self.places(to);
        for (place, source) in self.places(from) {
            let here = |(other, _): &&(Place, usize)| match (place.0, other.0) {
                (Some(a), Some(b)) => a == b,
                _ => place.1 == other.1,
            };
            for &(other, target) in targets.iter().filter(here) {
                let finer = if place.0.is_some() { place } else { other };
                let bytes = if edge.why == Why::Flow { self.resident(from, edge, finer) } else { 0 };
                self.link(source, Some(target), edge, bytes);
            }
        }
    }

    /// Node data: from patch to patch on a rank, and through halos to other ranks.
    fn through_halo(&mut self, from: NodeIndex, to: NodeIndex, phase: usize, edge: &Edge) {
        let traffic = self.diagram.traffic;
        let (label, material) = (edge.label, edge.material);
        let (sources, targets) = (self.places(from), self.places(to));
        if !self.diagram.expanded {
            let halo = self.seat(Kind::Halo(phase), (None, None, None));
            let [stays, travels] = [false, true].map(|travel| traffic.total_bytes(label, material, travel));
            for (&(_, source), &(_, target)) in sources.iter().zip(&targets) {
                self.link(source, Some(target), edge, stays);
                self.link(source, halo, edge, travels);
            }
            self.out_of_halo(to, phase, edge);
            return;
        }
        let halo = |a: usize, b: usize| (Kind::Halo(phase), (None, Some(a), Some(b)));
        for &((patch, rank, _), source) in &sources {
            let (Some(p), Some(rank)) = (patch, rank) else { continue };
            for &((other, _, _), target) in targets.iter().filter(|((_, r, _), _)| *r == Some(rank)) {
                let bytes = other.map_or(0, |q| traffic.patch_bytes(p, q, label, material));
                if bytes > 0 {
                    self.link(source, Some(target), edge, bytes);
                }
            }
            for rank_to in (0..traffic.ranks).filter(|&r| r != rank) {
                let bytes = traffic.rank_bytes(p, rank_to, label, material);
                if bytes > 0 {
                    let to = self.at.get(&halo(rank, rank_to)).copied();
                    self.link(source, to, edge, bytes);
                }
            }
        }
        self.out_of_halo(to, phase, edge);
    }

    /// Node data of other ranks: from halos to those who read them.
    fn out_of_halo(&mut self, to: NodeIndex, phase: usize, edge: &Edge) {
        let traffic = self.diagram.traffic;
        let (label, material) = (edge.label, edge.material);
        if !self.diagram.expanded {
            let travels = traffic.total_bytes(label, material, true);
            if let Some(halo) = self.seat(Kind::Halo(phase), (None, None, None)) {
                for (_, target) in self.places(to) {
                    self.link(halo, Some(target), edge, travels);
                }
            }
            return;
        }
        let halo = |a: usize, b: usize| (Kind::Halo(phase), (None, Some(a), Some(b)));
        for ((patch, rank, _), target) in self.places(to) {
            let (Some(q), Some(rank)) = (patch, rank) else { continue };
            for rank_from in (0..traffic.ranks).filter(|&r| r != rank) {
                let patches = self.diagram.patches_of(rank_from);
                let bytes: u64 = patches.iter().map(|&p| traffic.patch_bytes(p, q, label, material)).sum();
                if let Some(&from) = self.at.get(&halo(rank_from, rank)).filter(|_| bytes > 0) {
                    self.link(from, Some(target), edge, bytes);
                }
            }
        }
    }

    fn reduce_from(&mut self, from: NodeIndex, phase: Option<usize>, edge: &Edge) {
        for (place, source) in self.places(from) {
            let to = self.seat(Kind::Reduction(phase), place);
            self.link(source, to, edge, self.resident(from, edge, place));
        }
    }

    fn reduced_to(&mut self, to: NodeIndex, phase: usize, edge: &Edge) {
        for (place, target) in self.places(to) {
            if let Some(from) = self.seat(Kind::Reduction(Some(phase)), place) {
                self.link(from, Some(target), edge, self.resident(to, edge, place));
            }
        }
    }

    /// Bytes of what an edge is about, where `node` runs.
    fn resident(&self, node: NodeIndex, edge: &Edge, place: Place) -> u64 {
        let traffic = self.diagram.traffic;
        let near = self.diagram.graph.graph[node].declaration.domain == Domain::NearParticles;
        let particles = if near { &traffic.near } else { &traffic.particles };
        let sum = |counts: &[Vec<u64>]| match place.0 {
            Some(patch) => counts[patch][edge.material],
            None => counts.iter().map(|patch| patch[edge.material]).sum(),
        };
        let lines = match edge.label.home() {
            Home::Particle | Home::Chunk => sum(particles).div_ceil(8),
            Home::Node => sum(&traffic.nodes),
            Home::Block => sum(&traffic.blocks),
            Home::Material | Home::Run => 1,
        };
        LINE * lines * traffic.width(edge.label, edge.material)
    }

    fn link(&mut self, from: usize, to: Option<usize>, edge: &Edge, bytes: u64) {
        let Some(to) = to else { return };
        let material = (edge.label.home() != Home::Run).then_some(edge.material);
        let Edge { label, why, ghost, .. } = *edge;
        let link = Link { from, to, label, material, why, ghost, bytes, critical: false };
        let known = self.links.entry((from, to, label, material, why as u8)).or_insert(link);
        known.ghost = known.ghost.max(ghost);
    }
}
