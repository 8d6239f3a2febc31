//! Trilinear hat functions: a particle is a point.
//! D. Sulsky, Z. Chen, H. L. Schreyer, CMAME 118, 1994, 179–196 (doi:10.1016/0045-7825(94)90112-0).
use super::{Axis, ShapeFunction};
use simd::Simd;

/// Hat functions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear;

impl ShapeFunction for Linear {
    #[inline(always)]
    fn half_size(&self, _axis: usize) -> f64 {
        0.0
    }

    /// w₀ = 1 − t, w₁ = t: there is no third node.
    #[inline(always)]
    fn weights<S: Simd>(&self, _axis: usize, t: S) -> Axis<S> {
        let (zero, one) = (S::splat(0.0), S::splat(1.0));
        Axis { weight: [one - t, zero], gradient: [zero - one, zero], third: 0 }
    }
}
