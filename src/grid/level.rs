use super::{BlockIndex, IndexBox};

/// Cells along each axis of a block.
pub const BLOCK: i32 = 4;

/// A box of cubic cells, and how particles are assigned to its blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Lower corner [m].
    pub lower: [f64; 3],
    /// Edge of a cell [m].
    pub cell: f64,
    /// Cells along each axis.
    pub cells: [usize; 3],
}

impl Level {
    /// Upper corner [m].
    pub fn upper(&self) -> [f64; 3] {
        std::array::from_fn(|a| self.lower[a] + self.cell * self.cells[a] as f64)
    }

    /// All blocks that a particle inside the level can be assigned to or reach.
    ///
    /// A particle belongs to the block of the lowest node of its stencil, which may be one node below the
    /// level; the stencil ends at most one node above it.
    pub fn blocks(&self) -> IndexBox {
        IndexBox { lower: [-1; 3], upper: self.cells.map(|n| (n as i32 + 2).div_euclid(BLOCK) + 1) }
    }

    /// Blocks along each axis that hold cells of the level: what patches divide.
    pub fn block_columns(&self) -> [usize; 3] {
        self.cells.map(|n| n.div_ceil(BLOCK as usize))
    }

    /// The stencil's lowest node along each axis, before rounding down, for a particle at `x` [m] of half-size
    /// `half` [cells].
    pub fn base(&self, x: [f64; 3], half: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| (x[a] - self.lower[a]) / self.cell - half[a])
    }

    /// The stencil's lowest node along each axis.
    pub fn base_node(&self, x: [f64; 3], half: [f64; 3]) -> [i32; 3] {
        self.base(x, half).map(|y| y.floor() as i32)
    }

    /// The block that owns a node.
    pub fn block_of(node: [i32; 3]) -> BlockIndex {
        node.map(|n| n.div_euclid(BLOCK))
    }

    /// The middle of a block [m].
    pub fn middle(&self, block: BlockIndex) -> [f64; 3] {
        let half = 0.5 * f64::from(BLOCK);
        std::array::from_fn(|a| self.lower[a] + self.cell * (f64::from(BLOCK * block[a]) + half))
    }

    /// Whether the point lies in the level.
    pub fn contains(&self, x: [f64; 3]) -> bool {
        let upper = self.upper();
        (0..3).all(|a| self.lower[a] <= x[a] && x[a] <= upper[a])
    }
}
