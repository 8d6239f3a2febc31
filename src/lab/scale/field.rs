//! The blocks of a scene at its start, and what ranks would do and send with them.
use super::load::{Counts, Edge, Listed};
use super::model::Costs;
use super::torus::Brick;
use crate::lab::plan;
use crate::simulation::layout;
use engine::data::activate::FARTHEST;
use engine::data::extent::{self, MARGIN};
use engine::data::nodes::NOWHERE;
use engine::exec::halo::{back, overlap};
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
pub struct Field {
    level: Level,
    blocks: Vec<Block>,
    /// Blocks of nodes, with how many materials they hold.
    nodes: Vec<(BlockIndex, f64)>,
    materials: usize,
    /// Particles in each block.
    census: Vec<(BlockIndex, u64)>,
}

/// Bytes of a line.
const LINE: f32 = 64.0;

impl Field {
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
        let nodes = nodes.map(|block| (block.index, block.present.len() as f64)).collect();
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
        let materials = scene.materials.len();
        Ok(Self { level, blocks, nodes, materials, census: census.into_iter().collect() })
    }

    /// Particles by material.
    pub fn particles(&self) -> Vec<f64> {
        let mut counts = vec![0.0; self.materials];
        self.blocks.iter().for_each(|block| counts[block.material] += block.count);
        counts
    }

    /// Blocks of particles.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    /// Blocks of nodes, once for each material.
    pub fn nodes(&self) -> f64 {
        self.nodes.iter().map(|(_, materials)| materials).sum()
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
        let (all, blocks) = (particles.iter().sum::<f64>().max(1.0), self.blocks.len() as f64);
        let mean = |of: &dyn Fn(&Block) -> f64| {
            self.blocks.iter().map(|block| block.count * of(block)).sum::<f64>() / all
        };
        let axes = |of: &dyn Fn(&Block, usize) -> i32| {
            mean(&|block| (0..3).map(|a| f64::from(of(block, a).max(0))).sum::<f64>() / 3.0)
        };
        // a buffer begins one node below its block
        let below = axes(&|block, a| 1 - block.touched.lower[a]);
        let above = axes(&|block, a| block.touched.upper[a] - 5);
        let buffers = 1.0 + mean(&|block| f64::from(u8::from(block.near)));
        let nodes = self.nodes() / blocks.max(1.0);
        Brick { particles, blocks, nodes, reach: [below, above], buffers, patches }
    }

    /// What ranks of `threads` workers do and send if they share `patches`.
    ///
    /// # Errors
    /// Fewer patches than ranks.
    pub fn ranks(
        &self,
        patches: &Decomposition,
        ranks: usize,
        costs: &Costs,
        threads: usize,
    ) -> Result<Listed, String> {
        let partition = Partition::by_cost(patches, &patches.loads(&self.census), 0, ranks)?;
        let rank_of = |index: BlockIndex| patches.owner(index).map_or(0, |patch| partition.rank_of(patch));
        let homes: Vec<usize> = self.blocks.iter().map(|block| rank_of(block.index)).collect();
        let nodes: Vec<usize> = self.nodes.iter().map(|(index, _)| rank_of(*index)).collect();
        let mut counts = self.counts(&homes, &nodes, ranks);
        (0..patches.patches.len()).for_each(|patch| counts[partition.rank_of(patch)].patches += 1.0);
        let mut edges = vec![Vec::new(); ranks];
        for ((from, to), [sums, motion]) in self.pairs(&homes, &nodes, &rank_of) {
            edges[from].push(Edge { to: to as u32, sums, motion });
        }
        Ok(Listed { loads: counts.iter().map(|counts| counts.load(costs, threads)).collect(), edges })
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
        let empty = Counts { particles: vec![[0.0; 2]; self.materials], ..Counts::default() };
        let mut counts = vec![empty; ranks];
        for ((rank, waits), (_, materials)) in nodes.iter().zip(&waits).zip(&self.nodes) {
            counts[*rank].nodes[usize::from(!waits)] += materials;
        }
        for (block, home) in self.blocks.iter().zip(homes) {
            let rim = block.around.iter().any(|(node, _)| nodes[*node] != *home || waits[*node]);
            let part = usize::from(!rim);
            counts[*home].particles[block.material][part] += block.count;
            counts[*home].blocks[part] += 1.0;
        }
        counts
    }

    /// Bytes of sums and motion from rank to rank, for all that have blocks in sight of each other.
    fn pairs(
        &self,
        homes: &[usize],
        nodes: &[usize],
        rank_of: &dyn Fn(BlockIndex) -> usize,
    ) -> BTreeMap<(usize, usize), [f32; 2]> {
        let mut pairs: BTreeMap<(usize, usize), [f32; 2]> = BTreeMap::new();
        let mut read: BTreeMap<(usize, usize, usize), IndexBox> = BTreeMap::new();
        let mut beside = Vec::new();
        for (block, &home) in self.blocks.iter().zip(homes) {
            beside.clear();
            for &(node, touched) in block.around.iter().filter(|(node, _)| nodes[*node] != home) {
                let to = nodes[node];
                let buffers = if block.near { 2.0 } else { 1.0 };
                pairs.entry((home, to)).or_default()[0] += LINE * buffers * touched.len() as f32;
                if !beside.contains(&to) {
                    beside.push(to);
                }
                if !touched.is_empty() {
                    let known = read.entry((node, block.material, home)).or_insert(touched);
                    *known = known.around(&touched);
                }
            }
            // a line that says what follows
            beside.iter().for_each(|&to| pairs.entry((home, to)).or_default()[0] += LINE);
        }
        for ((node, _, reader), touched) in read {
            pairs.entry((nodes[node], reader)).or_default()[1] += LINE * touched.len() as f32;
        }
        self.in_sight(rank_of, |pair| {
            pairs.entry(pair).or_default();
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
