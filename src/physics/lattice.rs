//! Where nodes are.

/// The nodes of a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Position of node (0,0,0) [m].
    pub lower: [f64; 3],
    /// Distance of nodes [m].
    pub cell: f64,
}

impl Lattice {
    /// Position [m] of the `n`-th of the 4x4x4 nodes from `first` on, z fastest.
    #[inline(always)]
    pub fn node(&self, first: [i32; 3], n: usize) -> [f64; 3] {
        std::array::from_fn(|a| {
            self.lower[a] + self.cell * f64::from(first[a] + (n >> (4 - 2 * a) & 3) as i32)
        })
    }
}
