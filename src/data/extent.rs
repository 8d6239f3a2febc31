//! Where the particles of a block are, as far as the block needs to know (label `BlockExtent`): the largest y and the
//! largest −y on each axis, where y is the base node of a particle before rounding down.
use crate::grid::{BLOCK, BlockIndex, IndexBox};
use crate::physics::shape::{BASES, BELOW, NODES_PER_AXIS};
use crate::simd::{LANES, Wide};

/// An extent: three lines of y, three of −y; the largest lane counts.
pub type Extent = [Wide; 6];

/// The extent of no particle.
pub const NOBODY: Extent = [Wide([f64::NEG_INFINITY; LANES]); 6];
/// The extent of particles that nobody has looked at.
pub const ANYWHERE: Extent = [Wide([f64::INFINITY; LANES]); 6];
/// Stencils round y a little differently than other code does [cells].
pub const MARGIN: f64 = 1e-6;

/// (smallest, largest) y on an axis.
pub fn bounds(extent: &Extent, axis: usize) -> (f64, f64) {
    let largest = |line: &Wide| line.0.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (-largest(&extent[axis + 3]), largest(&extent[axis]))
}

/// The largest y on each axis, then the largest −y: what counts of an extent.
pub fn largest(extent: &Extent) -> [f64; 6] {
    extent.map(|line| line.0.into_iter().fold(f64::NEG_INFINITY, f64::max))
}

/// An extent from what counts of it.
pub fn from_largest(largest: [f64; 6]) -> Extent {
    largest.map(|y| Wide([y; LANES]))
}

/// Widens an extent by a particle at `y`.
pub fn include(extent: &mut Extent, y: [f64; 3]) {
    for axis in 0..3 {
        let (up, down) = (y[axis] + MARGIN, MARGIN - y[axis]);
        extent[axis].0[0] = extent[axis].0[0].max(up);
        extent[axis + 3].0[0] = extent[axis + 3].0[0].max(down);
    }
}

/// The nodes of the block's buffer that particles within the extent can touch.
pub fn touched(extent: &Extent, block: BlockIndex) -> IndexBox {
    let (mut lower, mut upper) = ([0; 3], [0; 3]);
    for axis in 0..3 {
        let first = f64::from(BLOCK * block[axis] - BELOW);
        let (least, most) = bounds(extent, axis);
        // a cast saturates, so that an extent that knows nothing gives the whole buffer
        let base = |y: f64| ((y - first).floor() as i32).clamp(0, BASES - 1);
        (lower[axis], upper[axis]) = (base(least), base(most) + NODES_PER_AXIS);
    }
    IndexBox { lower, upper }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_touched_nodes_are_those_of_all_bases_between_the_bounds() {
        let mut extent = NOBODY;
        include(&mut extent, [9.5, 8.0, 11.9]);
        include(&mut extent, [8.2, 7.5, 11.99]);
        let nodes = touched(&extent, [2, 2, 2]);
        // the buffer begins at node 7; y = 8 lies within the margin of node 7
        assert_eq!(nodes, IndexBox { lower: [1, 0, 4], upper: [5, 4, 7] });
        let all = IndexBox { lower: [0; 3], upper: [8; 3] };
        assert_eq!(touched(&ANYWHERE, [2, 2, 2]), all);
        assert_eq!(bounds(&extent, 1).0, 7.5 - MARGIN);
    }
}
