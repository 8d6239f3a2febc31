//! All data of a run, by patch and material, and which blocks are active.
//!
//! Particle labels of the old and the new step share storage: the graph's write-after-read edges are what makes
//! that safe. Labels of nodes exist only in blocks that a field touches.
use super::brief::Brief;
use super::fields::Fields;
use super::layers::Layers;
use super::layout::{NodeLayout, ParticleLayout};
use super::map::ByIndex;
use super::nearby::Nearby;
use super::nodes::NodeBlock;
use super::particles::ParticleBlock;
use super::shared::Shared;
use crate::schema::{LabelId, Schema, Tiles};
use grid::{BlockIndex, BlockShape, Decomposition, Level, Partition};
use simd::LANES;
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
    /// What others know of each, as it was when work on it ended last.
    pub briefs: Vec<Brief>,
    /// The position of each in `blocks`.
    lookup: ByIndex<u32>,
    layers: Layers,
}

/// Node blocks of one patch, in x-major order.
#[derive(Clone, Debug, Default)]
pub struct NodePatch {
    /// The blocks.
    pub blocks: Vec<NodeBlock>,
    layers: Layers,
}

impl ParticlePatch {
    /// Drops empty blocks.
    pub(super) fn vacate(&mut self) {
        self.blocks.retain(|block| block.count > 0);
        self.note();
    }

    /// Sorts blocks.
    pub(super) fn settle(&mut self, shape: &BlockShape) {
        self.blocks.sort_by_key(|block| block.index);
        self.note();
        self.note_briefs(shape);
        self.layers.fill(self.blocks.iter().map(|block| block.index[0]));
    }

    /// Notes where blocks are.
    fn note(&mut self) {
        self.lookup.clear();
        self.lookup.extend(self.blocks.iter().map(|block| block.index).zip(0..));
    }

    /// Notes what others know of blocks.
    pub(super) fn note_briefs(&mut self, shape: &BlockShape) {
        self.briefs.clear();
        self.briefs.extend(self.blocks.iter().map(|block| Brief::of(block, shape)));
    }

    /// Makes room in a block for so many more particles of a material.
    pub fn reserve(
        &mut self,
        (level, data, nodes): (&Level, &MaterialData, &NodeLayout),
        index: BlockIndex,
        particles: usize,
    ) {
        let (position, _) = self.position(index, nodes);
        let block = &mut self.blocks[position];
        let tiles = (block.count + particles).div_ceil(LANES);
        block.reserve(&data.layout, level.middle(index), tiles);
    }

    /// Adds a particle of a material at `x` to the block where it belongs; whether that is a new one.
    pub fn push(
        &mut self,
        (level, data, nodes): (&Level, &MaterialData, &NodeLayout),
        index: BlockIndex,
        x: [f64; 3],
        record: &[f64],
    ) -> bool {
        let (position, new) = self.position(index, nodes);
        let base = level.base(x, data.half_size);
        self.blocks[position].push(&data.layout, level.middle(index), base, record);
        new
    }

    /// Where a block is, which is made if it is not there; whether it is new.
    pub(super) fn position(&mut self, index: BlockIndex, nodes: &NodeLayout) -> (usize, bool) {
        let Self { blocks, lookup, .. } = self;
        let before = blocks.len();
        let position = *lookup.entry(index).or_insert_with(|| {
            blocks.push(ParticleBlock::new(index, nodes));
            before as u32
        });
        (position as usize, blocks.len() > before)
    }

    /// The blocks in some layers along x, and what others know of them.
    pub fn slab_mut(
        &mut self,
        wanted: &Range<i32>,
    ) -> impl Iterator<Item = (&mut ParticleBlock, &mut Brief)> {
        let positions = self.layers.positions(wanted);
        self.blocks[positions.clone()].iter_mut().zip(&mut self.briefs[positions])
    }
}

impl NodePatch {
    /// Notes where layers begin.
    pub(super) fn settle(&mut self) {
        self.layers.fill(self.blocks.iter().map(|block| block.index[0]));
    }

    /// Positions of the blocks in some layers along x.
    pub fn slab(&self, wanted: &Range<i32>) -> Range<usize> {
        self.layers.positions(wanted)
    }

    /// The blocks in some layers along x.
    pub fn slab_mut(&mut self, wanted: &Range<i32>) -> &mut [NodeBlock] {
        let positions = self.slab(wanted);
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
        let particles = vec![empty; patches];
        let nodes = vec![NodePatch::default(); patches];
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
            for home in homes {
                home.blocks.retain(|_| mine);
                home.lookup.clear();
            }
            if !(mine && old.is_mine(patch)) {
                self.nodes[patch] = NodePatch::default();
            }
        }
        self.reactivate = true;
    }

    /// Whether nodes keep something while no particle touches them: which blocks of nodes there are must then follow from where particles
    /// are now, not from when that was asked.
    pub fn nodes_keep(&self) -> bool {
        self.own_rates || self.node_layout.carried().next().is_some()
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
        self.home(material, x)
            .is_ok_and(|(index, patch)| self.particles[patch][material].lookup.contains_key(&index))
    }

    /// Adds a particle to the block that owns position `x`, on this rank. New blocks wait for [`Warehouse::activate`].
    ///
    /// # Errors
    /// A position outside the level.
    pub fn insert(&mut self, material: usize, x: [f64; 3], record: &[f64]) -> Result<(), OutsideLevel> {
        let (index, patch) = self.home(material, x)?;
        let of = (&self.level, &self.materials[material], &self.node_layout);
        self.reactivate |= self.particles[patch][material].push(of, index, x, record);
        Ok(())
    }

    /// Patch, material and position there of the block for a particle at `x`, on this rank; a new one waits for
    /// [`Warehouse::activate`].
    ///
    /// # Errors
    /// A position outside the level.
    pub fn make_room(&mut self, material: usize, x: [f64; 3]) -> Result<[usize; 3], OutsideLevel> {
        let (index, patch) = self.home(material, x)?;
        let (position, new) = self.particles[patch][material].position(index, &self.node_layout);
        self.reactivate |= new;
        Ok([patch, material, position])
    }

    /// Puts a block with its particles into its patch, on this rank: for a restart.
    ///
    /// # Errors
    /// A block outside the level.
    pub fn adopt(&mut self, material: usize, block: ParticleBlock) -> Result<(), OutsideLevel> {
        let patch = self.decomposition.owner(block.index).ok_or(OutsideLevel)?;
        let home = &mut self.particles[patch][material];
        home.lookup.insert(block.index, home.blocks.len() as u32);
        home.blocks.push(block);
        self.reactivate = true;
        Ok(())
    }

    /// Number of particle blocks in each layer along x of which this rank has some.
    pub fn blocks_by_layer(&self) -> BTreeMap<i32, usize> {
        let mut counts = BTreeMap::new();
        for home in self.partition.mine().flat_map(|patch| &self.particles[patch]) {
            home.blocks.iter().for_each(|block| *counts.entry(block.index[0]).or_default() += 1);
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
