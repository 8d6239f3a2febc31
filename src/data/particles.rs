//! Particles of one material in one block: columns of tiles in one allocation.
use super::extent::{self, Extent};
use super::label::Home;
use super::labels::{LABELS, LabelId};
use crate::grid::{BlockIndex, IndexBox};
use crate::simd::{LANES, Wide};

/// Which particle labels a material has, and how many lines a tile each takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Lines a tile of each label; 0: the material does not have it.
    pub widths: [usize; LABELS],
    /// Lines a tile of all labels before each label.
    pub starts: [usize; LABELS],
    /// Lines a tile of all labels.
    pub total: usize,
    /// History of a particle that is not there (see [`ParticleBlock`]).
    pub inert: Vec<f64>,
}

impl Layout {
    /// The layout of a material that needs `labels`, with the `history` of an undeformed particle.
    pub fn new(labels: impl IntoIterator<Item = LabelId>, history: Vec<f64>) -> Self {
        let mut widths = [0; LABELS];
        for label in labels {
            debug_assert_eq!(label.home(), Home::Particle);
            widths[label as usize] = if label == LabelId::History { history.len() } else { label.width() };
        }
        let mut starts = [0; LABELS];
        let mut total = 0;
        for (start, width) in starts.iter_mut().zip(widths) {
            *start = total;
            total += width;
        }
        Self { widths, starts, total, inert: history }
    }

    /// The labels in the layout.
    pub fn labels(&self) -> impl Iterator<Item = LabelId> {
        LabelId::ALL.iter().copied().filter(|&l| self.widths[l as usize] > 0)
    }
}

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
    /// Partial node sums of this block: 8x8x8 lines from node 4b − 1 on, one buffer a scattered label.
    pub partials: [Vec<Wide>; 2],
    /// Bounds of the particles' base nodes.
    pub extent: Extent,
    /// The nodes of the buffers that hold something, since the last scatter.
    pub touched: IndexBox,
    /// Whether particles may have to move to other blocks.
    pub leaving: bool,
    /// Whether particles of a contacting material may touch the same nodes.
    pub near: bool,
    /// Whether its particles share node blocks with another rank's, or with nodes that do.
    pub rim: bool,
    /// What work on it took, while that is weighed [ns].
    pub cost: u64,
    /// Node blocks around, in the order of `grid::around`: (patch, position), see `warehouse`.
    pub around: [(u32, u32); 27],
}

impl ParticleBlock {
    /// An empty block.
    pub fn new(index: BlockIndex) -> Self {
        Self {
            index,
            count: 0,
            capacity: 0,
            columns: Vec::new(),
            partials: [Vec::new(), Vec::new()],
            extent: extent::NOBODY,
            touched: IndexBox { lower: [0; 3], upper: [0; 3] },
            leaving: true,
            near: false,
            rim: false,
            cost: 0,
            around: [(u32::MAX, u32::MAX); 27],
        }
    }

    /// Tiles in use.
    pub fn tiles(&self) -> usize {
        self.count.div_ceil(LANES)
    }

    /// Bytes allocated.
    pub fn bytes(&self) -> usize {
        let lines = self.columns.capacity() + self.partials.iter().map(Vec::capacity).sum::<usize>();
        lines * size_of::<Wide>()
    }

    /// One column.
    pub fn column(&self, layout: &Layout, label: LabelId) -> &[Wide] {
        let (start, width) = (layout.starts[label as usize], layout.widths[label as usize]);
        &self.columns[start * self.capacity..(start + width) * self.capacity]
    }

    /// All columns, a label each, and beside them the partial sums and the extent.
    pub fn split<'a>(&'a mut self, layout: &Layout) -> Split<'a> {
        let mut rest = &mut self.columns[..];
        let columns = layout.widths.map(|width| {
            let (column, after) = std::mem::take(&mut rest).split_at_mut(width * self.capacity);
            rest = after;
            column
        });
        Split { columns, partials: &mut self.partials, extent: &mut self.extent }
    }

    /// One number of one particle.
    pub fn get(&self, layout: &Layout, label: LabelId, particle: usize, component: usize) -> f64 {
        let (tile, lane) = (particle / LANES, particle % LANES);
        self.column(layout, label)[tile * layout.widths[label as usize] + component].0[lane]
    }

    /// Writes one number of one particle.
    pub fn set(&mut self, layout: &Layout, label: LabelId, particle: usize, component: usize, value: f64) {
        if label == LabelId::Position {
            self.extent = extent::ANYWHERE;
            self.leaving = true;
        }
        self.put(layout, label, particle, component, value);
    }

    fn put(&mut self, layout: &Layout, label: LabelId, particle: usize, component: usize, value: f64) {
        let width = layout.widths[label as usize];
        let line = layout.starts[label as usize] * self.capacity + particle / LANES * width + component;
        self.columns[line].0[particle % LANES] = value;
    }

    /// Adds a particle whose numbers are `record`, label after label in the layout's order; `base` is its base node
    /// before rounding down.
    pub fn push(&mut self, layout: &Layout, rest: [f64; 3], base: [f64; 3], record: &[f64]) {
        extent::include(&mut self.extent, base);
        self.leaving = true;
        if self.count == self.capacity * LANES {
            self.grow(layout, rest);
        }
        let particle = self.count;
        self.count += 1;
        self.write(layout, particle, record);
    }

    /// Copies a particle's numbers to the end of `record`.
    pub fn read(&self, layout: &Layout, particle: usize, record: &mut Vec<f64>) {
        for label in layout.labels() {
            for component in 0..layout.widths[label as usize] {
                record.push(self.get(layout, label, particle, component));
            }
        }
    }

    fn write(&mut self, layout: &Layout, particle: usize, record: &[f64]) {
        let mut numbers = record.iter();
        for label in layout.labels() {
            for (component, &value) in (0..layout.widths[label as usize]).zip(&mut numbers) {
                self.put(layout, label, particle, component, value);
            }
        }
    }

    /// Appends everything that makes the block, to be read by [`ParticleBlock::from_lines`].
    pub fn to_lines(&self, layout: &Layout, lines: &mut Vec<Wide>) {
        let [x, y, z] = self.index.map(|i| i as u32 as u64);
        lines.push(bytemuck::cast([x, y, z, self.count as u64, 0, 0, 0, 0]));
        lines.extend_from_slice(&self.extent);
        for label in layout.labels() {
            let used = self.tiles() * layout.widths[label as usize];
            lines.extend_from_slice(&self.column(layout, label)[..used]);
        }
    }

    /// A block from the beginning of `lines`, which go on after it; `None` if they are too few.
    pub fn from_lines(
        layout: &Layout,
        rest: impl Fn(BlockIndex) -> [f64; 3],
        lines: &mut &[Wide],
    ) -> Option<Self> {
        let (head, after) = lines.split_at_checked(1 + EXTENT)?;
        let [x, y, z, count, ..]: [u64; 8] = bytemuck::cast(head[0]);
        let mut block = Self::new([x, y, z].map(|i| i as u32 as i32));
        block.count = count as usize;
        block.extent.copy_from_slice(&head[1..]);
        let tiles = block.tiles();
        block.reserve(layout, rest(block.index), tiles);
        let (columns, after) = after.split_at_checked(tiles * layout.total)?;
        block.columns.copy_from_slice(columns);
        *lines = after;
        Some(block)
    }

    /// Removes the particles at `leaving` (ascending); the others keep their order.
    pub fn remove(&mut self, layout: &Layout, rest: [f64; 3], leaving: &[usize]) {
        let Some(&first) = leaving.first() else { return };
        let mut gone = leaving.iter().peekable();
        let mut to = first;
        let mut record = Vec::new();
        for from in first..self.count {
            if gone.next_if_eq(&&from).is_some() {
                continue;
            }
            record.clear();
            self.read(layout, from, &mut record);
            self.write(layout, to, &record);
            to += 1;
        }
        let end = self.tiles() * LANES;
        self.count = to;
        (to..end).for_each(|lane| self.make_inert(layout, rest, lane));
    }

    /// Makes room for at least one more tile; grows by an eighth so that arrivals rarely copy.
    fn grow(&mut self, layout: &Layout, rest: [f64; 3]) {
        let old = self.capacity;
        self.reserve(layout, rest, old + old / 8 + 1);
    }

    /// Makes room for `tiles` tiles.
    pub fn reserve(&mut self, layout: &Layout, rest: [f64; 3], tiles: usize) {
        let old = self.capacity;
        self.capacity = tiles.max(old);
        let before = std::mem::take(&mut self.columns);
        self.columns = vec![Wide::default(); layout.total * self.capacity];
        for (start, width) in layout.starts.iter().zip(layout.widths) {
            let column = &before[start * old..(start + width) * old];
            self.columns[start * self.capacity..][..column.len()].copy_from_slice(column);
        }
        (old * LANES..self.capacity * LANES).for_each(|lane| self.make_inert(layout, rest, lane));
    }

    fn make_inert(&mut self, layout: &Layout, rest: [f64; 3], particle: usize) {
        for label in layout.labels() {
            for component in 0..layout.widths[label as usize] {
                let value = match label {
                    LabelId::Position => rest[component],
                    LabelId::Deformation if component % 4 == 0 => 1.0,
                    LabelId::History => layout.inert[component],
                    LabelId::Identity => f64::from_bits(u64::MAX),
                    _ => 0.0,
                };
                self.put(layout, label, particle, component, value);
            }
        }
    }
}

/// A block's data, taken apart for a workspace.
pub struct Split<'a> {
    /// A column a label; empty where the material lacks the label.
    pub columns: [&'a mut [Wide]; LABELS],
    /// See [`ParticleBlock::partials`].
    pub partials: &'a mut [Vec<Wide>; 2],
    /// See [`ParticleBlock::extent`].
    pub extent: &'a mut Extent,
}
