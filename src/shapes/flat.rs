//! Shape functions on a level with collapsed axes: there a particle lies on the one layer of nodes.
use super::{Axis, ShapeFunction};
use simd::Simd;

/// A shape function that is constant along some axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flat<F> {
    /// Along the other axes.
    pub shape: F,
    /// Which axes are collapsed.
    pub collapsed: [bool; 3],
}

impl<F: ShapeFunction> ShapeFunction for Flat<F> {
    #[inline(always)]
    fn half_size(&self, axis: usize) -> f64 {
        if self.collapsed[axis] { 0.0 } else { self.shape.half_size(axis) }
    }

    /// w₀ = 1 on a collapsed axis: there is no other node.
    #[inline(always)]
    fn weights<S: Simd>(&self, axis: usize, t: S) -> Axis<S> {
        let (zero, one) = (S::splat(0.0), S::splat(1.0));
        match self.collapsed[axis] {
            true => Axis { weight: [one, zero], gradient: [zero, zero], third: 0 },
            false => self.shape.weights(axis, t),
        }
    }
}
