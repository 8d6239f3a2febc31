use crate::labels::{Bond, ContactFlow as ContactFlowLabel, Mass, Position, Volume};
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// As `ContactFlow`, with m_p b_p of a material whose bonds may break.
    pub struct BondFlow;

    NearParticles task {
        requires old { mass: Mass, position: Position, volume: Volume, bond: Bond }
        computes { flow: ContactFlowLabel }
    }
}

impl Body for BondFlow {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let particles = io.mass.iter().zip(io.position.iter()).zip(io.volume.iter()).zip(io.bond.iter());
        for ((((mass, x), volume), bond), flow) in particles.zip(io.flow.iter_mut()) {
            let m = S::load(mass);
            flow[0] = *mass;
            for axis in 0..3 {
                (m * S::load(&x[axis])).store(&mut flow[1 + axis]);
            }
            flow[4] = *volume;
            (m * S::load(bond)).store(&mut flow[5]);
        }
    }
}
