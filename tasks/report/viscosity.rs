use super::add_all;
use crate::labels::{InitialVolume, MaterialEnergy, ViscousWork};
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// What the artificial viscosity has turned into heat so far.
    pub struct ReportViscosity;

    Particles task {
        requires old { initial_volume: InitialVolume, work: ViscousWork }
        computes { energy: MaterialEnergy }
    }
}

impl Body for ReportViscosity {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let mut heat = S::splat(0.0);
        for (v0, work) in io.initial_volume.iter().zip(io.work.iter()) {
            heat = S::load(v0).fma(S::load(work), heat);
        }
        add_all(&mut io.energy[0][4..], [heat]);
    }
}
