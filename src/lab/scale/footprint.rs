//! The blocks of a scene at its start, and what ranks would do and send with them.
use super::load::{Counts, Listed, Message, Passing};
use super::model::Setup;
use super::step::Tick;
use super::torus::Brick;
use crate::lab::plan;
use crate::simulation::layout;
use engine::data::activate::FARTHEST;
use engine::data::extent::{self, MARGIN};
use engine::data::nodes::NOWHERE;
use engine::exec::halo::{back, overlap};
use engine::graph::exchange::Exchange;
use grid::{BlockIndex, BlockShape, Decomposition, IndexBox, Level, Partition};
use scene::Scene;
use std::collections::BTreeMap;

/// A block of particles.
struct Block {
    index: BlockIndex,
    material: usize,
    count: f64,
    near: bool,
    touched: IndexBox,
    /// Node blocks around that exist, with the nodes of each that this block touches.
    around: Vec<(usize, IndexBox)>,
}

/// The blocks of a scene.
pub struct Footprint {
    level: Level,
    blocks: Vec<Block>,
    /// Blocks of nodes, with the materials of the fields that they hold.
    nodes: Vec<(BlockIndex, Vec<usize>)>,
    /// Fields of each material.
    fields: Vec<usize>,
    /// Particles in each block.
    census: Vec<(BlockIndex, u64)>,
}

/// What passes, by sender and receiver, and material.
type Pairs = BTreeMap<(usize, usize), Vec<Passing>>;

impl Footprint {
    /// The blocks of a scene, with the nodes that their particles touch once steps have been taken.
    ///
    /// # Errors
    /// A level that holds no patch.
    pub fn of(scene: &Scene) -> Result<Self, String> {
        Self::with(scene, 2.0 * MARGIN)
    }

    /// The same in the first step: the nodes beside a lattice that lies on nodes count too, since nobody has looked yet on
    /// which side its particles are to rounding.
    ///
    /// # Errors
    /// A level that holds no patch.
    pub fn at_start(scene: &Scene) -> Result<Self, String> {
        Self::with(scene, 0.0)
    }

    /// Blocks whose extents are `margin` smaller.
    fn with(scene: &Scene, margin: f64) -> Result<Self, String> {
        let level = layout::level(scene);
        let warehouse = plan::outline(scene, Decomposition::new(&level, [1; 3])?);
        let nodes = warehouse.nodes.iter().flat_map(|patch| &patch.blocks);
        let material = |field: &_| warehouse.fields.material(*field);
        let nodes = nodes.map(|block| (block.index, block.present.iter().map(material).collect())).collect();
        let (mut blocks, mut census) = (Vec::new(), BTreeMap::new());
        for (material, block) in warehouse.blocks() {
            let bounds = extent::largest(&block.extent).map(|y| y - margin);
            let touched = extent::touched(&extent::from_largest(bounds), &level, block.index);
            let there = block.around.iter().enumerate().filter(|(_, place)| **place != NOWHERE);
            // all are on the one patch
            let shape = level.shape();
            let around = there.map(|(q, place)| (place.1 as usize, shared(&shape, q, &touched))).collect();
            let (index, count, near) = (block.index, block.count as f64, block.near);
            blocks.push(Block { index, material, count, near, touched, around });
            *census.entry(block.index).or_default() += block.count as u64;
        }
        let fields = (0..scene.materials.len()).map(|m| warehouse.fields.of(m).len()).collect();
        Ok(Self { level, blocks, nodes, fields, census: census.into_iter().collect() })
    }

    /// Particles by material.
    pub fn particles(&self) -> Vec<f64> {
        let mut counts = vec![0.0; self.fields.len()];
        self.blocks.iter().for_each(|block| counts[block.material] += block.count);
        counts
    }

    /// Blocks of particles.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Blocks of nodes, once for each field.
    pub fn nodes(&self) -> f64 {
        self.nodes.iter().map(|(_, fields)| fields.len() as f64).sum()
    }

    /// The finest patches: one block each.
    ///
    /// # Errors
    /// A level that holds no patch.
    pub fn finest(&self) -> Result<Decomposition, String> {
        Decomposition::new(&self.level, self.level.block_columns())
    }

    /// Patches as a run on so many workers cuts them.
    ///
    /// # Errors
    /// A level that holds no patch.
    pub fn usual(&self, workers: usize) -> Result<Decomposition, String> {
        let wanted = 8 * workers;
        Decomposition::new(&self.level, Decomposition::automatic(&self.level, wanted, &self.census))
    }

    /// Patches that hold particles.
    pub fn occupied(&self, patches: &Decomposition) -> usize {
        patches.loads(&self.census).into_iter().filter(|load| *load > 0).count()
    }

    /// A brick with the mean of all blocks.
    pub fn brick(&self, patches: f64) -> Brick {
        let particles = self.particles();
        let all = particles.iter().sum::<f64>().max(1.0);
        let mean = |of: &dyn Fn(&Block) -> f64| {
            self.blocks.iter().map(|block| block.count * of(block)).sum::<f64>() / all
        };
        let axes = |of: &dyn Fn(&Block, usize) -> i32| {
            mean(&|block| (0..3).map(|a| f64::from(of(block, a).max(0))).sum::<f64>() / 3.0)
        };
        // a buffer begins one node below its block
        let below = axes(&|block, a| 1 - block.touched.lower[a]);
        let above = axes(&|block, a| block.touched.upper[a] - 5);
        let share = |material, near| {
            mean(&|block| f64::from(u8::from((block.material, block.near) == (material, near))))
        };
        let parts = (0..self.fields.len()).map(|m| [share(m, false), share(m, true)]).collect();
        let counts = self.counts(&vec![0; self.blocks.len()], &vec![0; self.nodes.len()], 1);
        let sum = |pair: &[f64; 2]| pair[0] + pair[1];
        let blocks = counts[0].blocks.iter().map(sum).collect();
        let nodes = counts[0].nodes.iter().map(|(fields, pair)| (fields.clone(), sum(pair))).collect();
        let fields = self.fields.clone();
        Brick { particles, blocks, nodes, reach: [below, above], fields, parts, patches }
    }

    /// What ranks do and send if they share `patches`.
    ///
    /// # Errors
    /// Fewer patches than ranks.
    pub fn ranks(&self, patches: &Decomposition, ranks: usize, setup: &Setup<'_>) -> Result<Listed, String> {
        let partition = Partition::by_cost(patches, &patches.loads(&self.census), 0, ranks)?;
        let rank_of = |index: BlockIndex| patches.owner(index).map_or(0, |patch| partition.rank_of(patch));
        let homes: Vec<usize> = self.blocks.iter().map(|block| rank_of(block.index)).collect();
        let nodes: Vec<usize> = self.nodes.iter().map(|(index, _)| rank_of(*index)).collect();
        let mut counts = self.counts(&homes, &nodes, ranks);
        (0..patches.patches.len()).for_each(|patch| counts[partition.rank_of(patch)].patches += 1.0);
        let pairs = self.pairs(&homes, &nodes, &rank_of);
        let mut beside = vec![Vec::new(); ranks];
        pairs.keys().for_each(|&(from, to)| beside[from].push(to as u32));
        let kinds = &setup.step.kinds;
        let loads = kinds.iter().map(|tick| counts.iter().map(|it| it.load(setup, tick)).collect()).collect();
        let exchanges = &setup.step.graph.exchanges;
        let sends = |tick| exchanges.iter().map(|e| self.sends(&pairs, ranks, tick, e)).collect();
        Ok(Listed { loads, sends: kinds.iter().map(sends).collect(), beside })
    }

    /// The messages of an exchange, by rank.
    fn sends(&self, pairs: &Pairs, ranks: usize, tick: &Tick, exchange: &Exchange) -> Vec<Vec<Message>> {
        let mut sends = vec![Vec::new(); ranks];
        for (&(from, to), passing) in pairs {
            if let Some(bytes) = Passing::bytes(passing, exchange, tick) {
                sends[from].push(Message { to: to as u32, bytes });
            }
        }
        sends
    }

    /// Rim and interior as `data::activate` marks them.
    fn counts(&self, homes: &[usize], nodes: &[usize], ranks: usize) -> Vec<Counts> {
        let mut waits = vec![false; nodes.len()];
        for (block, home) in self.blocks.iter().zip(homes) {
            block
                .around
                .iter()
                .filter(|(node, _)| nodes[*node] != *home)
                .for_each(|(node, _)| waits[*node] = true);
        }
        let none = vec![[0.0; 2]; self.fields.len()];
        let empty = Counts { particles: none.clone(), blocks: none, ..Counts::default() };
        let mut counts = vec![empty; ranks];
        for ((rank, waits), (_, fields)) in nodes.iter().zip(&waits).zip(&self.nodes) {
            let known = &mut counts[*rank].nodes;
            let at = known.iter().position(|(of, _)| of == fields).unwrap_or_else(|| {
                known.push((fields.clone(), [0.0; 2]));
                known.len() - 1
            });
            known[at].1[usize::from(!waits)] += 1.0;
        }
        for (block, home) in self.blocks.iter().zip(homes) {
            let rim = block.around.iter().any(|(node, _)| nodes[*node] != *home || waits[*node]);
            let part = usize::from(!rim);
            counts[*home].particles[block.material][part] += block.count;
            counts[*home].blocks[block.material][part] += 1.0;
        }
        counts
    }

    /// What passes from rank to rank, for all that have blocks in sight of each other.
    fn pairs(&self, homes: &[usize], nodes: &[usize], rank_of: &dyn Fn(BlockIndex) -> usize) -> Pairs {
        let mut pairs = Pairs::new();
        let nothing = || -> Vec<Passing> {
            self.fields.iter().map(|&fields| Passing { fields, ..Passing::default() }).collect()
        };
        let mut read: BTreeMap<(usize, usize, usize), IndexBox> = BTreeMap::new();
        let mut beside = Vec::new();
        for (block, &home) in self.blocks.iter().zip(homes) {
            beside.clear();
            for &(node, touched) in block.around.iter().filter(|(node, _)| nodes[*node] != home) {
                let (to, material) = (nodes[node], block.material);
                let passing = &mut pairs.entry((home, to)).or_insert_with(nothing)[material];
                passing.added[usize::from(block.near)] += touched.len() as f64;
                if !beside.contains(&to) {
                    beside.push(to);
                    passing.adders += 1.0;
                    // who has added to nodes reads them
                    pairs.entry((to, home)).or_insert_with(nothing)[material].readers += 1.0;
                }
                if !touched.is_empty() {
                    let known = read.entry((node, block.material, home)).or_insert(touched);
                    *known = known.around(&touched);
                }
            }
        }
        for ((node, material, reader), touched) in read {
            let passing = pairs.entry((nodes[node], reader)).or_insert_with(nothing);
            passing[material].read += touched.len() as f64;
        }
        self.in_sight(rank_of, |pair| {
            pairs.entry(pair).or_insert_with(nothing);
        });
        pairs
    }

    /// Hands out pairs of ranks that have blocks in sight of each other, occupied or not: these tell each other about
    /// travelers.
    fn in_sight(&self, rank_of: &dyn Fn(BlockIndex) -> usize, mut each: impl FnMut((usize, usize))) {
        let all = self.level.blocks();
        let ranks: Vec<usize> = all.iter().map(rank_of).collect();
        let at = |index: BlockIndex| all.offset(index).map(|at| ranks[at]);
        let mut last = (0, 0);
        for index in all.iter() {
            let Some(here) = at(index) else { continue };
            let cube = IndexBox { lower: index, upper: index.map(|i| i + 1) }.grown(FARTHEST);
            for other in cube.common(&all).iter() {
                let there = at(other);
                let Some(there) = there.filter(|there| *there != here && (here, *there) != last) else {
                    continue;
                };
                last = (here, there);
                each(last);
            }
        }
    }
}

/// The nodes of the `q`-th block around that lie in the touched part of a block's buffer.
fn shared(shape: &BlockShape, q: usize, touched: &IndexBox) -> IndexBox {
    let nothing = IndexBox { lower: [0; 3], upper: [0; 3] };
    overlap(shape, back(q), touched).map_or(nothing, |(nodes, _)| nodes)
}
