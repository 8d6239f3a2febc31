//! What patches and ranks send each other in a tick, as plain numbers from who has the data.
use super::build::TaskGraph;
use super::exchange::{Exchange, Way};
use super::phase::Phase;
use crate::schema::{Home, LabelId};
use std::collections::{BTreeMap, BTreeSet};

/// Bytes of a line: one node of one material, or eight numbers of anything else.
pub const LINE: u64 = 64;

/// Lines by label and material.
pub type Lines = BTreeMap<(LabelId, usize), u64>;

/// What passes between patches and ranks when all materials act.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Number of ranks.
    pub ranks: usize,
    /// The rank of each patch.
    pub rank_of: Vec<usize>,
    /// Particles: `[patch][material]`.
    pub particles: Vec<Vec<u64>>,
    /// Those of them near another material.
    pub near: Vec<Vec<u64>>,
    /// Blocks with particles: `[patch][material]`.
    pub blocks: Vec<Vec<u64>>,
    /// Lines that a tile of a label takes whose tiles materials decide.
    pub of_material: BTreeMap<(LabelId, usize), u64>,
    /// Nodes: `[patch][material]`.
    pub nodes: Vec<Vec<u64>>,
    /// From patch to patch, and from a patch to itself.
    pub between: BTreeMap<(usize, usize), Lines>,
    /// From a patch to a rank. What several patches of a rank read travels once.
    pub to_rank: BTreeMap<(usize, usize), Lines>,
    /// The same of values, if those of all nodes travel that particles may touch.
    pub whole: BTreeMap<(usize, usize), Lines>,
    /// For each patch and rank, the particle blocks of the patch that add to nodes of the rank: each has a line in a
    /// message that says which nodes it touches.
    pub adders: BTreeMap<(usize, usize), u64>,
    /// Pairs of ranks (both ways) that have blocks in sight of each other.
    pub neighbors: BTreeSet<(usize, usize)>,
    /// Messages of one reduction, from rank to rank.
    pub reduction: Vec<(usize, usize)>,
}

/// Messages by sender and receiver.
pub type Pairs = BTreeMap<(usize, usize), Messages>;

/// Messages from one rank to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Messages {
    /// How many.
    pub count: u64,
    /// Bytes of all of them.
    pub bytes: u64,
}

impl Messages {
    /// Adds messages.
    pub fn add(&mut self, count: u64, bytes: u64) {
        (self.count, self.bytes) = (self.count + count, self.bytes + bytes);
    }
}

impl Traffic {
    /// Nothing, on one patch and one rank: for graphs without a scene.
    pub fn none(materials: usize) -> Self {
        let zeros = || vec![vec![0; materials]];
        let (particles, near, blocks, nodes) = (zeros(), zeros(), zeros(), zeros());
        Self { ranks: 1, rank_of: vec![0], particles, near, blocks, nodes, ..Self::default() }
    }

    /// Lines that eight particles of a material, or one of whatever else has the label, take.
    pub fn width(&self, label: LabelId, material: usize) -> u64 {
        match label.by_material() {
            true => self.of_material.get(&(label, material)).copied().unwrap_or(0),
            false => label.width() as u64,
        }
    }

    /// Number of patches.
    pub fn patches(&self) -> usize {
        self.rank_of.len()
    }

    /// Bytes of some labels of a material (`None`: of all) from patch to patch.
    pub fn patch_bytes(&self, from: usize, to: usize, labels: &[LabelId], material: Option<usize>) -> u64 {
        LINE * self.between.get(&(from, to)).map_or(0, |lines| select(lines, labels, material))
    }

    /// Bytes of some labels of a material (`None`: of all) from a patch to a rank.
    pub fn rank_bytes(&self, from: usize, to: usize, labels: &[LabelId], material: Option<usize>) -> u64 {
        LINE * self.to_rank.get(&(from, to)).map_or(0, |lines| select(lines, labels, material))
    }

    /// Bytes of some labels of a material (`None`: of all) that stay on a rank (`false`) or travel to another (`true`).
    pub fn total_bytes(&self, labels: &[LabelId], material: Option<usize>, travel: bool) -> u64 {
        let lines: u64 = match travel {
            true => self.traveling().map(|(_, _, lines)| select(lines, labels, material)).sum(),
            false => {
                let stays = |&(&(a, b), _): &(&(usize, usize), &Lines)| self.rank_of[a] == self.rank_of[b];
                self.between.iter().filter(stays).map(|(_, lines)| select(lines, labels, material)).sum()
            }
        };
        LINE * lines
    }

    /// What leaves patches for other ranks: patch, rank and lines.
    pub fn traveling(&self) -> impl Iterator<Item = (usize, usize, &Lines)> {
        self.leaving(&self.to_rank)
    }

    fn leaving<'a>(
        &self,
        lines: &'a BTreeMap<(usize, usize), Lines>,
    ) -> impl Iterator<Item = (usize, usize, &'a Lines)> {
        let lines = lines.iter().map(|(&(patch, rank), lines)| (patch, rank, lines));
        lines.filter(|&(patch, rank, _)| self.rank_of[patch] != rank)
    }

    /// An exchange: one message for each pair of ranks of which one has particles beside nodes of the other.
    pub fn exchange(&self, exchange: &Exchange) -> Pairs {
        let mut pairs = Pairs::new();
        for (&(patch, to), &blocks) in self.adders.iter().filter(|((p, to), _)| self.rank_of[*p] != *to) {
            let from = self.rank_of[patch];
            let (pair, lines) = match exchange.way {
                Way::Partials => ((from, to), blocks),
                // who has added to nodes reads them
                Way::Values => ((to, from), 0),
            };
            let messages = pairs.entry(pair).or_default();
            (messages.count, messages.bytes) = (1, messages.bytes + LINE * lines);
        }
        let travels = |key: &(LabelId, usize)| match exchange.way {
            Way::Partials => exchange.givers.contains(key),
            Way::Values => exchange.labels.contains(&key.0),
        };
        for (patch, to, lines) in self.leaving(if exchange.whole { &self.whole } else { &self.to_rank }) {
            if let Some(messages) = pairs.get_mut(&(self.rank_of[patch], to)) {
                let lines = lines.iter().filter(|(key, _)| travels(key)).map(|(_, lines)| lines).sum::<u64>();
                messages.bytes += LINE * lines;
            }
        }
        pairs
    }

    /// All exchanges that a phase needs.
    pub fn halo(&self, phase: &Phase, exchanges: &[Exchange]) -> Pairs {
        let mut pairs = Pairs::new();
        for &number in &phase.receives {
            for (pair, messages) in self.exchange(&exchanges[number]) {
                pairs.entry(pair).or_default().add(messages.count, messages.bytes);
            }
        }
        pairs
    }

    /// Messages of a reduction of `labels`, by pair of ranks.
    pub fn reduce(&self, labels: &[LabelId]) -> Pairs {
        let bytes = self.reduced_bytes(labels);
        let mut pairs: Pairs = BTreeMap::new();
        self.reduction.iter().for_each(|&pair| pairs.entry(pair).or_default().add(1, bytes));
        pairs
    }

    /// Bytes of a message with all shared values of `labels`, and a line that counts particles.
    pub fn reduced_bytes(&self, labels: &[LabelId]) -> u64 {
        let materials = self.particles.first().map_or(1, Vec::len) as u64;
        let tiles = |label: &LabelId| if label.home() == Home::Material { materials } else { 1 };
        LINE * (1 + labels.iter().map(|label| label.width() as u64 * tiles(label)).sum::<u64>())
    }

    /// One message to each neighbor, with a line that says how many particles follow.
    pub fn relocation(&self) -> Pairs {
        self.neighbors.iter().map(|&pair| (pair, Messages { count: 1, bytes: LINE })).collect()
    }

    /// Messages of a tick by what they are about: halos by their phase, then all reductions, then relocation.
    pub fn by_cause(&self, graph: &TaskGraph) -> Vec<(String, Pairs)> {
        let (at_end, mut causes) = (&graph.at_end, Vec::new());
        for phase in &graph.phases {
            if !phase.halos.is_empty() {
                causes.push((names(&phase.halos), self.halo(phase, &graph.exchanges)));
            }
            if !phase.reductions.is_empty() {
                causes.push((
                    format!("reduction of {}", names(&phase.reductions)),
                    self.reduce(&phase.reductions),
                ));
            }
        }
        if !at_end.is_empty() {
            causes.push(("reduction at the end".to_owned(), self.reduce(at_end)));
        }
        if graph.moves_particles() {
            causes.push(("relocation".to_owned(), self.relocation()));
        }
        causes
    }
}

/// Names of labels in a row.
pub fn names(labels: &[LabelId]) -> String {
    labels.iter().map(|label| label.name()).collect::<Vec<_>>().join(", ")
}

fn select(lines: &Lines, labels: &[LabelId], material: Option<usize>) -> u64 {
    let wanted = |&(&(label, m), _): &(&(LabelId, usize), &u64)| {
        labels.contains(&label) && material.is_none_or(|wanted| m == wanted)
    };
    lines.iter().filter(wanted).map(|(_, lines)| lines).sum()
}
