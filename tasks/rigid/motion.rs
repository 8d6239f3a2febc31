use crate::labels::RigidMotion as RigidMotionLabel;
use crate::labels::{OwnStep, Reactions, RigidImpulse, RigidTrial, Time};
use crate::reactions::Reaction;
use crate::rigid::rotation::{momentum, turn, turn_locked};
use crate::rigid::state::{RigidState, RigidTrial as Trial};
use engine::graph::task::{At, Body};
use nalgebra::Vector3;
use simd::Simd;

engine::task! {
    /// Newton and Euler for free rigid bodies: loads and what contact gives change V and ω, and all moves on.
    pub struct RigidMotion {
        /// The axes along which each material does not move, and about which it does not turn.
        pub locked: Vec<[bool; 6]>,
        /// The tile of `Reactions` of gravity and damping.
        pub loads: Option<usize>,
        /// Those of what pushes and locks bodies, by material.
        pub locks: Vec<Option<usize>>,
    }

    Once task {
        requires now { time: Time, step: OwnStep, trial: RigidTrial, impulse: RigidImpulse }
        computes { reactions: Reactions }
        modifies { bodies: RigidMotionLabel }
    }
}

impl Body for RigidMotion {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let dt = io.time[0].tick;
        for (material, body) in io.bodies.iter_mut().enumerate().filter(|(_, body)| body.free != 0.0) {
            let received = io.impulse[material].each_ref().map(|sum| sum.value());
            let (loads, lock) = self.advance(material, body, &io.trial[material], received, dt);
            if let Some(tile) = self.loads {
                loads.store(&mut io.reactions[tile]);
            }
            if let Some(tile) = self.locks[material] {
                lock.store(&mut io.reactions[tile]);
            }
        }
    }
}

impl RigidMotion {
    /// Moves a body on that contact gives an impulse [N s] and torque impulse about its center [N m s]. What loads, and what its force and its locks give.
    fn advance(
        &self,
        material: usize,
        body: &mut RigidState,
        trial: &Trial,
        received: [f64; 6],
        dt: f64,
    ) -> (Reaction, Reaction) {
        let (locked, before, center) = (self.locked[material], *body, body.center);
        let by_contact = Vector3::new(received[3], received[4], received[5]);
        let l = momentum(&RigidState { angular: [3, 4, 5].map(|a| trial.start[a]), ..before }) + by_contact;
        for a in 0..3 {
            body.velocity[a] = trial.start[a] + if locked[a] { 0.0 } else { received[a] / body.mass };
        }
        match [locked[3], locked[4], locked[5]] {
            [false, false, false] => turn(body, l, dt),
            turns => turn_locked(body, l, dt, turns),
        }
        (0..3).for_each(|a| body.center[a] += dt * body.velocity[a]);
        let (mut loads, mut lock) = (Reaction::default(), Reaction::default());
        let mean: [f64; 3] = std::array::from_fn(|a| 0.5 * (before.velocity[a] + body.velocity[a]));
        let gained = |a: usize| trial.start[a] + trial.held[a] - before.velocity[a];
        loads.add(center, std::array::from_fn(|a| body.mass * gained(a) - trial.push[a]), mean);
        lock.add(center, trial.push, mean);
        let held = |a: usize| if locked[a] { -received[a] - body.mass * trial.held[a] } else { 0.0 };
        lock.add(center, std::array::from_fn(held), [0.0; 3]);
        let (first, last) = (momentum(&before), momentum(body));
        for a in 0..3 {
            // damping turns all of L alike; what is left, the lock gives
            let damped = l[a] - by_contact[a] - first[a];
            loads.torque[a] += damped;
            loads.work += 0.5 * damped * (before.angular[a] + body.angular[a]);
            lock.torque[a] += last[a] - l[a];
        }
        (loads, lock)
    }
}
