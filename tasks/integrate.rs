use crate::labels::{NodeMotion, NodeSums, OwnStep};
use crate::node::{Motion, Sums};
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

/// v_I ← v_I + Δt f_I / m_I over the tick: symplectic Euler on the nodes. Where a material waits for a faster one its
/// velocity is v⁰ + s Δt a + C after s ticks, with C what contact did so far.
pub struct Integrate {
    /// Mass below which a node carries nothing [kg].
    pub least_mass: f64,
}

engine::task! { Nodes task Integrate {
    requires new { step: OwnStep, sums: NodeSums }
    modifies { motion: NodeMotion }
}}

impl Body for Integrate {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let fields = io.sums.chunks_exact(NODES).zip(io.motion.chunks_exact_mut(NODES)).zip(at.fields);
        for ((sums, motions), field) in fields {
            integrate::<S>(sums, motions, field.tick, self.least_mass);
        }
    }
}

/// v_I ← v_I + Δt f_I / m_I
#[inline(always)]
pub fn integrate<S: Simd>(sums: &[Sums], motions: &mut [Motion], dt: f64, least_mass: f64) {
    for (sum, motion) in sums.iter().zip(motions) {
        let factor = if sum.mass() > least_mass { dt / sum.mass() } else { 0.0 };
        (S::load(&motion.0) + S::splat(factor) * sum.force_line()).store(&mut motion.0);
    }
}
