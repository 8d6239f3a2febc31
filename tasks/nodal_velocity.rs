use super::integrate::integrate;
use crate::labels::{NodeMotion, NodeSums, OwnStep};
use crate::node::{Motion, Sums};
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

engine::task! {
    /// The velocity of each grid node, v_I = (mv)_I / m_I, no change yet, where a step begins; m_I goes along for those who have no sums. Nodes
    /// below `least_mass` rest. Where a material waited, and nobody asked for its nodes, they are brought to the beginning of the tick:
    /// v_I + Δt f_I / m_I over the ticks missed.
    pub struct NodalVelocity {
        /// Mass below which a node carries nothing [kg].
        pub least_mass: f64,
    }

    Nodes task {
        requires new { step: OwnStep, sums: NodeSums }
        modifies { motion: NodeMotion }
    }
}

impl Body for NodalVelocity {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let fields = io.sums.chunks_exact(NODES).zip(io.motion.chunks_exact_mut(NODES)).zip(at.fields);
        for ((sums, motions), field) in fields {
            if field.begins {
                self.begin::<S>(sums, motions);
            }
            if field.missed > 0.0 {
                integrate::<S>(sums, motions, field.missed, self.least_mass);
            }
        }
    }
}

impl NodalVelocity {
    #[inline(always)]
    fn begin<S: Simd>(&self, sums: &[Sums], motions: &mut [Motion]) {
        for (sum, motion) in sums.iter().zip(motions) {
            let inverse = if sum.mass() > self.least_mass { 1.0 / sum.mass() } else { 0.0 };
            (sum.momentum_line::<S>() * S::splat(inverse)).with_3(S::splat(sum.mass())).store(&mut motion.0);
        }
    }
}
