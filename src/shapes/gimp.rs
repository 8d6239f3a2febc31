//! Uniform GIMP: the hat function averaged over a particle of fixed size.
//! S. G. Bardenhagen, E. M. Kober, CMES 5(6), 2004, 477–495, eqs. 41–42 (doi:10.3970/cmes.2004.005.477).
use super::{Axis, ShapeFunction};
use simd::Simd;

/// Half-sizes of a particle along the axes in cells, each in (0, ½].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gimp {
    /// r = l_p/h on each axis.
    pub half_size: [f64; 3],
}

impl ShapeFunction for Gimp {
    #[inline(always)]
    fn half_size(&self, axis: usize) -> f64 {
        self.half_size[axis]
    }

    /// With u = 1 − t, e = max(2r − u, 0) and δ = max(u − 2r, 0):
    /// w₀ = (u² − δ²)/4r, w₂ = e²/4r, h g₂ = e/2r, h g₀ = h g₂ − 1.
    #[inline(always)]
    fn weights<S: Simd>(&self, axis: usize, t: S) -> Axis<S> {
        let r = self.half_size[axis];
        let (zero, quarter) = (S::splat(0.0), S::splat(0.25 / r));
        let u = S::splat(1.0) - t;
        let past = S::splat(2.0 * r) - u;
        let e = past.max(zero);
        let delta = (zero - past).max(zero);
        let g2 = e * S::splat(0.5 / r);
        Axis {
            weight: [u.fms(u, delta * delta) * quarter, e * e * quarter],
            gradient: [g2 - S::splat(1.0), g2],
            third: past.ge(zero),
        }
    }
}
