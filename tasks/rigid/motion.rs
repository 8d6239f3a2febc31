use crate::labels::RigidMotion as RigidMotionLabel;
use crate::labels::{Reactions, RigidImpulse, Time};
use crate::loads::LoadField;
use crate::reactions::Reaction;
use crate::rigid::rotation::{momentum, turn, turn_by, turn_locked};
use engine::graph::task::{At, Body};
use nalgebra::Vector3;
use simd::Simd;

/// Newton and Euler for rigid bodies: contact impulses and gravity change V and ω of those that are free; all move.
/// Where nothing touches, there is no impulse.
pub struct RigidMotion {
    /// Gravity and damping.
    pub field: LoadField,
    /// For each material: the axes along which it does not move, and about which it does not turn.
    pub locked: Vec<([bool; 3], [bool; 3])>,
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
                let whole = momentum(body) + torque;
                let l = (1.0 + faded) * whole;
                let (fixed, locked) = self.locked[material];
                (0..3).filter(|&a| fixed[a]).for_each(|a| body.velocity[a] = 0.0);
                match locked {
                    [false, false, false] => turn(body, l, dt),
                    _ => turn_locked(body, l, dt, locked),
                }
                let mean = std::array::from_fn(|a| 0.5 * (before[a] + body.velocity[a]));
                let mut reaction = Reaction::default();
                reaction.add(body.center, dv.map(|dv| body.mass * dv), mean);
                for a in 0..3 {
                    // ω is in proportion to L: its mean, from what the damping has left
                    reaction.torque[a] += faded * whole[a];
                    reaction.work += faded * whole[a] * body.angular[a] * (1.0 + 0.5 * faded) / (1.0 + faded);
                }
                if let Some(tile) = self.loads {
                    reaction.store(&mut io.reactions[tile]);
                }
            }
            (0..3).for_each(|a| body.center[a] += dt * body.velocity[a]);
        }
    }
}
