//! All data of a run, by patch and material, and which blocks are active.
//!
//! Particle labels of the old and the new step share storage: the graph's write-after-read edges are what makes
//! that safe. Labels of nodes exist only in blocks that a field touches.
use super::fields::Fields;
use super::layout::{NodeLayout, ParticleLayout};
use super::nearby::Nearby;
use super::nodes::NodeBlock;
use super::particles::ParticleBlock;
use super::shared::Shared;
use crate::schema::{LabelId, Schema, Tiles};
use grid::{BlockIndex, Decomposition, IndexBox, Level, Partition};
use std::collections::BTreeMap;
use std::ops::Range;

/// What is known about a material without knowing its physics.
#[derive(Clone, Debug)]
pub struct MaterialData {
    /// Name in messages.
    pub name: String,
    /// Its particle labels.
    pub layout: ParticleLayout,
    /// Half-size of a particle in cells along each axis: it decides the block (0 for linear shape functions).
    pub half_size: [f64; 3],
    /// How many velocity fields it has.
    pub fields: usize,
    /// With which materials it interacts where they share nodes; with itself, if its fields do.
    pub interacts: Vec<bool>,
}

impl MaterialData {
    /// A material of point particles with some labels and one velocity field, which interacts with none.
    pub fn new(schema: &'static Schema, name: &str, labels: impl IntoIterator<Item = LabelId>) -> Self {
        let layout = ParticleLayout::new(schema, labels, BTreeMap::new());
        Self { name: name.to_owned(), layout, half_size: [0.0; 3], fields: 1, interacts: vec![false] }
    }
}

/// Particle blocks of one material on one patch, in x-major order of blocks.
#[derive(Clone, Debug, Default)]
pub struct ParticlePatch {
    /// The blocks.
    pub blocks: Vec<ParticleBlock>,
    /// The position in `blocks`, plus 1, of each block of the patch, 0: none.
    lookup: Vec<u32>,
    /// The position of the first block of each layer along x, and the end.
    layers: Vec<u32>,
}

/// Node blocks of one patch, in x-major order.
#[derive(Clone, Debug, Default)]
pub struct NodePatch {
    /// The blocks.
    pub blocks: Vec<NodeBlock>,
    layers: Vec<u32>,
}

impl ParticlePatch {
    /// Drops empty blocks, and sorts the others.
    pub(super) fn settle(&mut self, patch: IndexBox) {
        self.blocks.retain(|block| block.count > 0);
        self.blocks.sort_by_key(|block| block.index);
        self.lookup.fill(0);
        for (position, block) in (1..).zip(&self.blocks) {
            if let Some(at) = patch.offset(block.index) {
                self.lookup[at] = position;
            }
        }
        fill_layers(&mut self.layers, patch, self.blocks.iter().map(|block| block.index));
    }

    /// The blocks in some layers along x; `first` is the first layer of the patch.
    pub fn slab_mut(&mut self, first: i32, wanted: &Range<i32>) -> &mut [ParticleBlock] {
        let positions = positions(&self.layers, first, wanted);
        &mut self.blocks[positions]
    }
}

impl NodePatch {
    /// Notes where layers begin.
    pub(super) fn settle(&mut self, patch: IndexBox) {
        fill_layers(&mut self.layers, patch, self.blocks.iter().map(|block| block.index));
    }

    /// Positions of the blocks in some layers along x; `first` is the first layer of the patch.
    pub fn slab(&self, first: i32, wanted: &Range<i32>) -> Range<usize> {
        positions(&self.layers, first, wanted)
    }

    /// The blocks in some layers along x; `first` is the first layer of the patch.
    pub fn slab_mut(&mut self, first: i32, wanted: &Range<i32>) -> &mut [NodeBlock] {
        let positions = self.slab(first, wanted);
        &mut self.blocks[positions]
    }
}

/// All data of a run.
#[derive(Clone, Debug)]
pub struct Warehouse {
    /// All labels.
    pub schema: &'static Schema,
    /// The grid.
    pub level: Level,
    /// The patches.
    pub decomposition: Decomposition,
    /// The rank of each patch. Patches of other ranks hold only what this rank receives from them: blocks without
    /// particles, with what they give to nodes here, and node blocks with what particles here read.
    pub partition: Partition,
    /// The materials.
    pub materials: Vec<MaterialData>,
    /// Their velocity fields.
    pub fields: Fields,
    /// Labels of nodes.
    pub node_layout: NodeLayout,
    /// Particles: `[patch][material]`.
    pub particles: Vec<Vec<ParticlePatch>>,
    /// Nodes: `[patch]`.
    pub nodes: Vec<NodePatch>,
    /// Labels of materials and of the run.
    pub shared: Shared,
    /// How many tiles labels of the run have.
    pub tiles: Tiles,
    /// What else particles may be near.
    pub nearby: Option<Nearby>,
    /// Whether blocks became occupied since the last [`Warehouse::activate`].
    pub reactivate: bool,
    /// Whether materials have rates of their own: one moves while another waits.
    pub own_rates: bool,
}

impl Warehouse {
    /// An empty warehouse. `node_labels` are the labels of nodes that graphs use.
    pub fn new(
        schema: &'static Schema,
        level: Level,
        (decomposition, partition): (Decomposition, Partition),
        materials: Vec<MaterialData>,
        node_labels: impl IntoIterator<Item = LabelId>,
    ) -> Self {
        let patches = decomposition.patches.len();
        let empty = vec![ParticlePatch::default(); materials.len()];
        let mut particles = vec![empty; patches];
        let nodes = vec![NodePatch::default(); patches];
        for patch in partition.mine() {
            let blocks = decomposition.patches[patch].blocks.len();
            particles[patch].iter_mut().for_each(|p| p.lookup = vec![0; blocks]);
        }
        let fields = Fields::new(materials.iter().map(|material| material.fields));
        let node_layout = NodeLayout::new(schema, node_labels, level.shape());
        let (shared, reactivate, own_rates) =
            (Shared::new(schema, materials.len(), &Tiles::default()), true, false);
        Self {
            schema,
            level,
            decomposition,
            partition,
            materials,
            fields,
            node_layout,
            particles,
            nodes,
            shared,
            tiles: Tiles::default(),
            nearby: None,
            reactivate,
            own_rates,
        }
    }

    /// Labels have so many tiles, as recipes say; their values are lost.
    pub fn set_tiles(&mut self, tiles: &Tiles) {
        self.shared = Shared::new(self.schema, self.materials.len(), tiles);
        self.tiles = tiles.clone();
    }

    /// Gives patches to other ranks. Whoever calls it has seen to the blocks: those of patches that are not this rank's any
    /// more are dropped, and so are copies of blocks that become its own.
    pub fn set_partition(&mut self, partition: Partition) {
        let old = std::mem::replace(&mut self.partition, partition);
        for (patch, homes) in self.particles.iter_mut().enumerate() {
            let mine = self.partition.is_mine(patch);
            let slots = if mine { self.decomposition.patches[patch].blocks.len() } else { 0 };
            for home in homes {
                home.blocks.retain(|_| mine);
                home.lookup = vec![0; slots];
            }
            if !(mine && old.is_mine(patch)) {
                self.nodes[patch] = NodePatch::default();
            }
        }
        self.reactivate = true;
    }

    /// Number of particles on this rank.
    pub fn particle_count(&self) -> usize {
        self.blocks().map(|(_, block)| block.count).sum()
    }

    /// All particle blocks with their materials, patch by patch.
    pub fn blocks(&self) -> impl Iterator<Item = (usize, &ParticleBlock)> {
        self.particles.iter().flat_map(|patch| {
            patch.iter().enumerate().flat_map(|(m, p)| p.blocks.iter().map(move |block| (m, block)))
        })
    }

    /// Block and patch of a particle at `x` that comes from elsewhere.
    ///
    /// # Errors
    /// A position outside the level.
    pub fn home(&self, material: usize, x: [f64; 3]) -> Result<(BlockIndex, usize), OutsideLevel> {
        let index = Level::block_of(self.level.base_node(x, self.materials[material].half_size));
        let patch = self.decomposition.owner(index).filter(|_| self.level.contains(x)).ok_or(OutsideLevel)?;
        Ok((index, patch))
    }

    /// Whether the block of a particle at `x` that comes from elsewhere holds others already, on this rank.
    pub fn is_occupied(&self, material: usize, x: [f64; 3]) -> bool {
        self.home(material, x).is_ok_and(|(index, patch)| {
            let slot = self.decomposition.patches[patch].blocks.offset(index);
            slot.is_some_and(|slot| self.particles[patch][material].lookup[slot] > 0)
        })
    }

    /// Adds a particle to the block that owns position `x`, on this rank. New blocks wait for [`Warehouse::activate`].
    ///
    /// # Errors
    /// A position outside the level.
    pub fn insert(&mut self, material: usize, x: [f64; 3], record: &[f64]) -> Result<(), OutsideLevel> {
        let [patch, material, at] = self.make_room(material, x)?;
        let data = &self.materials[material];
        let block = &mut self.particles[patch][material].blocks[at];
        let (rest, base) = (self.level.middle(block.index), self.level.base(x, data.half_size));
        block.push(&data.layout, rest, base, record);
        Ok(())
    }

    /// Patch, material and position there of the block for a particle at `x`, on this rank; a new one waits for
    /// [`Warehouse::activate`].
    ///
    /// # Errors
    /// A position outside the level.
    pub fn make_room(&mut self, material: usize, x: [f64; 3]) -> Result<[usize; 3], OutsideLevel> {
        let (index, patch) = self.home(material, x)?;
        let blocks = self.decomposition.patches[patch].blocks;
        let home = &mut self.particles[patch][material];
        let slot = &mut home.lookup[blocks.offset(index).ok_or(OutsideLevel)?];
        if *slot == 0 {
            home.blocks.push(ParticleBlock::new(index, &self.node_layout));
            *slot = home.blocks.len() as u32;
            self.reactivate = true;
        }
        Ok([patch, material, *slot as usize - 1])
    }

    /// Puts a block with its particles into its patch, on this rank: for a restart.
    ///
    /// # Errors
    /// A block outside the level.
    pub fn adopt(&mut self, material: usize, block: ParticleBlock) -> Result<(), OutsideLevel> {
        let patch = self.decomposition.owner(block.index).ok_or(OutsideLevel)?;
        let at = self.decomposition.patches[patch].blocks.offset(block.index).ok_or(OutsideLevel)?;
        let home = &mut self.particles[patch][material];
        home.blocks.push(block);
        home.lookup[at] = home.blocks.len() as u32;
        self.reactivate = true;
        Ok(())
    }

    /// Number of particle blocks in each layer along x, from the level's first layer on, as of the last activation.
    pub fn blocks_by_layer(&self) -> Vec<usize> {
        let all = self.level.blocks();
        let mut counts = vec![0; all.size()[0]];
        for (patch, homes) in self.decomposition.patches.iter().zip(&self.particles) {
            let first = (patch.blocks.lower[0] - all.lower[0]) as usize;
            for layers in homes.iter().map(|home| &home.layers) {
                let in_each = layers.windows(2).map(|ends| (ends[1] - ends[0]) as usize);
                counts[first..].iter_mut().zip(in_each).for_each(|(count, more)| *count += more);
            }
        }
        counts
    }

    /// What work on a patch took since this was asked last, while it was weighed [ns].
    pub fn take_cost(&mut self, patch: usize) -> u64 {
        let blocks = self.particles[patch].iter_mut().flat_map(|home| &mut home.blocks);
        let particles: u64 = blocks.map(|block| std::mem::take(&mut block.cost)).sum();
        let nodes = self.nodes[patch].blocks.iter_mut();
        particles + nodes.map(|block| std::mem::take(&mut block.cost)).sum::<u64>()
    }

    /// Number of nodes in active blocks.
    pub fn node_count(&self) -> usize {
        self.node_layout.nodes * self.nodes.iter().map(|patch| patch.blocks.len()).sum::<usize>()
    }

    /// Bytes of particle and of node data.
    pub fn bytes(&self) -> (usize, usize) {
        let particles = self.blocks().map(|(_, block)| block.bytes()).sum();
        let nodes = self.nodes.iter().flat_map(|p| &p.blocks).map(NodeBlock::bytes).sum();
        (particles, nodes)
    }
}

/// A position outside the level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a position is outside the level")]
pub struct OutsideLevel;

fn fill_layers(layers: &mut Vec<u32>, blocks: IndexBox, indices: impl Iterator<Item = BlockIndex>) {
    layers.clear();
    layers.resize(blocks.size()[0] + 1, 0);
    for index in indices {
        layers[(index[0] - blocks.lower[0]) as usize + 1] += 1;
    }
    for layer in 1..layers.len() {
        layers[layer] += layers[layer - 1];
    }
}

/// Positions of the blocks in the layers `wanted` along x of a patch that begins at layer `first`.
fn positions(layers: &[u32], first: i32, wanted: &Range<i32>) -> Range<usize> {
    let at = |layer: i32| layers[((layer - first).max(0) as usize).min(layers.len() - 1)] as usize;
    at(wanted.start)..at(wanted.end)
}
