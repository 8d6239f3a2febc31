use crate::labels::{ForceWork, NodeMotion, NodeSums, OwnStep};
use crate::node::{Motion, Sums};
use engine::data::exact_sum::ExactSum;
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

engine::task! {
    /// Accelerates the grid nodes by the internal forces: v_I ← v_I + Δt f_I / m_I over the tick, symplectic Euler. Where a material waits for a
    /// faster one its velocity is v⁰ + s Δt a + C after s ticks, with C what contact did so far. Where a step begins, Δt Σ f_I · v⁰_I of it is counted.
    pub struct Integrate {
        /// Mass below which a node carries nothing [kg].
        pub least_mass: f64,
    }

    Nodes task {
        requires new { step: OwnStep, sums: NodeSums }
        computes { work: ForceWork }
        modifies { motion: NodeMotion }
    }
}

impl Body for Integrate {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let fields = io.sums.chunks_exact(NODES).zip(io.motion.chunks_exact_mut(NODES)).zip(at.fields);
        for ((sums, motions), field) in fields {
            let power = integrate::<S>(sums, motions, field.tick, self.least_mass);
            if field.begins {
                count(&mut io.work[0], io.step[field.material].first, field.step * power);
            }
        }
    }
}

/// v_I ← v_I + Δt f_I / m_I; Σ f_I · v⁰_I [W]
#[inline(always)]
pub fn integrate<S: Simd>(sums: &[Sums], motions: &mut [Motion], dt: f64, least_mass: f64) -> f64 {
    let mut power = S::splat(0.0);
    for (sum, motion) in sums.iter().zip(motions) {
        let factor = if sum.mass() > least_mass { dt / sum.mass() } else { 0.0 };
        let (force, velocity) = (sum.force_line::<S>(), S::load(&motion.0));
        // nodes that carry nothing rest
        power = force.fma(velocity - velocity.swap_halves(), power);
        (velocity + S::splat(factor) * force).store(&mut motion.0);
    }
    power.lanes()[..3].iter().sum()
}

/// Adds work of a step that began with tick number `first`.
#[inline]
pub fn count(into: &mut [ExactSum; 2], first: f64, work: f64) {
    into[0].add(work);
    if first == 0.0 {
        into[1].add(work);
    }
}
