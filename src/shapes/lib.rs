//! Shape functions, one axis at a time, and the transfer between a particle and its nodes.
pub mod flat;
pub mod gimp;
pub mod linear;
pub mod transfer;

use bytemuck::{Pod, Zeroable};
use grid::Origin;
use simd::{Simd, Wide};

/// Tiles whose particles are taken class by class: the unit of summation order.
pub const GROUP: usize = 4;
/// Adding it to a small integer leaves that integer in the low bits.
const INDEX: f64 = (1u64 << 52) as f64;

/// Two rows of eight numbers for each of eight particles.
pub type NodeRows = [[Wide; 2]; 8];

/// Weights and gradients of eight particles on at most three nodes an axis.
///
/// The middle node takes what the outer two leave: w₁ = 1 − w₀ − w₂ and g₁ = −g₀ − g₂, so that partition of
/// unity holds to rounding.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Stencil {
    /// `[axis][node 0 or 2]`
    pub weight: [[Wide; 2]; 3],
    /// `[axis][node 0 or 2]` [1/m]
    pub gradient: [[Wide; 2]; 3],
    /// 2⁵² + index of node (0,0,0) of the stencil in the block's buffer.
    base: Wide,
    /// Per axis, bit i: particle i touches node 2.
    third: [u64; 8],
}

/// Weights on one axis.
#[derive(Clone, Copy)]
pub struct Axis<S> {
    /// On node 0 and node 2.
    pub weight: [S; 2],
    /// Derivative times the cell size, on node 0 and node 2.
    pub gradient: [S; 2],
    /// Which particles touch node 2.
    pub third: u8,
}

/// A shape function on one axis, for a particle of half-size r (in cells).
pub trait ShapeFunction: Copy + Send + Sync + 'static {
    /// Half-size r along `axis` in cells: the lowest node is ⌊x/h − r⌋.
    fn half_size(&self, axis: usize) -> f64;
    /// Weights from t = x/h − r − ⌊x/h − r⌋ in [0, 1).
    fn weights<S: Simd>(&self, axis: usize, t: S) -> Axis<S>;
}

impl Stencil {
    /// Stencils of eight particles at `x` [m].
    #[inline(always)]
    pub fn fill<S: Simd, F: ShapeFunction>(
        &mut self,
        shape: &F,
        x: &[Wide; 3],
        origin: &Origin,
        inverse_cell: f64,
    ) {
        let mut base = S::splat(INDEX);
        for axis in 0..3 {
            let shift = origin.lower[axis] + shape.half_size(axis);
            let y = S::load(&x[axis]).fms(S::splat(inverse_cell), S::splat(shift));
            let node = y.floor();
            let on_axis = shape.weights(axis, y - node);
            for k in 0..2 {
                on_axis.weight[k].store(&mut self.weight[axis][k]);
                (on_axis.gradient[k] * S::splat(inverse_cell)).store(&mut self.gradient[axis][k]);
            }
            self.third[axis] = u64::from(on_axis.third);
            base = (node - S::splat(origin.node[axis])).fma(S::splat(origin.strides[axis]), base);
        }
        base.store(&mut self.base);
    }

    /// Where particle `lane`'s stencil starts in the block's buffer. An index in range proves nothing: one axis
    /// can wrap into the next, so whoever moves particles checks each axis (`BlockExtent`).
    #[inline(always)]
    fn first_node(&self, lane: usize) -> usize {
        self.base.0[lane & 7].to_bits().wrapping_sub(INDEX.to_bits()) as usize
    }

    /// The nodes that particle `lane` touches: line in the block's buffer, S and ∇S [1/m]. One by one, on any number of
    /// axes: for what need not be as fast as [`transfer`].
    pub fn nodes(&self, lane: usize, origin: &Origin) -> impl Iterator<Item = (usize, f64, [f64; 3])> + '_ {
        let first = self.first_node(lane);
        let strides = origin.shape.buffer_strides;
        let counts = [0, 1, 2].map(|axis| match origin.shape.is_collapsed(axis) {
            true => 1,
            false => 2 + (self.third[axis] >> lane & 1) as usize,
        });
        let [nx, ny, nz] = counts;
        (0..nx * ny * nz).map(move |n| {
            let place = [n / (ny * nz), n / nz % ny, n % nz];
            let of = |pairs: &[[Wide; 2]; 3], axis: usize, all: f64| {
                let [outer, last] = pairs[axis].each_ref().map(|line| line.0[lane]);
                let last = if counts[axis] == 3 { last } else { 0.0 };
                [outer, all - outer - last, last][place[axis]]
            };
            let s = [0, 1, 2].map(|axis| of(&self.weight, axis, 1.0));
            let g = [0, 1, 2].map(|axis| of(&self.gradient, axis, 0.0));
            let line = (0..3).map(|a| place[a] * strides[a] as usize).sum::<usize>();
            (first + line, s[0] * s[1] * s[2], [g[0] * s[1] * s[2], s[0] * g[1] * s[2], s[0] * s[1] * g[2]])
        })
    }
}

/// The particles (bit 8·tile + lane) of up to eight tiles, of which the first `count` exist, by the nodes that
/// they touch: bit a of the class says whether they touch the third node of axis a.
#[inline(always)]
pub fn classes(tiles: &[Stencil], count: usize) -> [u64; 8] {
    let everyone = if count >= 64 { u64::MAX } else { (1 << count) - 1 };
    let bits = |axis: usize| tiles.iter().rev().fold(0, |bits, tile| bits << 8 | tile.third[axis]);
    let [x, y, z] = [bits(0), bits(1), bits(2)];
    let pick = |bits: u64, wanted: bool| if wanted { bits } else { !bits };
    std::array::from_fn(|c| everyone & pick(x, c & 1 != 0) & pick(y, c & 2 != 0) & pick(z, c & 4 != 0))
}

/// Runs `body` for each particle of up to eight tiles with its number of nodes per axis as constants: the
/// branch on the class is taken 8 times a group, not once a particle.
#[macro_export]
macro_rules! for_each_particle_by_class {
    (@ $masks:ident, $i:ident, $X:ident, $Y:ident, $Z:ident, $body:expr;
     $($class:literal: $x:literal $y:literal $z:literal),*) => {{ $({
        const $X: usize = $x;
        const $Y: usize = $y;
        const $Z: usize = $z;
        let mut mask = $masks[$class];
        while mask != 0 {
            let $i = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            $body;
        }
    })* }};
    ($stencils:expr, $count:expr, |$i:ident, $X:ident, $Y:ident, $Z:ident| $body:expr) => {{
        let masks = $crate::classes($stencils, $count);
        $crate::for_each_particle_by_class!(@ masks, $i, $X, $Y, $Z, $body;
            0: 2 2 2, 1: 3 2 2, 2: 2 3 2, 3: 3 3 2, 4: 2 2 3, 5: 3 2 3, 6: 2 3 3, 7: 3 3 3)
    }};
}
