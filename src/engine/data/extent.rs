//! Where the particles of a block are, as far as the block needs to know: the largest y and the largest −y on each axis,
//! where y is the base node of a particle before rounding down.
use grid::{BlockIndex, BlockShape, IndexBox, Level, Origin};
use simd::{LANES, Simd, Wide};

/// An extent: three lines of y, three of −y; the largest lane counts.
pub type Extent = [Wide; 6];

/// The extent of no particle.
pub const NOBODY: Extent = [Wide([f64::NEG_INFINITY; LANES]); 6];
/// The extent of particles that nobody has looked at.
pub const ANYWHERE: Extent = [Wide([f64::INFINITY; LANES]); 6];
/// Stencils round y a little differently than other code does [cells].
pub const MARGIN: f64 = 1e-6;

/// Base nodes of particles before rounding down: how tasks that move particles widen the extent of their block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bases {
    /// 1/h [1/m]
    pub inverse_cell: f64,
    /// Half-size of a particle in cells along each axis.
    pub half_size: [f64; 3],
}

impl Bases {
    /// Widens an extent by eight particles at `x` [m] along an axis.
    #[inline(always)]
    pub fn include<S: Simd>(&self, extent: &mut [S; 6], origin: &Origin, axis: usize, x: S) {
        let shift = S::splat(origin.lower[axis] + self.half_size[axis]);
        let y = x.fms(S::splat(self.inverse_cell), shift);
        extent[axis] = extent[axis].max(y);
        extent[axis + 3] = extent[axis + 3].max(-y);
    }

    /// Widens a lane of an extent by one particle at `x` [m].
    pub fn include_one(&self, extent: &mut Extent, origin: &Origin, lane: usize, x: [f64; 3]) {
        for axis in 0..3 {
            let y = x[axis] * self.inverse_cell - (origin.lower[axis] + self.half_size[axis]);
            extent[axis].0[lane] = extent[axis].0[lane].max(y);
            extent[axis + 3].0[lane] = extent[axis + 3].0[lane].max(-y);
        }
    }
}

/// The largest lane; what is no number does not count.
#[inline]
fn most(line: &Wide) -> f64 {
    let [a, b, c, d, e, f, g, h] = line.0;
    // by halves: a chain of eight is waited for
    let most = (a.max(b).max(c.max(d))).max(e.max(f).max(g.max(h)));
    most.max(f64::NEG_INFINITY)
}

/// (smallest, largest) y on an axis.
pub fn bounds(extent: &Extent, axis: usize) -> (f64, f64) {
    (-most(&extent[axis + 3]), most(&extent[axis]))
}

/// The largest y on each axis, then the largest −y: what counts of an extent.
pub fn largest(extent: &Extent) -> [f64; 6] {
    extent.each_ref().map(most)
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
pub fn touched(extent: &Extent, shape: &BlockShape, block: BlockIndex) -> IndexBox {
    let mut nodes = IndexBox { lower: [0; 3], upper: [0; 3] };
    let first = shape.first_of_buffer(block);
    for axis in 0..3 {
        let (least, most) = bounds(extent, axis);
        // a cast saturates, so that an extent that knows nothing gives the whole buffer
        let base = |y: f64| ((y - f64::from(first[axis])).floor() as i32).clamp(0, shape.bases(axis) - 1);
        (nodes.lower[axis], nodes.upper[axis]) = (base(least), base(most) + shape.nodes_per_axis(axis));
    }
    nodes
}

/// Whether the coordinate y (base node before rounding down) is out of reach of the block on an axis; particles move a margin
/// early.
pub fn out_of_reach(level: &Level, block: BlockIndex, axis: usize, y: f64) -> bool {
    let shape = level.shape();
    let first = f64::from(shape.first_of_buffer(block)[axis]);
    let inside = y >= first + MARGIN && y < first + f64::from(shape.bases(axis)) - MARGIN;
    !(inside || shape.is_collapsed(axis))
}

/// Whether a particle at y, of half-size `half` [cells], is outside of the level.
pub fn outside(level: &Level, axis: usize, y: f64, half: f64) -> bool {
    !(level.cells[axis] == 0 || y >= -half && y <= level.cells[axis] as f64 - half)
}

/// Whether the extent of a block says that particles are out of reach, or outside of the level.
pub fn somebody_left(extent: &Extent, level: &Level, block: BlockIndex, half_size: [f64; 3]) -> bool {
    (0..3).any(|axis| {
        let (least, most) = bounds(extent, axis);
        // nobody is in an extent whose bounds are the other way round
        let left = |y| out_of_reach(level, block, axis, y) || outside(level, axis, y, half_size[axis]);
        least <= most && (left(least) || left(most))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_touched_nodes_are_those_of_all_bases_between_the_bounds() {
        let level = Level { lower: [0.0; 3], cell: 1.0, cells: [40; 3] };
        let mut extent = NOBODY;
        include(&mut extent, [9.5, 8.0, 11.9]);
        include(&mut extent, [8.2, 7.5, 11.99]);
        let nodes = touched(&extent, level.shape(), [2, 2, 2]);
        // the buffer begins at node 7; y = 8 lies within the margin of node 7
        assert_eq!(nodes, IndexBox { lower: [1, 0, 4], upper: [5, 4, 7] });
        let all = IndexBox { lower: [0; 3], upper: [8; 3] };
        assert_eq!(touched(&ANYWHERE, level.shape(), [2, 2, 2]), all);
        assert_eq!(bounds(&extent, 1).0, 7.5 - MARGIN);
    }

    #[test]
    fn nobody_leaves_along_a_collapsed_axis() {
        let level = Level { lower: [0.0; 3], cell: 1.0, cells: [8, 8, 0] };
        let mut extent = NOBODY;
        include(&mut extent, [2.5, 1.0, 0.0]);
        assert_eq!(
            touched(&extent, level.shape(), [0, 0, 0]),
            IndexBox { lower: [3, 1, 0], upper: [6, 5, 1] }
        );
        assert!(!somebody_left(&extent, &level, [0, 0, 0], [0.0; 3]));
    }
}
