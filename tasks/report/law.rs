use super::add_all;
use crate::labels::{Deformation, FailedCount, History, InitialVolume, MaterialEnergy};
use engine::graph::task::{At, Body};
use physics::law::{Kinematics, Law, MAX_HISTORY};
use physics::tensor::{determinant, increment};
use simd::{Mask, Simd, load};

/// Strain, plastic and fracture energy of one material, and its failed particles by kind.
pub struct ReportLaw<L> {
    /// The law.
    pub law: L,
    /// Which number of the law's history is the failure code, if any.
    pub failure: Option<usize>,
}

engine::task! { Particles task ReportLaw [L: Law] {
    requires old { initial_volume: InitialVolume, deformation: Deformation, history: History }
    computes { energy: MaterialEnergy, failed: FailedCount }
}}

impl<L: Law> Body for ReportLaw<L> {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let zero = S::splat(0.0);
        let (mut energy, mut failed) = ([zero; 3], [0.0; 4]);
        let lines = L::HISTORY.len();
        for (tile, (v0, f)) in io.initial_volume.iter().zip(io.deformation.iter()).enumerate() {
            let (v0, f) = (S::load(v0), load(f));
            let mut h = [zero; MAX_HISTORY];
            let history = &io.history[tile * lines..(tile + 1) * lines];
            h.iter_mut().zip(history).for_each(|(h, line)| *h = S::load(line));
            let still = increment(&[zero; 9], zero);
            let kinematics = Kinematics { f, j: determinant(&f), increment: still };
            let densities = self.law.energies(&kinematics, &h[..lines]);
            let densities = [densities.strain, densities.plastic, densities.fracture];
            for (sum, density) in energy.iter_mut().zip(densities) {
                // lanes without a particle have no volume, whatever their density is
                *sum = v0.fma(S::select(at.lanes(tile), density, zero), *sum);
            }
            if let Some(failure) = self.failure {
                count(h[failure], at.lanes(tile), &mut failed);
            }
        }
        add_all(&mut io.energy[0][1..4], energy);
        io.failed[0].iter_mut().zip(failed).for_each(|(sum, n)| sum.add(n));
    }
}

/// Particles by failure code: 1 matrix, 2 fiber, 3 total, 4 total by inversion.
#[inline(always)]
fn count<S: Simd>(code: S, here: Mask, failed: &mut [f64; 4]) {
    let at_least = |c: f64| f64::from((code.ge(S::splat(c - 0.5)) & here).count_ones());
    let n = [1.0, 2.0, 3.0, 4.0, 5.0].map(at_least);
    (0..4).for_each(|i| failed[i] += n[i] - n[i + 1]);
}
