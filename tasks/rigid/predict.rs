use crate::labels::{RigidMotion, RigidTrial, Time};
use crate::loads::LoadField;
use crate::rigid::rotation::{momentum, spin_of};
use engine::graph::task::{At, Body};
use physics::table::Table;
use simd::Simd;

engine::task! {
    /// Predicts the motion of free rigid bodies at the end of a tick, if nothing touches them: U* with V* = e^(−αΔt) V + ψ (g + F/M), ω* from
    /// e^(−αΔt) L.
    pub struct RigidPredict {
        /// Gravity and damping.
        pub field: LoadField,
        /// For each material: the axes along which it does not move, and about which it does not turn.
        pub locked: Vec<[bool; 6]>,
        /// And the force on it in time [N].
        pub forces: Vec<Table>,
    }

    Once task {
        requires new { time: Time }
        requires now { bodies: RigidMotion }
        computes { trial: RigidTrial }
    }
}

impl Body for RigidPredict {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let (time, dt) = (io.time[0].time, io.time[0].tick);
        let (g, worth) = (self.field.mean_gravity(time, dt), self.field.worth(dt));
        let faded = (-self.field.damping * dt).exp_m1();
        for (material, (body, trial)) in io.bodies.iter().zip(io.trial.iter_mut()).enumerate() {
            let locked = self.locked[material];
            if body.free == 0.0 {
                continue;
            }
            trial.push = self.forces[material].mean(time, dt).map(|f| worth * f);
            let w = spin_of(body, (1.0 + faded) * momentum(body), [locked[3], locked[4], locked[5]]);
            for a in 0..3 {
                let v =
                    body.velocity[a] + faded * body.velocity[a] + worth * g[a] + trial.push[a] / body.mass;
                trial.held[a] = if locked[a] { v } else { 0.0 };
                (trial.start[a], trial.start[3 + a]) = (v - trial.held[a], w[a]);
            }
            (trial.now, trial.rounds) = (trial.start, 0.0);
        }
    }
}
