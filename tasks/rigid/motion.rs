use crate::labels::RigidMotion as RigidMotionLabel;
use crate::labels::{Reactions, RigidImpulse, Time};
use crate::loads::LoadField;
use crate::reactions::Reaction;
use crate::rigid::rotation::{momentum, turn};
use crate::rigid::state::RigidState;
use engine::graph::task::{At, Body};
use nalgebra::{Matrix3, Vector3};
use simd::Simd;

/// Newton and Euler for rigid bodies: contact impulses and gravity change V and ω of those that are free; all move.
/// Where nothing touches, there is no impulse.
pub struct RigidMotion {
    /// Gravity and damping.
    pub field: LoadField,
    /// The tile of `Reactions` of gravity and damping.
    pub loads: Option<usize>,
}

engine::task! { Once task RigidMotion {
    requires new { time: Time }
    requires now { impulse: RigidImpulse }
    computes { reactions: Reactions }
    modifies { bodies: RigidMotionLabel }
}}

impl Body for RigidMotion {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let (time, dt) = (io.time[0].time, io.time[0].tick);
        for (material, body) in io.bodies.iter_mut().enumerate().filter(|(_, b)| b.mass > 0.0) {
            if body.free == 0.0 {
                turn_by(body, dt);
            } else {
                let sums = io.impulse[material].each_ref().map(|sum| sum.value());
                let torque = Vector3::new(sums[3], sums[4], sums[5]);
                (0..3).for_each(|a| body.velocity[a] += sums[a] / body.mass);
                let before = body.velocity;
                let (g, worth) = (self.field.mean_gravity(time, dt), self.field.worth(dt));
                let faded = (-self.field.damping * dt).exp_m1();
                let dv: [f64; 3] = std::array::from_fn(|a| faded * before[a] + worth * g[a]);
                (0..3).for_each(|a| body.velocity[a] += dv[a]);
                let l = (1.0 + faded) * (momentum(body) + torque);
                turn(body, l, dt);
                let mean = std::array::from_fn(|a| 0.5 * (before[a] + body.velocity[a]));
                let mut reaction = Reaction::default();
                reaction.add(body.center, dv.map(|dv| body.mass * dv), mean);
                if let Some(tile) = self.loads {
                    reaction.store(&mut io.reactions[tile]);
                }
            }
            (0..3).for_each(|a| body.center[a] += dt * body.velocity[a]);
        }
    }
}

/// R ← R e^(ω Δt): a prescribed body turns by what its angular velocity says.
fn turn_by(body: &mut RigidState, dt: f64) {
    let step = Matrix3::from_row_slice(&physics::motion::rotation(body.angular.map(|w| w * dt)));
    let rotation = step * Matrix3::from_row_slice(&body.rotation);
    body.rotation = std::array::from_fn(|n| rotation[(n / 3, n % 3)]);
}
