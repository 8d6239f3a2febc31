use crate::labels::RigidMotion as RigidMotionLabel;
use crate::labels::Time;
use crate::rigid::rotation::turn_by;
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// Prescribed rigid bodies go where they should: X_c ← X_c + Δt V, R ← e^(ω Δt) R.
    pub struct RigidCarry;

    Once task {
        requires now { time: Time }
        modifies { bodies: RigidMotionLabel }
    }
}

impl Body for RigidCarry {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let dt = io.time[0].tick;
        for body in io.bodies.iter_mut().filter(|body| body.mass > 0.0 && body.free == 0.0) {
            turn_by(body, dt);
            (0..3).for_each(|a| body.center[a] += dt * body.velocity[a]);
        }
    }
}
