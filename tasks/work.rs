//! Work and impulse that something outside does on the matter.
use crate::rigid::state::RigidState;
use engine::data::exact_sum::ExactSum;

/// Sums of work and impulse over a few nodes or particles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Σ m Δv · v̄ [J]
    pub work: f64,
    /// Σ m Δv [N s]
    pub impulse: [f64; 3],
}

impl Work {
    /// Counts a change of velocity `dv` of a mass `m` whose velocity over the step is `mean` in the mean.
    #[inline(always)]
    pub fn add(&mut self, m: f64, mean: [f64; 3], dv: [f64; 3]) {
        for a in 0..3 {
            self.work += m * dv[a] * mean[a];
            self.impulse[a] += m * dv[a];
        }
    }

    /// Counts what a body whose motion is prescribed does on the matter: `sums` are the impulse and the torque impulse
    /// that it receives.
    pub fn hold(&mut self, body: &RigidState, sums: &[f64; 6]) {
        for a in 0..3 {
            self.work -= sums[a] * body.velocity[a] + sums[3 + a] * body.angular[a];
            self.impulse[a] -= sums[a];
        }
    }

    /// Adds the sums to exact ones: work, then impulse.
    #[inline(always)]
    pub fn store(&self, into: &mut [ExactSum; 4]) {
        into[0].add(self.work);
        (0..3).for_each(|a| into[1 + a].add(self.impulse[a]));
    }
}
