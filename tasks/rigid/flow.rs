use crate::labels::{Mass, MassFlow, StressFlow, Velocity, Volume};
use engine::graph::task::{At, Body};
use simd::{Simd, Wide};

/// What a rigid body's particles distribute: mass, momentum and volume, no stress.
pub struct RigidFlow;

engine::task! { Particles task RigidFlow {
    requires old { mass: Mass, velocity: Velocity, volume: Volume }
    computes { mass_flow: MassFlow, stress_flow: StressFlow }
}}

impl Body for RigidFlow {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let particles = io.mass.iter().zip(io.velocity.iter()).zip(io.volume.iter());
        let flows = io.mass_flow.iter_mut().zip(io.stress_flow.iter_mut());
        for (((mass, v), volume), (mass_flow, stress_flow)) in particles.zip(flows) {
            let m = S::load(mass);
            let momentum = v.each_ref().map(|v| m * S::load(v));
            mass_flow[0] = *mass;
            momentum.iter().zip(&mut mass_flow[1..]).for_each(|(p, line)| p.store(line));
            stress_flow[..6].fill(Wide::default());
            stress_flow[6] = *volume;
        }
    }
}
