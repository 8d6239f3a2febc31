use super::{BLOCK, BlockIndex, BlockShape, IndexBox, Origin};

/// A box of cubic cells, and how particles are assigned to its blocks. An axis without cells is collapsed: it has one
/// node, and particles lie on it.
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
        let lower = self.cells.map(|n| if n == 0 { 0 } else { -1 });
        IndexBox {
            lower,
            upper: self.cells.map(|n| if n == 0 { 1 } else { (n as i32 + 2).div_euclid(BLOCK) + 1 }),
        }
    }

    /// How the nodes of its blocks follow one another.
    pub fn shape(&self) -> &'static BlockShape {
        BlockShape::of(self.cells)
    }

    /// Where the stencils of the particles of a block are counted from.
    pub fn origin(&self, block: BlockIndex) -> Origin {
        let shape = self.shape();
        Origin {
            node: shape.first_of_buffer(block).map(f64::from),
            lower: self.lower.map(|x| x / self.cell),
            strides: shape.buffer_strides.map(f64::from),
            shape,
        }
    }

    /// Blocks along each axis that hold cells of the level: what patches divide.
    pub fn block_columns(&self) -> [usize; 3] {
        self.cells.map(|n| n.div_ceil(BLOCK as usize).max(1))
    }

    /// The stencil's lowest node along each axis, before rounding down, for a particle at `x` [m] of half-size
    /// `half` [cells].
    pub fn base(&self, x: [f64; 3], half: [f64; 3]) -> [f64; 3] {
        let on = |a: usize| (x[a] - self.lower[a]) / self.cell - half[a];
        std::array::from_fn(|a| if self.cells[a] == 0 { 0.0 } else { on(a) })
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
        let on = |a: usize| self.lower[a] + self.cell * (f64::from(BLOCK * block[a]) + half);
        std::array::from_fn(|a| if self.cells[a] == 0 { self.lower[a] } else { on(a) })
    }

    /// Whether the point lies in the level.
    pub fn contains(&self, x: [f64; 3]) -> bool {
        let upper = self.upper();
        (0..3).all(|a| self.cells[a] == 0 || self.lower[a] <= x[a] && x[a] <= upper[a])
    }

    /// A regular lattice of `n` points along each axis of each cell [m], one on a collapsed axis; z fastest.
    pub fn lattice(self, n: usize) -> impl Iterator<Item = [f64; 3]> {
        let [nx, ny, nz] = self.cells.map(|cells| (cells * n).max(1));
        (0..nx * ny * nz).map(move |i| {
            let place = [i / (ny * nz), i / nz % ny, i % nz];
            let along = |a: usize| if self.cells[a] == 0 { 0.0 } else { (place[a] as f64 + 0.5) / n as f64 };
            [0, 1, 2].map(|a| self.lower[a] + self.cell * along(a))
        })
    }
}
