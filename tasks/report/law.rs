use super::add_all;
use crate::labels::{Deformation, History, InitialVolume, LargestHistory, MaterialEnergy, StateCount};
use engine::graph::task::{At, Body};
use physics::law::{Kinematics, Law, MAX_COUNTS, MAX_HISTORY};
use physics::quantities::COLLAPSED;
use physics::tensor::{determinant, increment};
use simd::{Simd, load};

engine::task! {
    /// Adds up strain, plastic and fracture energy of one material, its particles in each state that its law counts and those that have
    /// collapsed, and the largest of what its law keeps.
    pub struct ReportLaw<L: Law>(pub L);

    Particles task {
        requires old { initial_volume: InitialVolume, deformation: Deformation, history: History }
        computes { energy: MaterialEnergy, counts: StateCount, largest: LargestHistory }
    }
}

impl<L: Law> Body for ReportLaw<L> {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let zero = S::splat(0.0);
        let (mut energy, mut counts) = ([zero; 3], [0; MAX_COUNTS + 1]);
        let lines = L::HISTORY.len();
        for (tile, (v0, f)) in io.initial_volume.iter().zip(io.deformation.iter()).enumerate() {
            let (v0, f) = (S::load(v0), load(f));
            let mut h = [zero; MAX_HISTORY];
            let history = &io.history[tile * lines..(tile + 1) * lines];
            h.iter_mut().zip(history).for_each(|(h, line)| *h = S::load(line));
            let still = increment(&[zero; 9], zero);
            let kinematics = Kinematics { f, j: determinant(&f), increment: still };
            let densities = self.0.energies(&kinematics, &h[..lines]);
            let densities = [densities.strain, densities.plastic, densities.fracture];
            for (sum, density) in energy.iter_mut().zip(densities) {
                // lanes without a particle have no volume, whatever their density is
                *sum = v0.fma(S::select(at.lanes(tile), density, zero), *sum);
            }
            let nothing = S::splat(f64::NEG_INFINITY);
            for (largest, h) in io.largest[0].iter_mut().zip(&h[..lines]) {
                S::load(largest).max(S::select(at.lanes(tile), *h, nothing)).store(largest);
            }
            let states = self.0.counts(&kinematics, &h[..lines]);
            for state in 0..L::COUNTS.len() {
                counts[state] += (states[state] & at.lanes(tile)).count_ones();
            }
            let collapsed = kinematics.j.lt(S::splat(COLLAPSED));
            counts[MAX_COUNTS] += (collapsed & at.lanes(tile)).count_ones();
        }
        add_all(&mut io.energy[0][1..4], energy);
        io.counts[0].iter_mut().zip(counts).for_each(|(sum, n)| sum.add(f64::from(n)));
    }
}
