//! What ranks and patches exchange: derived from declarations and rows, like the edges.
use super::adders::Adders;
use super::phase::Phase;
use super::task::{Access, Domain, Mode};
use crate::schema::{Combine, Home, LabelId, Life, Schema};
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
    /// Of which labels, at most [`MOST_LABELS`].
    pub labels: Vec<LabelId>,
    /// Of partial sums: who has added to them.
    pub adders: Adders,
    /// Of values: whether those of all nodes travel that particles may touch, because the readers have not added to nodes in
    /// this graph, or have moved since, so that nobody knows which nodes they touch.
    pub whole: bool,
}

/// The most labels of an exchange: messages have a bit for each.
pub const MOST_LABELS: usize = 64;

/// What travels in an exchange, and in which direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// Partial sums, from blocks of particles to the nodes around.
    Partials,
    /// Values, from nodes to the blocks of particles around.
    Values,
}

/// Fills in what each phase sends and receives, which partial sums stages begin, add up and release, and which reductions
/// phases need complete; returns the exchanges, and the labels whose reductions are complete only at the end.
pub fn derive(schema: &Schema, phases: &mut [Phase]) -> (Vec<Exchange>, Vec<LabelId>) {
    let exchanges = exchanges(schema, phases);
    partial_sums(phases);
    begin_sums(phases);
    (exchanges, reductions(phases))
}

fn of_nodes(phase: &Phase) -> impl Iterator<Item = (Domain, &Access)> {
    let all = phase.stages.iter().flat_map(|stage| stage.touched.iter().map(|a| (stage.domain, a)));
    all.filter(|(_, a)| a.label.home() == Home::Node)
}

fn exchanges(schema: &Schema, phases: &mut [Phase]) -> Vec<Exchange> {
    let mut exchanges: Vec<Exchange> = Vec::new();
    let mut spread = BTreeMap::new();
    // who has written a label last, if it has not been sent since
    let mut writer: BTreeMap<LabelId, usize> = BTreeMap::new();
    let (mut known, mut touched) = (BTreeSet::new(), Touched::default());
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
            let fits = |e: &&mut Exchange| {
                (e.from, e.to, e.way) == (from, number, way) && e.labels.len() < MOST_LABELS
            };
            match exchanges.iter_mut().find(fits) {
                Some(exchange) => exchange.labels.push(label),
                None => {
                    let whole = way == Way::Values && !touched.is_known(&phases[number], from);
                    let (labels, adders) = (vec![label], Adders::default());
                    exchanges.push(Exchange { from, to: number, way, labels, adders, whole });
                }
            }
            if way == Way::Partials {
                touched.tell(from, number);
            }
        }
        for (_, access) in of_nodes(&phases[number]).filter(|(_, a)| a.mode.writes()) {
            if access.mode == Mode::Computes {
                spread.insert(access.label, access.ghost);
            }
            writer.insert(access.label, number);
        }
        touched.note(schema, &phases[number], number);
        phases[number].halos = halos.into_iter().collect();
    }
    for (number, exchange) in exchanges.iter_mut().enumerate() {
        phases[exchange.to].receives.push(number);
        if let Some(from) = exchange.from {
            phases[from].sends.push(number);
            let stages = phases[..=from].iter().flat_map(|phase| &phase.stages);
            let adds = stages.flat_map(|stage| stage.adds.iter().filter_map(|&l| Some((l, stage.material?))));
            exchange.adders.extend(adds.filter(|(label, _)| exchange.labels.contains(label)));
        }
    }
    exchanges
}

/// Of which materials other ranks know which nodes they touch: partial sums say it.
#[derive(Default)]
struct Touched {
    /// Materials that have added to nodes and not moved since, and the first phase in which they did.
    added: BTreeMap<usize, usize>,
    /// Those whose partial sums have come to other ranks, and the phase for which.
    told: BTreeMap<usize, usize>,
}

impl Touched {
    /// Partial sums are sent after phase `from`, for phase `to`.
    fn tell(&mut self, from: Option<usize>, to: usize) {
        let before = self.added.iter().filter(|(_, first)| from.is_some_and(|from| **first <= from));
        before.for_each(|(&material, _)| {
            self.told.entry(material).or_insert(to);
        });
    }

    /// Notes what a phase does.
    fn note(&mut self, schema: &Schema, phase: &Phase, number: usize) {
        for stage in &phase.stages {
            let Some(material) = stage.material else { continue };
            if !stage.adds.is_empty() {
                self.added.entry(material).or_insert(number);
            }
            if stage.touches(schema.roles.extent, Mode::writes) {
                self.added.remove(&material);
                self.told.remove(&material);
            }
        }
    }

    /// Whether those who send after phase `from` know which nodes the readers of a phase touch.
    fn is_known(&self, phase: &Phase, from: Option<usize>) -> bool {
        let readers = phase.stages.iter().filter(|stage| !stage.reads.is_empty());
        let mut materials = readers.filter_map(|stage| stage.material);
        from.is_some_and(|from| materials.all(|m| self.told.get(&m).is_some_and(|&to| to <= from)))
    }
}

/// Partial sums that live for a stage are added up wherever they are read, others by the first stage after they were
/// written. Particles release the buffers of those that nobody reads any more.
fn partial_sums(phases: &mut [Phase]) {
    let mut fresh = BTreeSet::new();
    let mut last_use: BTreeMap<LabelId, usize> = BTreeMap::new();
    let mut adders = Adders::default();
    for (number, phase) in phases.iter_mut().enumerate() {
        for stage in &mut phase.stages {
            let partial = stage.touched.iter().filter(|a| a.label.is_partial());
            match stage.domain {
                Domain::Nodes => {
                    let read = partial.filter(|a| a.mode.reads()).map(|a| a.label);
                    let sums = read.filter(|label| label.life() == Life::Stage || fresh.remove(label));
                    stage.sums = sums.collect();
                    stage.adders = adders.of(&stage.sums);
                    last_use.extend(stage.sums.iter().map(|&label| (label, number)));
                }
                _ => {
                    fresh.extend(stage.adds.iter().copied());
                    adders.extend(stage.adds.iter().filter_map(|&label| Some((label, stage.material?))));
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

/// The first stage of a material that adds to a label, since it was added up last, begins its sum; others go on with it.
fn begin_sums(phases: &mut [Phase]) {
    let mut open: BTreeSet<(LabelId, usize)> = BTreeSet::new();
    for stage in phases.iter_mut().flat_map(|phase| &mut phase.stages) {
        open.retain(|(label, _)| !stage.sums.contains(label));
        if let Some(material) = stage.material {
            stage.begins =
                stage.adds.iter().copied().filter(|&label| open.insert((label, material))).collect();
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
