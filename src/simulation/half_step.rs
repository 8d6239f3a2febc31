//! What the account of energy needs to be of second order: positions are at whole steps, velocities half a step behind.
//!
//! A step from t_n changes the kinetic energy of particles by Δt Σ f_n · (v⁰ + v¹)/2, by what acts from outside, and by what the transfer takes.
//! The energy of their strain changes by the mean work of the stresses of both its ends,
//! ½ Σ V₀ (τ_n : Δt L + τ_{n+1} : (1 − (1 + Δt L)⁻¹)), up to third order. The first part is −Δt Σ f_n · v¹. So the sum of both changes is
//!
//! ½ Δt Σ f_n · v⁰ − ½ S_{n+1},  S_{n+1} = −Σ V₀ τ_{n+1} : (1 − (1 + Δt L)⁻¹),
//!
//! where S_n and Δt Σ f_n · v⁰ differ by what the transfer to nodes takes of the velocities that strained the particles: the second half of its
//! loss. What remains at the end, ½ S_N − ½ Δt Σ f_0 · v⁰, is what internal forces do to the velocities in half a step.
use engine::data::exact_sum::ExactSum;
use engine::data::rates::{Clock, MaterialStep};
use engine::data::shared::Shared;
use engine::graph::build::TaskGraph;
use engine::schema::Label;
use tasks::labels::{ForceWork, OwnStep, StressWork, Time};

/// Running sums.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HalfStep {
    /// Σ S_n so far [J].
    stress: f64,
    /// Σ Δt Σ f_n · v⁰ so far [J].
    force: f64,
    /// Of that, in the first step of each material [J].
    first: f64,
    /// The last S_n of each material [J].
    last: Vec<f64>,
}

impl HalfStep {
    /// Before the first step of so many materials.
    pub fn new(materials: usize) -> Self {
        Self { last: vec![0.0; materials], ..Self::default() }
    }

    /// Adds what a graph has just summed up.
    pub fn add(&mut self, graph: &TaskGraph, shared: &Shared) {
        if graph.computes(ForceWork::ID) {
            let work: [ExactSum; 2] = shared.get(ForceWork::ID, 0);
            self.force += work[0].value();
            self.first += work[1].value();
        }
        if !graph.computes(StressWork::ID) {
            return;
        }
        let ticks = shared.get::<Clock>(Time::ID, 0).number;
        for (material, last) in self.last.iter_mut().enumerate() {
            // the number of a material that waits is that of its last step
            if ticks >= shared.get::<MaterialStep>(OwnStep::ID, material).last {
                *last = shared.get::<ExactSum>(StressWork::ID, material).value();
                self.stress += *last;
            }
        }
    }

    /// What internal forces do to velocities in half a step, now, less what they did at the start [J].
    pub fn ahead(&self) -> f64 {
        0.5 * (self.last.iter().sum::<f64>() - self.first)
    }

    /// The second half of the loss of the transfer [J].
    pub fn transfer(&self) -> f64 {
        0.5 * (self.stress - self.force) - self.ahead()
    }

    /// As numbers, for a checkpoint: three, and one a material.
    pub fn numbers(&self) -> impl Iterator<Item = f64> {
        [self.stress, self.force, self.first].into_iter().chain(self.last.iter().copied())
    }

    /// From its numbers.
    pub fn from_numbers(numbers: &[f64]) -> Option<Self> {
        let (&[stress, force, first], last) = numbers.split_first_chunk::<3>()?;
        Some(Self { stress, force, first, last: last.to_vec() })
    }
}
