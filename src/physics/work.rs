//! Work and impulse that something outside does on the matter.
use crate::data::exact_sum::ExactSum;

/// Sums of work and impulse over a few nodes or particles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Σ m (v + Δv/2) · Δv [J]
    pub work: f64,
    /// Σ m Δv [N s]
    pub impulse: [f64; 3],
}

impl Work {
    /// Counts a change of velocity `dv` of a mass `m` that moved at `v`.
    #[inline(always)]
    pub fn add(&mut self, m: f64, v: [f64; 3], dv: [f64; 3]) {
        for a in 0..3 {
            self.work += m * (v[a] + 0.5 * dv[a]) * dv[a];
            self.impulse[a] += m * dv[a];
        }
    }

    /// Adds the sums to exact ones: work, then impulse.
    #[inline(always)]
    pub fn store(&self, into: &mut [ExactSum; 4]) {
        into[0].add(self.work);
        (0..3).for_each(|a| into[1 + a].add(self.impulse[a]));
    }
}
