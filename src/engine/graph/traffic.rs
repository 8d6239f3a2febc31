//! What patches and ranks send each other in a tick, as plain numbers from who has the data.
use super::build::TaskGraph;
use super::exchange::{Exchange, Way};
use super::phase::Phase;
use crate::schema::{Crossing, LabelId, Tiles};
use std::collections::{BTreeMap, BTreeSet};

/// Bytes of a line: one node of one field, or eight numbers of anything else.
pub const LINE: u64 = 64;

/// What passes from one place to another because of the particles of a material. Nodes are counted where no other material
/// is near or no other field is present, then where one is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Passing {
    /// Particle blocks that have nodes of the receiver around them: each has a line in a message that says which nodes it
    /// touches.
    pub adders: u64,
    /// Nodes of the receiver that particles of the sender add to.
    pub added: [u64; 2],
    /// Nodes of the sender that particles of the receiver read.
    pub read: [u64; 2],
    /// The same, if those of all nodes travel that particles may touch.
    pub whole: [u64; 2],
}

impl Passing {
    /// Nodes that pass with a label.
    fn nodes(&self, label: LabelId, whole: bool) -> u64 {
        let [elsewhere, there] = match label.crossing() {
            Crossing::None => [0; 2],
            Crossing::Partials(_) => self.added,
            Crossing::Values(_) if whole => self.whole,
            Crossing::Values(_) => self.read,
        };
        if label.added_where_near() || label.where_fields_meet() { there } else { elsewhere + there }
    }
}

/// By sender and receiver: what passes, by material.
pub type Between = BTreeMap<(usize, usize), Vec<Passing>>;

/// What passes between patches and ranks.
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
    /// Tiles of labels of the run.
    pub tiles: Tiles,
    /// Nodes: `[patch][material]`.
    pub nodes: Vec<Vec<u64>>,
    /// Fields of each material.
    pub fields: Vec<u64>,
    /// From patch to patch, and from a patch to itself.
    pub between: Between,
    /// From a patch to a rank. What several patches of a rank read travels once.
    pub to_rank: Between,
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
        let fields = vec![1; materials];
        Self { ranks: 1, rank_of: vec![0], particles, near, blocks, nodes, fields, ..Self::default() }
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

    /// Bytes of a label of a material from patch to patch.
    pub fn patch_bytes(&self, from: usize, to: usize, label: LabelId, material: usize) -> u64 {
        self.between.get(&(from, to)).map_or(0, |passing| self.bytes(passing, label, material))
    }

    /// Bytes of a label of a material from a patch to a rank.
    pub fn rank_bytes(&self, from: usize, to: usize, label: LabelId, material: usize) -> u64 {
        self.to_rank.get(&(from, to)).map_or(0, |passing| self.bytes(passing, label, material))
    }

    /// Bytes of a label of a material that stay on a rank (`false`) or travel to another (`true`).
    pub fn total_bytes(&self, label: LabelId, material: usize, travel: bool) -> u64 {
        let bytes = |passing: &Vec<Passing>| self.bytes(passing, label, material);
        if travel {
            return self.leaving().map(|(_, passing)| bytes(passing)).sum();
        }
        let stays = |&(&(a, b), _): &(&(usize, usize), _)| self.rank_of[a] == self.rank_of[b];
        self.between.iter().filter(stays).map(|(_, passing)| bytes(passing)).sum()
    }

    fn bytes(&self, passing: &[Passing], label: LabelId, material: usize) -> u64 {
        LINE * self.lines(label, material) * passing[material].nodes(label, false)
    }

    /// Lines of a label that a node has for a material.
    fn lines(&self, label: LabelId, material: usize) -> u64 {
        self.fields[material] * self.width(label, material)
    }

    /// What leaves patches for other ranks: rank of the patch, other rank, and what passes.
    fn leaving(&self) -> impl Iterator<Item = ((usize, usize), &Vec<Passing>)> {
        let pairs = self.to_rank.iter().map(|(&(patch, to), passing)| ((self.rank_of[patch], to), passing));
        pairs.filter(|((from, to), _)| from != to)
    }

    /// An exchange in which the materials `act` that say so: one message for each pair of ranks of which one has particles
    /// beside nodes of the other.
    pub fn exchange(&self, exchange: &Exchange, act: impl Fn(usize) -> bool) -> Pairs {
        let acting: Vec<usize> = (0..self.fields.len()).filter(|&m| act(m) && exchange.concerns(m)).collect();
        let mut pairs = Pairs::new();
        for ((from, to), passing) in self.leaving() {
            let adders: u64 = acting.iter().map(|&material| passing[material].adders).sum();
            let (pair, lines) = match exchange.way {
                Way::Partials => ((from, to), adders),
                // who has added to nodes reads them
                Way::Values => ((to, from), 0),
            };
            if adders > 0 {
                let messages = pairs.entry(pair).or_default();
                (messages.count, messages.bytes) = (1, messages.bytes + LINE * lines);
            }
        }
        for (pair, passing) in self.leaving() {
            let Some(messages) = pairs.get_mut(&pair) else { continue };
            for &material in &acting {
                let travels = |label: &&LabelId| match exchange.way {
                    Way::Partials => exchange.adders.contains(**label, material),
                    Way::Values => true,
                };
                for &label in exchange.labels.iter().filter(travels) {
                    let nodes = passing[material].nodes(label, exchange.whole);
                    messages.bytes += LINE * self.lines(label, material) * nodes;
                }
            }
        }
        pairs
    }

    /// All exchanges that a phase needs.
    pub fn halo(&self, phase: &Phase, exchanges: &[Exchange]) -> Pairs {
        let mut pairs = Pairs::new();
        for &number in &phase.receives {
            for (pair, messages) in self.exchange(&exchanges[number], |_| true) {
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
        reduced_bytes(labels, self.fields.len(), &self.tiles)
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

/// Bytes of a message with all shared values of `labels`, of so many materials where each has its own; and a line of
/// counters.
pub fn reduced_bytes(labels: &[LabelId], materials: usize, tiles: &Tiles) -> u64 {
    let lines = |label: &LabelId| (label.width() * tiles.of(*label, materials)) as u64;
    LINE * (1 + labels.iter().map(lines).sum::<u64>())
}

/// Names of labels in a row.
pub fn names(labels: &[LabelId]) -> String {
    labels.iter().map(|label| label.name()).collect::<Vec<_>>().join(", ")
}
