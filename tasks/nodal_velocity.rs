use crate::data::labels::{NodeMotion, NodeSums};
use crate::data::nodes::NODES;
use crate::graph::task::{At, Body};
use crate::simd::Simd;

/// v_I = (mv)_I / m_I, no change yet, where a step begins. Nodes below `least_mass` rest.
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
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let zero = S::splat(0.0);
        let fields = io.sums.chunks_exact(NODES).zip(io.motion.chunks_exact_mut(NODES)).zip(at.fields);
        for ((sums, motions), _) in fields.filter(|(_, field)| field.begins) {
            for (sum, motion) in sums.iter().zip(motions) {
                let mass = sum.0[0];
                let inverse = if mass > self.least_mass { 1.0 / mass } else { 0.0 };
                let momentum = S::blend_force(S::load(sum).momentum_to_low(), zero);
                (momentum * S::splat(inverse)).store(motion);
            }
        }
    }
}
