use crate::labels::{RigidBalance, RigidMotion, RigidSolved, RigidTrial};
use crate::rigid::newton::{Balance, seek};
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// Corrects the motion that is sought for each free rigid body by a step of Newton's method.
    pub struct RigidSolve {
        /// For each material: the axes along which it does not move, and about which it does not turn.
        pub locked: Vec<[bool; 6]>,
    }

    Once task {
        requires now { bodies: RigidMotion, balance: RigidBalance }
        computes { solved: RigidSolved }
        modifies { trial: RigidTrial }
    }
}

impl Body for RigidSolve {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let mut all = true;
        for (material, (body, trial)) in io.bodies.iter().zip(io.trial.iter_mut()).enumerate() {
            if body.free != 0.0 {
                let balance = Balance(io.balance[material].each_ref().map(|sum| sum.value()));
                all &= seek(body, trial, &balance, self.locked[material]);
            }
        }
        io.solved[0].0[0] = f64::from(u8::from(all));
    }
}
