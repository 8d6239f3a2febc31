use crate::labels::{Mass, MassFlow as MassFlowLabel, Velocity};
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// What particles give to grid nodes by their weights: mass and momentum, m_I = Σ_p S_Ip m_p and (mv)_I = Σ_p S_Ip m_p v_p. These are the
    /// factors of S_Ip.
    pub struct MassFlow;

    Particles task {
        requires old { mass: Mass, velocity: Velocity }
        computes { flow: MassFlowLabel }
    }
}

impl Body for MassFlow {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        for ((mass, v), flow) in io.mass.iter().zip(io.velocity.iter()).zip(io.flow.iter_mut()) {
            let m = S::load(mass);
            m.store(&mut flow[0]);
            for axis in 0..3 {
                (m * S::load(&v[axis])).store(&mut flow[1 + axis]);
            }
        }
    }
}
