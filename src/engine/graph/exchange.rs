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
    /// Of partial sums: the materials that have added to anything until then; they say to which nodes. Of values: those that read
    /// them, in any phase from `to` on.
    pub materials: BTreeSet<usize>,
    /// Of values: whether those of all nodes travel that particles may touch, because a reader has not added to nodes in
    /// this graph, or has moved since, so that nobody knows which nodes it touches.
    pub whole: bool,
}

impl Exchange {
    /// Whether particles of a material send or read anything.
    pub fn concerns(&self, material: usize) -> bool {
        self.materials.contains(&material)
    }
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
    // who has written a label last, if it has not been sent since; and what has sent it, if anything had to
    let mut writer: BTreeMap<LabelId, usize> = BTreeMap::new();
    let mut known: BTreeMap<LabelId, usize> = BTreeMap::new();
    let mut touched = Touched::default();
    for number in 0..phases.len() {
        let reads = of_nodes(&phases[number]).filter(|(_, a)| a.mode.reads());
        let across =
            reads.filter(|(_, a)| a.ghost > 0 || spread.get(&a.label).is_some_and(|&ghost| ghost > 0));
        let halos: BTreeSet<LabelId> = across.map(|(_, a)| a.label).collect();
        for &label in &halos {
            let way = if label.is_partial() { Way::Partials } else { Way::Values };
            let written = writer.remove(&label);
            let from = match (written, known.get(&label)) {
                (Some(_), _) => written,
                (None, Some(&sent)) => {
                    exchanges[sent].read_too(&phases[number], label, &touched);
                    continue;
                }
                (None, None) if label.life() < Life::Step => continue,
                (None, None) => None,
            };
            let fits =
                |e: &Exchange| (e.from, e.to, e.way) == (from, number, way) && e.labels.len() < MOST_LABELS;
            let at = exchanges.iter().position(fits).unwrap_or_else(|| {
                let (adders, materials, labels, whole) = (Adders::new(), BTreeSet::new(), Vec::new(), false);
                exchanges.push(Exchange { from, to: number, way, labels, adders, materials, whole });
                exchanges.len() - 1
            });
            exchanges[at].labels.push(label);
            known.insert(label, at);
            match way {
                Way::Values => exchanges[at].read_too(&phases[number], label, &touched),
                Way::Partials => {
                    exchanges[at].added(&phases[..from.map_or(0, |from| from + 1)], label);
                    touched.tell(&exchanges[at].materials, from, number);
                }
            }
        }
        for (_, access) in of_nodes(&phases[number]).filter(|(_, a)| a.mode.writes()) {
            if access.mode == Mode::Computes {
                spread.insert(access.label, access.ghost);
            }
            writer.insert(access.label, number);
        }
        if phases[number].is_over_nodes() {
            phases[number].stages.iter_mut().for_each(|stage| stage.unknown.clone_from(&touched.unknown));
        }
        touched.note(schema, &phases[number], number);
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

impl Exchange {
    /// Particles have added to one of the labels in some phases: what they have added travels, and which nodes all touch.
    fn added(&mut self, phases: &[Phase], label: LabelId) {
        for stage in phases.iter().flat_map(|phase| &phase.stages).filter(|stage| !stage.adds.is_empty()) {
            let Some(material) = stage.material else { continue };
            self.materials.insert(material);
            if stage.adds.contains(&label) {
                self.adders.insert(label, material);
            }
        }
    }

    /// Particles of a phase read one of the labels: what travels has to hold what they touch.
    fn read_too(&mut self, phase: &Phase, label: LabelId, touched: &Touched) {
        let readers = phase.stages.iter().filter(|stage| stage.reads.contains(&label));
        for material in readers.filter_map(|stage| stage.material) {
            self.whole |= self.way == Way::Values && !touched.is_known(material, self.from);
            self.materials.insert(material);
        }
    }
}

/// Of which materials other ranks know which nodes they touch: partial sums say it.
#[derive(Default)]
struct Touched {
    /// Materials that have added to nodes and not moved since, and the first phase in which they did.
    added: BTreeMap<usize, usize>,
    /// Those whose partial sums have come to other ranks, and the phase for which.
    told: BTreeMap<usize, usize>,
    /// Those that have added to nodes, and other ranks do not know to which.
    unknown: BTreeSet<usize>,
}

impl Touched {
    /// Partial sums of some materials are sent after phase `from`, for phase `to`.
    fn tell(&mut self, materials: &BTreeSet<usize>, from: Option<usize>, to: usize) {
        let before = |material: &&usize| {
            self.added.get(material).is_some_and(|first| from.is_some_and(|from| *first <= from))
        };
        for &material in materials.iter().filter(before) {
            self.told.entry(material).or_insert(to);
            self.unknown.remove(&material);
        }
    }

    /// Notes what a phase does.
    fn note(&mut self, schema: &Schema, phase: &Phase, number: usize) {
        for stage in &phase.stages {
            let Some(material) = stage.material else { continue };
            if !stage.adds.is_empty() && !self.added.contains_key(&material) {
                self.added.insert(material, number);
                self.unknown.insert(material);
            }
            if stage.touches(schema.roles.extent, Mode::writes) {
                self.added.remove(&material);
                self.told.remove(&material);
            }
        }
    }

    /// Whether those who send after phase `from` know which nodes a material touches.
    fn is_known(&self, material: usize, from: Option<usize>) -> bool {
        from.is_some_and(|from| self.told.get(&material).is_some_and(|&to| to <= from))
    }
}

/// Partial sums that live for a stage are added up wherever they are read, others by the first stage after they were
/// written. Particles release the buffers of those that nobody reads any more.
fn partial_sums(phases: &mut [Phase]) {
    // who has added since a label was added up last, and who ever has
    let (mut fresh, mut all) = (BTreeSet::new(), BTreeSet::new());
    let mut last_use: BTreeMap<LabelId, usize> = BTreeMap::new();
    for (number, phase) in phases.iter_mut().enumerate() {
        for stage in &mut phase.stages {
            let partial = stage.touched.iter().filter(|a| a.label.is_partial());
            match stage.domain {
                Domain::Nodes => {
                    let read = partial.filter(|a| a.mode.reads()).map(|a| a.label);
                    let added = |label: &LabelId| fresh.iter().any(|(other, _)| other == label);
                    stage.sums = read.filter(|label| label.life() == Life::Stage || added(label)).collect();
                    let summed = |(label, _): &&(LabelId, usize)| stage.sums.contains(label);
                    for &(label, material) in all.iter().filter(summed) {
                        // what lives for a stage is nowhere but in the parts
                        let again = label.life() == Life::Stage || fresh.remove(&(label, material));
                        let list = if again { &mut stage.adders } else { &mut stage.kept };
                        list.insert(label, material);
                    }
                    last_use.extend(stage.sums.iter().map(|&label| (label, number)));
                }
                _ => {
                    let adds = stage.adds.iter().filter_map(|&label| Some((label, stage.material?)));
                    adds.for_each(|pair| {
                        fresh.insert(pair);
                        all.insert(pair);
                    });
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
