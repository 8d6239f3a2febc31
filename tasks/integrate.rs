use crate::labels::{NodeMotion, NodeSums, OwnStep};
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::{Simd, Wide};

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
pub fn integrate<S: Simd>(sums: &[Wide], motions: &mut [Wide], dt: f64, least_mass: f64) {
    for (sum, motion) in sums.iter().zip(motions) {
        let factor = if sum.0[0] > least_mass { dt / sum.0[0] } else { 0.0 };
        // f both in the velocity and in its change
        let force = S::load(sum).momentum_to_low().swap_halves();
        (S::load(motion) + S::splat(factor) * S::join_low(force, force)).store(motion);
    }
}

/// Adds `dv` to a node's velocity, and to what its particles will be told of the change.
#[inline(always)]
pub fn change(motion: &mut Wide, dv: [f64; 3]) {
    for axis in 0..3 {
        motion.0[axis] += dv[axis];
        motion.0[4 + axis] += dv[axis];
    }
}

/// (v⁰ + v)/2 of a node.
#[inline(always)]
pub fn mean_velocity(motion: &Wide) -> [f64; 3] {
    let [x, y, z, _, dx, dy, dz, _] = motion.0;
    [x - 0.5 * dx, y - 0.5 * dy, z - 0.5 * dz]
}
