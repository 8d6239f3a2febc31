//! Particles of one material in one block: columns of tiles in one allocation.
mod moving;

use super::extent::{self, Extent};
use super::layout::{NodeLayout, ParticleLayout};
use super::nodes::{NOWHERE, Place};
use crate::schema::LabelId;
use grid::{BlockIndex, IndexBox};
use simd::{LANES, Wide, prefetch_at};
use smallvec::SmallVec;

/// Lines of an extent.
const EXTENT: usize = size_of::<Extent>() / size_of::<Wide>();

/// The particles of one material that belong to one block, in a fixed order that no decomposition changes.
///
/// Lanes beyond `count` are inert: no mass, no volume, F = 1, at rest in the middle of the block.
#[derive(Clone, Debug)]
pub struct ParticleBlock {
    /// Which block.
    pub index: BlockIndex,
    /// Number of particles.
    pub count: usize,
    /// Tiles that `columns` has room for.
    capacity: usize,
    /// All columns, label after label.
    columns: Vec<Wide>,
    /// What the particles add to nodes: a buffer a label (see [`NodeLayout::partial`]), for the fields of the material one
    /// after the other, from the first node of the buffer on; empty where there is nothing.
    pub partials: SmallVec<[Vec<Wide>; FEW]>,
    /// Bounds of the particles' base nodes.
    pub extent: Extent,
    /// The nodes of the buffers that hold something, since particles were added to nodes last.
    pub touched: IndexBox,
    /// Whether particles may have to move to other blocks.
    pub leaving: bool,
    /// Whether particles of a field with which theirs interacts may touch the same nodes.
    pub meets: bool,
    /// Whether that is so, or they are near something else (see `Warehouse::nearby`).
    pub near: bool,
    /// Whether its particles share node blocks with another rank's, or with nodes that do.
    pub rim: bool,
    /// What work on it took, while that is weighed [ns].
    pub cost: u64,
    /// Node blocks around, in the order of `grid::around`.
    pub around: [Place; 27],
}

/// Labels that particles add to nodes: few, so that they need no memory of their own.
const FEW: usize = 2;

impl ParticleBlock {
    /// An empty block.
    pub fn new(index: BlockIndex, nodes: &NodeLayout) -> Self {
        Self {
            index,
            count: 0,
            capacity: 0,
            columns: Vec::new(),
            partials: nodes.partial().iter().map(|_| Vec::new()).collect(),
            extent: extent::NOBODY,
            touched: IndexBox { lower: [0; 3], upper: [0; 3] },
            leaving: true,
            meets: false,
            near: false,
            rim: false,
            cost: 0,
            around: [NOWHERE; 27],
        }
    }

    /// Tiles in use.
    pub fn tiles(&self) -> usize {
        self.count.div_ceil(LANES)
    }

    /// Asks for what says where that is which its particles add to nodes.
    #[inline(always)]
    pub fn announce(&self) {
        prefetch_at(&raw const self.partials);
    }

    /// Where its columns are, and how many lines they have.
    pub fn address(&self) -> (*const Wide, usize) {
        (self.columns.as_ptr(), self.columns.len())
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> usize {
        let lines = self.columns.capacity() + self.partials.iter().map(Vec::capacity).sum::<usize>();
        lines * size_of::<Wide>()
    }

    /// One column.
    pub fn column(&self, layout: &ParticleLayout, label: LabelId) -> &[Wide] {
        let (start, width) = (layout.starts[label.index()], layout.width(label));
        &self.columns[start * self.capacity..(start + width) * self.capacity]
    }

    /// All columns with their labels, and beside them the partial sums and the extent.
    pub fn split<'a>(
        &'a mut self,
        layout: &'a ParticleLayout,
    ) -> Split<'a, impl Iterator<Item = (LabelId, &'a mut [Wide])>> {
        let (mut rest, capacity) = (&mut self.columns[..], self.capacity);
        let columns = layout.labels().map(move |label| {
            let (column, after) = std::mem::take(&mut rest).split_at_mut(layout.width(label) * capacity);
            rest = after;
            (label, column)
        });
        Split { columns, partials: &mut self.partials, extent: &mut self.extent }
    }

    /// One number of one particle.
    pub fn get(&self, layout: &ParticleLayout, label: LabelId, particle: usize, component: usize) -> f64 {
        let (tile, lane) = (particle / LANES, particle % LANES);
        self.column(layout, label)[tile * layout.width(label) + component].0[lane]
    }

    /// Writes one number of one particle. If it moves, nobody knows any more where the particles of the block are.
    pub fn set(
        &mut self,
        layout: &ParticleLayout,
        label: LabelId,
        particle: usize,
        component: usize,
        value: f64,
    ) {
        if label == layout.position {
            self.extent = extent::ANYWHERE;
            self.leaving = true;
        }
        self.put(layout, label, particle, component, value);
    }

    fn put(
        &mut self,
        layout: &ParticleLayout,
        label: LabelId,
        particle: usize,
        component: usize,
        value: f64,
    ) {
        let width = layout.width(label);
        let line = layout.starts[label.index()] * self.capacity + particle / LANES * width + component;
        self.columns[line].0[particle % LANES] = value;
    }

    /// Appends everything that makes the block, to be read by [`ParticleBlock::from_lines`].
    pub fn to_lines(&self, layout: &ParticleLayout, lines: &mut Vec<Wide>) {
        let [x, y, z] = self.index.map(|i| i as u32 as u64);
        lines.push(bytemuck::cast([x, y, z, self.count as u64, 0, 0, 0, 0]));
        lines.extend_from_slice(&self.extent);
        for label in layout.labels() {
            let used = self.tiles() * layout.width(label);
            lines.extend_from_slice(&self.column(layout, label)[..used]);
        }
    }

    /// A block from the beginning of `lines`, which go on after it; `None` if they are too few.
    pub fn from_lines(
        layout: &ParticleLayout,
        nodes: &NodeLayout,
        rest: impl Fn(BlockIndex) -> [f64; 3],
        lines: &mut &[Wide],
    ) -> Option<Self> {
        let (head, after) = lines.split_at_checked(1 + EXTENT)?;
        let [x, y, z, count, ..]: [u64; 8] = bytemuck::cast(head[0]);
        let mut block = Self::new([x, y, z].map(|i| i as u32 as i32), nodes);
        block.count = count as usize;
        block.extent.copy_from_slice(&head[1..]);
        let tiles = block.tiles();
        block.reserve(layout, rest(block.index), tiles);
        let (columns, after) = after.split_at_checked(tiles * layout.total)?;
        block.columns.copy_from_slice(columns);
        *lines = after;
        Some(block)
    }

    /// Makes room for `tiles` tiles.
    pub fn reserve(&mut self, layout: &ParticleLayout, rest: [f64; 3], tiles: usize) {
        let old = self.capacity;
        self.capacity = tiles.max(old);
        let before = std::mem::take(&mut self.columns);
        self.columns = vec![Wide::default(); layout.total * self.capacity];
        for (start, width) in layout.starts.iter().zip(&layout.widths) {
            let column = &before[start * old..(start + width) * old];
            self.columns[start * self.capacity..][..column.len()].copy_from_slice(column);
        }
        self.make_inert(layout, rest, old * LANES..self.capacity * LANES);
    }
}

/// A block's data, taken apart for a workspace.
pub struct Split<'a, C> {
    /// A column a label of the material.
    pub columns: C,
    /// See [`ParticleBlock::partials`].
    pub partials: &'a mut [Vec<Wide>],
    /// See [`ParticleBlock::extent`].
    pub extent: &'a mut Extent,
}
