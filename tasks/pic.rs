//! How much of the velocity of the nodes particles take over.

/// A share per step, and a rate that does not depend on the step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pic {
    /// Share in a step.
    pub share: f64,
    /// What a particle does not share with the nodes decays at this rate [1/s].
    pub rate: f64,
}

impl Pic {
    /// β in a step of size `dt` [s]: 1 − β = (1 − share) e^(−rate Δt).
    #[inline(always)]
    pub fn of(self, dt: f64) -> f64 {
        if self.rate == 0.0 {
            return self.share;
        }
        1.0 - (1.0 - self.share) * (-self.rate * dt).exp()
    }
}
