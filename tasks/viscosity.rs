use crate::labels::{
    InitialVolume, KirchhoffStress, Mass, OwnStep, StiffnessBound, StressWork, VelocityGradient,
    ViscousPressure, ViscousWork, Volume,
};
use engine::graph::task::{At, Body};
use physics::tensor::{backward_work, increment};
use physics::viscosity::Viscosity as Law;
use simd::{Simd, load};

engine::task! {
    /// Adds the pressure of the artificial viscosity where matter is compressed, τ ← τ − J q 1; the step heeds that it stiffens. The work goes to
    /// heat and is counted, by the trapezoidal rule as that of all stresses: ½ (J q)_n tr Δt L + ½ (J q)_{n+1} tr (1 − (1 + Δt L)⁻¹).
    pub struct Viscosity {
        /// The law.
        pub law: Law,
        /// Edge of a cell [m].
        pub cell: f64,
    }

    Particles task {
        requires old { mass: Mass, initial_volume: InitialVolume }
        requires new { gradient: VelocityGradient, volume: Volume }
        requires now { step: OwnStep }
        computes { spent: StressWork }
        modifies { stress: KirchhoffStress, work: ViscousWork, pressure: ViscousPressure, stiffness: StiffnessBound }
    }
}

impl Body for Viscosity {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let (dt, cell) = (S::splat(io.step[0].size), S::splat(self.cell));
        let (tiny, mut all) = (S::splat(f64::MIN_POSITIVE), S::splat(0.0));
        let scalars = io.mass.iter().zip(io.initial_volume.iter()).zip(io.volume.iter());
        let tiles = io.gradient.iter().zip(io.stiffness.iter_mut()).zip(io.stress.iter_mut());
        let heat = io.work.iter_mut().zip(io.pressure.iter_mut());
        for ((((m, v0), v), ((l, stiffness), tau)), (work, known)) in scalars.zip(tiles).zip(heat) {
            let (m, v0, v) = (S::load(m), S::load(v0), S::load(v));
            // lanes without a particle have no volume
            let (density, j) = (m / v.max(tiny), v / v0.max(tiny));
            let c = (S::load(stiffness) * v0 / m.max(tiny)).sqrt();
            let rate = S::load(&l[0]) + S::load(&l[4]) + S::load(&l[8]);
            // what carries no stress any more carries no viscous stress either
            let carries = S::splat(0.0).lt(S::load(stiffness));
            let pressure = S::select(carries, j * self.law.pressure(density, c, rate, cell), S::splat(0.0));
            for component in [0, 3, 5] {
                (S::load(&tau[component]) - pressure).store(&mut tau[component]);
            }
            let zero = S::splat(0.0);
            let isotropic = [pressure, zero, zero, pressure, zero, pressure];
            let after = backward_work(&isotropic, &increment(&load(l), dt));
            all = v0.fma(after, all);
            let spent = S::splat(0.5) * (S::load(known) * rate).fma(dt, after);
            (S::load(work) - spent).store(work);
            pressure.store(known);
            let hurry = self.law.hurry(c, rate, cell);
            (S::load(stiffness) * hurry * hurry).store(stiffness);
        }
        io.spent[0].add(all.lanes().iter().sum());
    }
}
