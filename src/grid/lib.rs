//! The background grid: cells, blocks of 4x4x4 cells, and patches, which are boxes of whole blocks.
mod block;
mod lattice;
mod level;
mod partition;
mod patch;

pub use block::{BASES, BELOW, BLOCK, BlockShape, NODES, NODES_PER_AXIS, Origin, REACH, STRIDE, SharedNodes};
pub use lattice::Lattice;
pub use level::Level;
pub use partition::Partition;
pub use patch::{Decomposition, Patch};

/// Position of a point on the curve along which ranks share patches (Hilbert).
pub fn curve(point: [u32; 3]) -> u64 {
    partition::hilbert(point)
}

/// Index of a block on each axis. Block b owns the nodes 4b to 4b+3.
pub type BlockIndex = [i32; 3];

/// A half-open box of indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IndexBox {
    /// First index on each axis.
    pub lower: [i32; 3],
    /// One past the last index on each axis.
    pub upper: [i32; 3],
}

impl IndexBox {
    /// The box of one index.
    pub fn of(index: [i32; 3]) -> Self {
        Self { lower: index, upper: index.map(|i| i + 1) }
    }

    /// Indices on each axis.
    pub fn size(&self) -> [usize; 3] {
        std::array::from_fn(|a| (self.upper[a] - self.lower[a]).max(0) as usize)
    }

    /// Number of indices.
    pub fn len(&self) -> usize {
        self.size().iter().product()
    }

    /// Whether there is no index.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether `index` lies inside.
    pub fn contains(&self, index: [i32; 3]) -> bool {
        (0..3).all(|a| self.lower[a] <= index[a] && index[a] < self.upper[a])
    }

    /// Position of `index` in x-major order, if it lies inside.
    pub fn offset(&self, index: [i32; 3]) -> Option<usize> {
        let size = self.size();
        self.contains(index)
            .then(|| (0..3).fold(0, |at, a| at * size[a] + (index[a] - self.lower[a]) as usize))
    }

    /// The box with `layers` more indices on every side.
    pub fn grown(&self, layers: i32) -> Self {
        Self { lower: self.lower.map(|i| i - layers), upper: self.upper.map(|i| i + layers) }
    }

    /// The indices that both boxes have.
    pub fn common(&self, other: &Self) -> Self {
        let lower: [i32; 3] = std::array::from_fn(|a| self.lower[a].max(other.lower[a]));
        let upper = std::array::from_fn(|a| self.upper[a].min(other.upper[a]).max(lower[a]));
        Self { lower, upper }
    }

    /// The smallest box around both.
    pub fn around(&self, other: &Self) -> Self {
        let lower = std::array::from_fn(|a| self.lower[a].min(other.lower[a]));
        Self { lower, upper: std::array::from_fn(|a| self.upper[a].max(other.upper[a])) }
    }

    /// All indices in x-major order.
    pub fn iter(self) -> impl Iterator<Item = [i32; 3]> {
        let Self { lower: [x0, y0, z0], upper: [x1, y1, z1] } = self;
        (x0..x1).flat_map(move |x| (y0..y1).flat_map(move |y| (z0..z1).map(move |z| [x, y, z])))
    }
}

/// The 27 offsets around a block, itself included: the order in which sums over blocks are taken.
pub fn around() -> impl Iterator<Item = [i32; 3]> {
    (0..27).map(offset)
}

/// The `q`-th of the offsets [`around`] a block.
#[inline]
pub const fn offset(q: usize) -> [i32; 3] {
    OFFSETS[q]
}

const OFFSETS: [[i32; 3]; 27] = {
    let (mut offsets, mut q) = ([[0; 3]; 27], 0);
    while q < 27 {
        offsets[q] = [q as i32 / 9 - 1, q as i32 / 3 % 3 - 1, q as i32 % 3 - 1];
        q += 1;
    }
    offsets
};
