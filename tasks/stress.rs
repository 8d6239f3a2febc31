use crate::fault::{self, Who};
use crate::labels::{
    Deformation, Fault, FirstEvent, History, Identity, InitialVolume, KirchhoffStress, OwnStep, Position,
    StiffnessBound, StressWork, VelocityGradient, Volume,
};
use engine::graph::task::{At, Body};
use physics::law::{Events, Kinematics, Law, MAX_HISTORY, fits};
use physics::tensor::{backward_work, determinant, increment, multiply};
use simd::{Simd, load, store};

engine::task! {
    /// Deforms the particles, F ← (1 + Δt L) F, and asks the material's law for their stress τ(F, history), with V = J V⁰ and the bound of
    /// ρ₀ c². For the account of energy (see `StressWork`), −V⁰ τ : (1 − (1 + Δt L)⁻¹).
    ///
    /// The law is a type, chosen where the recipe is built. It may freeze a particle that carries no stress any
    /// more: that particle keeps its F.
    pub struct Stress<L: Law>(pub L);

    Particles task {
        requires old { position: Position, initial_volume: InitialVolume, identity: Identity }
        requires new { gradient: VelocityGradient }
        requires now { step: OwnStep }
        computes {
            stress: KirchhoffStress,
            stiffness: StiffnessBound,
            fault: Fault,
            first: FirstEvent,
            work: StressWork,
        }
        modifies { deformation: Deformation, history: History, volume: Volume }
    }
}

impl<L: Law> Body for Stress<L> {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        const { assert!(fits::<L>(), "a law that declares too much") };
        let (dt, mut work) = (S::splat(io.step[0].size), S::splat(0.0));
        let tiles = io.gradient.iter().zip(io.deformation.iter_mut()).zip(io.stress.iter_mut());
        let scalars = io.initial_volume.iter().zip(io.volume.iter_mut()).zip(io.stiffness.iter_mut());
        for (tile, (((l, f), tau), ((v0, volume), stiffness))) in tiles.zip(scalars).enumerate() {
            let old = load(f);
            let step = increment(&load(l), dt);
            let new = multiply(&step, &old);
            let kinematics = Kinematics { f: new, j: determinant(&new), increment: step };
            let lines = L::HISTORY.len();
            let history = io.history.tile_mut(tile, lines);
            let mut h = [S::splat(0.0); MAX_HISTORY];
            for (h, line) in h.iter_mut().zip(&*history) {
                *h = S::load(line);
            }
            let response = self.0.update(&kinematics, &mut h[..lines]);
            for (h, line) in h.iter().zip(history) {
                // most history rarely changes: what is not written need not go back to memory
                if h.differs(S::load(line)) != 0 {
                    h.store(line);
                }
            }

            let frozen = response.events.frozen;
            for c in 0..9 {
                S::select(frozen, old[c], new[c]).store(&mut f[c]);
            }
            // a frozen particle keeps its volume with its F
            let j = S::select(frozen, S::load(volume), kinematics.j * S::load(v0));
            j.store(volume);
            store(&response.kirchhoff, tau);
            // made anew: kept, it would not stay in registers
            let step = increment(&load(l), dt);
            work = S::load(v0).fnma(backward_work(&response.kirchhoff, &step), work);
            response.modulus.store(stiffness);

            let Events { own, inverted, .. } = response.events;
            let here = at.lanes(tile);
            let mut some = inverted;
            for event in 0..L::EVENTS.len() {
                some |= own[event];
            }
            if some & here != 0 {
                let who = Who { identity: &io.identity[tile], x: &io.position[tile], time: io.step[0].time };
                for event in 0..L::EVENTS.len() {
                    who.meet(own[event] & here, &mut io.first[0][event]);
                }
                who.is_at_fault(inverted & here, fault::INVERTED, kinematics.j.lanes(), &mut io.fault[0]);
            }
        }
        io.work[0].add(work.lanes().iter().sum());
    }
}
