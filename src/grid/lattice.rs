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
    /// Position of a node [m].
    #[inline(always)]
    pub fn position(&self, node: [i32; 3]) -> [f64; 3] {
        std::array::from_fn(|a| self.lower[a] + self.cell * f64::from(node[a]))
    }
}
