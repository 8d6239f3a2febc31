use crate::labels::RigidMotion as RigidMotionLabel;
use crate::labels::{Reactions, RigidImpulse, Time};
use crate::loads::LoadField;
use crate::reactions::Reaction;
use crate::rigid::state::RigidState;
use engine::graph::task::{At, Body};
use nalgebra::{Matrix3, Rotation3, Vector3};
use physics::contact::{cross, dot};
use simd::Simd;

/// Newton and Euler for rigid bodies: contact impulses and gravity change V and ω of those that are free; all move.
/// Where nothing touches, there is no impulse.
pub struct RigidMotion {
    /// Gravity and damping.
    pub field: LoadField,
    /// Tiles of `Reactions`: of what holds each prescribed body, and of gravity.
    pub tiles: Vec<Option<usize>>,
    /// See `tiles`.
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
            let sums = io.impulse[material].each_ref().map(|sum| sum.value());
            if body.free == 0.0 {
                // whatever holds the body on its way receives what the matter exchanges with it
                let reaction = held(body, &sums);
                if let Some(tile) = self.tiles[material] {
                    reaction.store(&mut io.reactions[tile]);
                }
            } else {
                push(body, Vector3::new(sums[0], sums[1], sums[2]), Vector3::new(sums[3], sums[4], sums[5]));
                let before = body.velocity;
                let (g, worth) = (self.field.mean_gravity(time, dt), self.field.worth(dt));
                let faded = (-self.field.damping * dt).exp_m1();
                let dv: [f64; 3] = std::array::from_fn(|a| faded * before[a] + worth * g[a]);
                for a in 0..3 {
                    body.velocity[a] += dv[a];
                    body.angular[a] *= 1.0 + faded;
                }
                let mean = std::array::from_fn(|a| 0.5 * (before[a] + body.velocity[a]));
                let mut reaction = Reaction::default();
                reaction.add(body.center, dv.map(|dv| body.mass * dv), mean);
                if let Some(tile) = self.loads {
                    reaction.store(&mut io.reactions[tile]);
                }
            }
            turn(body, dt);
            (0..3).for_each(|a| body.center[a] += dt * body.velocity[a]);
        }
    }
}

/// What a prescribed body gives to the matter, where it receives these sums: impulse, and torque about its center.
fn held(body: &RigidState, sums: &[f64; 6]) -> Reaction {
    let [x, y, z, tx, ty, tz] = sums.map(|sum| -sum);
    let (impulse, torque) = ([x, y, z], [tx, ty, tz]);
    let about_origin = cross(body.center, impulse);
    Reaction {
        impulse,
        torque: std::array::from_fn(|a| about_origin[a] + torque[a]),
        work: dot(impulse, body.velocity) + dot(torque, body.angular),
    }
}

/// R I R⁻¹: the inertia tensor about the center in the present orientation.
fn inertia(body: &RigidState) -> Matrix3<f64> {
    let rotation = Matrix3::from_row_slice(&body.rotation);
    rotation * Matrix3::from_row_slice(&body.inertia) * rotation.transpose()
}

/// V += P/M, ω += I⁻¹ L.
fn push(body: &mut RigidState, impulse: Vector3<f64>, torque: Vector3<f64>) {
    let turn = inertia(body).try_inverse().map_or(Vector3::zeros(), |inverse| inverse * torque);
    for a in 0..3 {
        body.velocity[a] += impulse[a] / body.mass;
        body.angular[a] += turn[a];
    }
}

/// Turns the body by ω Δt; a free body keeps its angular momentum while its inertia turns.
fn turn(body: &mut RigidState, dt: f64) {
    let omega = Vector3::from(body.angular);
    let momentum = inertia(body) * omega;
    let rotation = Rotation3::new(omega * dt).matrix() * Matrix3::from_row_slice(&body.rotation);
    body.rotation = std::array::from_fn(|n| rotation[(n / 3, n % 3)]);
    if body.free > 0.0
        && let Some(inverse) = inertia(body).try_inverse()
    {
        body.angular = (inverse * momentum).into();
    }
}
