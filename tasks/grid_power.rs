use crate::labels::{NodeMotion, OwnStep, TransferLoss};
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

engine::task! {
    /// The kinetic energy that the nodes gain in the step, Σ_I m_I Δv_I · (v⁰_I + v_I)/2. Particles do not gain all of it:
    /// `Advance` takes what they gain away, and what is left is the loss of the transfer.
    pub struct GridPower;

    Nodes task {
        requires now { step: OwnStep, motion: NodeMotion }
        computes { loss: TransferLoss }
    }
}

impl Body for GridPower {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let (half, mut power) = (S::splat(0.5), S::splat(0.0));
        let fields = io.motion.chunks_exact(NODES).zip(at.fields);
        for (motions, _) in fields.filter(|(_, field)| field.ends) {
            for motion in motions {
                // lanes 0 to 2: m Δv · (v − Δv/2)
                let velocity = S::load(&motion.0);
                let change = velocity.swap_halves();
                let mean = half.fnma(change, velocity);
                power = (S::splat(motion.mass()) * change).fma(mean, power);
            }
        }
        io.loss[0].add(power.lanes()[..3].iter().sum());
    }
}
