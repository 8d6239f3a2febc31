use crate::labels::{ContactFlow as ContactFlowLabel, Mass, Position, Volume};
use engine::graph::task::{At, Body};
use simd::{Simd, Wide};

engine::task! {
    /// What contact needs to know of a surface: (mx)_I = Σ_p S_Ip m_p x_p, with m_I, and g_I = Σ_p V_p ∇S_Ip.
    pub struct ContactFlow;

    NearParticles task {
        requires old { mass: Mass, position: Position, volume: Volume }
        computes { flow: ContactFlowLabel }
    }
}

impl Body for ContactFlow {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let particles = io.mass.iter().zip(io.position.iter()).zip(io.volume.iter());
        for (((mass, x), volume), flow) in particles.zip(io.flow.iter_mut()) {
            let m = S::load(mass);
            flow[0] = *mass;
            for axis in 0..3 {
                (m * S::load(&x[axis])).store(&mut flow[1 + axis]);
            }
            flow[4] = *volume;
            flow[5] = Wide::default();
        }
    }
}
