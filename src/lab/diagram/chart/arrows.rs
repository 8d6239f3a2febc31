//! What passes between graphs, from item to item.
use super::Chart;
use crate::lab::diagram::{Diagram, Item, Kind};
use engine::program::{Delay, Pass};
use engine::schema::LabelId;
use petgraph::stable_graph::NodeIndex;
use std::collections::BTreeMap;

/// Ids of two items, and when what leaves the first one is read.
pub(super) type Ends<'a> = (&'a str, &'a str, Delay);

impl Chart<'_> {
    /// Labels that pass from item to item within a step; expanded, those that stay on a patch or rank, and through halos.
    pub(super) fn arrows(&self) -> BTreeMap<Ends<'_>, Vec<LabelId>> {
        let mut arrows: BTreeMap<Ends<'_>, Vec<LabelId>> = BTreeMap::new();
        for pass in self.passes.iter().filter(|pass| pass.delay != Delay::NextStep) {
            for source in self.sources(pass) {
                for target in self.targets(pass).filter(|target| meet(source, target)) {
                    let labels = arrows.entry((&source.id, &target.id, pass.delay)).or_default();
                    if !labels.contains(&pass.label) {
                        labels.push(pass.label);
                    }
                }
            }
        }
        arrows
    }

    /// The items that a label leaves a graph from: its last writers, or the reduction that completes it.
    fn sources(&self, pass: &Pass) -> impl Iterator<Item = &Item> {
        let (diagram, pass) = (&self.diagrams[pass.from], pass.clone());
        let reduced = diagram.graph.at_end.contains(&pass.label);
        diagram.items.iter().filter(move |item| match item.kind {
            Kind::Task(node) => !reduced && pass.writers.contains(&node),
            Kind::Reduction(None) => reduced,
            _ => false,
        })
    }

    /// The items that it enters another by: its first readers, and the halo before them.
    fn targets(&self, pass: &Pass) -> impl Iterator<Item = &Item> {
        let (diagram, pass) = (&self.diagrams[pass.to], pass.clone());
        let halos: Vec<usize> =
            pass.readers.iter().filter_map(|&node| halo(diagram, node, pass.label)).collect();
        diagram.items.iter().filter(move |item| match item.kind {
            Kind::Task(node) => pass.readers.contains(&node),
            Kind::Halo(phase) => halos.contains(&phase),
            _ => false,
        })
    }
}

/// The phase of a task, if it needs a label through a halo.
fn halo(diagram: &Diagram<'_>, node: NodeIndex, label: LabelId) -> Option<usize> {
    let mut phases = diagram.graph.phases.iter();
    let phase = phases.position(|phase| phase.stages.iter().any(|stage| stage.nodes.contains(&node)))?;
    diagram.graph.phases[phase].halos.contains(&label).then_some(phase)
}

/// Whether both are at the same place.
fn meet(source: &Item, target: &Item) -> bool {
    match (source.patch, target.patch) {
        (Some(a), Some(b)) => a == b,
        _ => source.rank == target.rank,
    }
}
