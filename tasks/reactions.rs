//! What faces, drives, bodies and loads give to the matter, and materials to one another: force, torque and work.
use engine::data::exact_sum::ExactSum;
use physics::contact::cross;

/// Numbers of a tile of `Reactions`: impulse (3), torque impulse about the origin (3), work.
pub const NUMBERS: usize = 7;

/// What a giver gives to some nodes or particles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reaction {
    /// Σ m Δv [N s]
    pub impulse: [f64; 3],
    /// Σ x × m Δv [N m s]
    pub torque: [f64; 3],
    /// Σ m Δv · v̄ [J]
    pub work: f64,
}

impl Reaction {
    /// Counts an impulse [N s] at `x` [m], where the matter has the velocity `mean` in the mean over the step.
    #[inline(always)]
    pub fn add(&mut self, x: [f64; 3], impulse: [f64; 3], mean: [f64; 3]) {
        let torque = cross(x, impulse);
        for a in 0..3 {
            self.impulse[a] += impulse[a];
            self.torque[a] += torque[a];
            self.work += impulse[a] * mean[a];
        }
    }

    /// Force and torque alone.
    pub fn without_work(self) -> Self {
        Self { work: 0.0, ..self }
    }

    /// So many times it.
    pub fn times(self, factor: f64) -> Self {
        let Self { impulse, torque, work } = self;
        Self { impulse: impulse.map(|p| factor * p), torque: torque.map(|p| factor * p), work: factor * work }
    }

    /// Adds it to a tile of exact sums.
    #[inline]
    pub fn store(&self, into: &mut [ExactSum; NUMBERS]) {
        for a in 0..3 {
            into[a].add(self.impulse[a]);
            into[3 + a].add(self.torque[a]);
        }
        into[6].add(self.work);
    }
}
