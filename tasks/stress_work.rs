use crate::labels::{
    InitialVolume, KirchhoffStress, OwnStep, StressWork as StressWorkLabel, VelocityGradient,
};
use engine::graph::task::{At, Body};
use physics::tensor::{backward_work, increment};
use simd::{Simd, load};

/// −Σ_p V⁰_p τ_p : (1 − (1 + Δt L_p)⁻¹), with the stress at the end of the step: what internal forces would have done in it if they had
/// been those of its end. With what those of its beginning did, Δt Σ_I f_I · v_I, that is the trapezoidal rule: second order in Δt.
pub struct StressWork;

engine::task! { Particles task StressWork {
    requires old { initial_volume: InitialVolume }
    requires new { stress: KirchhoffStress, gradient: VelocityGradient }
    requires now { step: OwnStep }
    computes { work: StressWorkLabel }
}}

impl Body for StressWork {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let (dt, mut work) = (S::splat(io.step[0].size), S::splat(0.0));
        for ((tau, l), v0) in io.stress.iter().zip(io.gradient.iter()).zip(io.initial_volume.iter()) {
            let spent = backward_work(&load(tau), &increment(&load(l), dt));
            work = S::load(v0).fnma(spent, work);
        }
        io.work[0].add(work.lanes().iter().sum());
    }
}
