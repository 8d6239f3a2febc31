//! What ranks and patches exchange: derived from declarations and rows, like the edges.
use super::phase::Phase;
use super::task::{Access, Domain, Mode};
use crate::schema::{Combine, Home, LabelId, Life};
use std::collections::{BTreeMap, BTreeSet};

/// One message to each neighboring rank: what a phase is the last to write, for a phase that reads it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exchange {
    /// The phase after which it is sent; `None`: an earlier graph has written it, and it is sent before `to`.
    pub from: Option<usize>,
    /// The phase that needs it.
    pub to: usize,
    /// What travels.
    pub way: Way,
    /// Of which labels.
    pub labels: Vec<LabelId>,
}

/// What travels in an exchange, and in which direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// Partial sums, from blocks of particles to the nodes around.
    Partials,
    /// Values, from nodes to the blocks of particles around.
    Values,
}

/// Fills in what each phase sends and receives, which partial sums stages add up and release, and which reductions phases
/// need complete; returns the exchanges, and the labels whose reductions are complete only at the end.
pub fn derive(phases: &mut [Phase]) -> (Vec<Exchange>, Vec<LabelId>) {
    let exchanges = exchanges(phases);
    partial_sums(phases);
    (exchanges, reductions(phases))
}

fn of_nodes(phase: &Phase) -> impl Iterator<Item = (Domain, &Access)> {
    let all = phase.stages.iter().flat_map(|stage| stage.touched.iter().map(|a| (stage.domain, a)));
    all.filter(|(_, a)| a.label.home() == Home::Node)
}

fn exchanges(phases: &mut [Phase]) -> Vec<Exchange> {
    let mut exchanges: Vec<Exchange> = Vec::new();
    let mut spread = BTreeMap::new();
    // who has written a label last, if it has not been sent since
    let mut writer: BTreeMap<LabelId, usize> = BTreeMap::new();
    let mut known = BTreeSet::new();
    for number in 0..phases.len() {
        let reads = of_nodes(&phases[number]).filter(|(_, a)| a.mode.reads());
        let across =
            reads.filter(|(_, a)| a.ghost > 0 || spread.get(&a.label).is_some_and(|&ghost| ghost > 0));
        let halos: BTreeSet<LabelId> = across.map(|(_, a)| a.label).collect();
        for &label in &halos {
            let way = if label.is_partial() { Way::Partials } else { Way::Values };
            let from = match writer.remove(&label) {
                Some(writer) => Some(writer),
                None if known.contains(&label) || label.life() < Life::Step => continue,
                None => None,
            };
            known.insert(label);
            let same = |e: &&mut Exchange| (e.from, e.to, e.way) == (from, number, way);
            match exchanges.iter_mut().find(same) {
                Some(exchange) => exchange.labels.push(label),
                None => exchanges.push(Exchange { from, to: number, way, labels: vec![label] }),
            }
        }
        for (_, access) in of_nodes(&phases[number]).filter(|(_, a)| a.mode.writes()) {
            if access.mode == Mode::Computes {
                spread.insert(access.label, access.ghost);
            }
            writer.insert(access.label, number);
        }
        phases[number].halos = halos.into_iter().collect();
    }
    for (number, exchange) in exchanges.iter().enumerate() {
        phases[exchange.to].receives.push(number);
        if let Some(from) = exchange.from {
            phases[from].sends.push(number);
        }
    }
    exchanges
}

/// Partial sums that live for a stage are added up wherever they are read, others by the first stage after they were
/// written. Particles release the buffers of those that nobody reads any more.
fn partial_sums(phases: &mut [Phase]) {
    let mut fresh = BTreeSet::new();
    let mut last_use: BTreeMap<LabelId, usize> = BTreeMap::new();
    for (number, phase) in phases.iter_mut().enumerate() {
        for stage in &mut phase.stages {
            let partial = stage.touched.iter().filter(|a| a.label.is_partial());
            match stage.domain {
                Domain::Nodes => {
                    let read = partial.filter(|a| a.mode.reads()).map(|a| a.label);
                    let sums = read.filter(|label| label.life() == Life::Stage || fresh.remove(label));
                    stage.sums = sums.collect();
                    last_use.extend(stage.sums.iter().map(|&label| (label, number)));
                }
                _ => {
                    fresh.extend(stage.adds.iter().copied());
                    last_use.extend(stage.adds.iter().map(|&label| (label, number)));
                }
            }
        }
    }
    for (number, phase) in phases.iter_mut().enumerate() {
        for stage in phase.stages.iter_mut().filter(|stage| stage.domain == Domain::Particles) {
            let over = last_use.iter().filter(|(_, last)| **last < number);
            stage.releases = over.map(|(&label, _)| label).collect();
        }
    }
}

fn reductions(phases: &mut [Phase]) -> Vec<LabelId> {
    let mut open = BTreeSet::new();
    for phase in phases {
        let needs = phase.shared.iter().filter(|(_, reduces)| !reduces).map(|&(label, _)| label);
        phase.reductions = needs.filter(|label| open.remove(label)).collect();
        let reduces =
            phase.shared.iter().filter(|(label, reduces)| *reduces && label.combine() != Combine::None);
        open.extend(reduces.map(|&(label, _)| label));
    }
    open.into_iter().collect()
}
