use crate::data::labels::{NodeMotion, NodeSums};
use crate::graph::task::{At, Body};
use crate::simd::{Simd, Wide};

/// v_I = (mv)_I / m_I, no change yet. Nodes below `least_mass` rest.
pub struct NodalVelocity {
    /// Mass below which a node carries nothing [kg].
    pub least_mass: f64,
}

crate::task! { Nodes task NodalVelocity {
    requires new { sums: NodeSums }
    computes { motion: NodeMotion }
}}

impl Body for NodalVelocity {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        for (sum, motion) in io.sums.iter().zip(io.motion.iter_mut()) {
            *motion = Wide::default();
            let mass = sum.0[0];
            if mass > self.least_mass {
                let inverse = 1.0 / mass;
                for axis in 0..3 {
                    motion.0[axis] = sum.0[1 + axis] * inverse;
                }
            }
        }
    }
}
