use crate::fault::{self, Who};
use crate::labels::{
    Fault, Identity, InitialVolume, Mass, Position, SignalSpeed as SignalSpeedLabel, StiffnessBound, Velocity,
};
use engine::graph::task::{At, Body};
use simd::{Simd, load, store};

engine::task! {
    /// The largest speeds in a material, which limit the next step: max_p of c + |v|, of c and of |v|, with ρ₀ c² from the law's bound.
    pub struct SignalSpeed;

    Particles task {
        requires old { mass: Mass, initial_volume: InitialVolume, identity: Identity }
        requires new { stiffness: StiffnessBound }
        requires now { velocity: Velocity, position: Position }
        computes { speed: SignalSpeedLabel, fault: Fault }
    }
}

impl Body for SignalSpeed {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let (zero, tiny) = (S::splat(0.0), S::splat(f64::MIN_POSITIVE));
        let mut largest = load::<S, 3>(&io.speed[0]);
        let scalars = io.mass.iter().zip(io.initial_volume.iter()).zip(io.stiffness.iter());
        for (tile, (((m, v0), stiffness), v)) in scalars.zip(io.velocity.iter()).enumerate() {
            let c = (S::load(stiffness) * S::load(v0) / S::load(m).max(tiny)).sqrt();
            let [x, y, z] = load::<S, 3>(v);
            let v = x.fma(x, y.fma(y, z * z)).sqrt();
            let speed = c + v;
            let finite = speed.lt(S::splat(f64::INFINITY));
            let here = at.lanes(tile);
            for (largest, speed) in largest.iter_mut().zip([speed, c, v]) {
                *largest = largest.max(S::select(finite & here, speed, zero));
            }
            if !finite & here != 0 {
                let who = Who { identity: &io.identity[tile], x: &io.position[tile], time: 0.0 };
                who.is_at_fault(!finite & here, fault::NOT_FINITE, speed.lanes(), &mut io.fault[0]);
            }
        }
        store(&largest, &mut io.speed[0]);
    }
}
