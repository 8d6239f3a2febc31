use crate::labels::{
    ContactWork, NodeMotion, OwnStep, Reactions, RigidImpulse, RigidMotion, RigidSite, RigidTrial,
};
use crate::reactions::Reaction;
use crate::rigid::bodies::{Bodies, Push};
use engine::graph::task::{At, Body};
use physics::contact::{cross, dot};
use simd::Simd;

/// Contact of free rigid bodies, whose motion is found: the matter receives P_s, and they receive −Σ J_sᵀ P_s, to the last bit.
pub struct RigidPush(pub Bodies);

engine::task! { Nodes task RigidPush {
    requires now { step: OwnStep, site: RigidSite, bodies: RigidMotion, trial: RigidTrial }
    computes { on_bodies: RigidImpulse, reactions: Reactions, work: ContactWork }
    modifies { motion: NodeMotion }
}}

impl Body for RigidPush {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let mut pushes = Vec::new();
        self.0.each_push(at, (&io.site, &io.motion), (&io.bodies, &io.trial), |push| pushes.push(push));
        for (number, tool) in self.0.tools.iter().enumerate() {
            let Some(body) = tool.body() else { continue };
            for meeting in &tool.meets {
                let is_here = |push: &&Push<'_>| push.number == number && std::ptr::eq(push.meeting, meeting);
                let mut received = Received::default();
                for push in pushes.iter().filter(is_here) {
                    let motion = &mut io.motion[push.line];
                    let given = push.impulse();
                    motion.add(given.map(|p| p / motion.mass()));
                    // the mean of the body's motion over the tick
                    let (before, after) =
                        (io.bodies[body].velocity_at(push.x), io.trial[body].velocity_at(push.arm));
                    let mean = motion.mean();
                    received.add(push, [0, 1, 2].map(|a| mean[a] - 0.5 * (before[a] + after[a])));
                }
                received.on_body.iter().zip(&mut io.on_bodies[body]).for_each(|(x, sum)| sum.add(*x));
                if let Some((tile, sign)) = meeting.tile {
                    received.on_matter.times(sign).store(&mut io.reactions[tile]);
                }
                io.work[0][0].add(received.friction);
                io.work[0][1].add(received.impact);
            }
        }
    }
}

/// What a body receives from nodes of a block, what contact gives to the matter, and what it takes of the energy.
#[derive(Default)]
struct Received {
    on_body: [f64; 6],
    on_matter: Reaction,
    friction: f64,
    impact: f64,
}

impl Received {
    /// Counts a push where matter slips so fast past the body, in the mean over the tick.
    fn add(&mut self, push: &Push<'_>, slip: [f64; 3]) {
        let given = push.impulse();
        let torque = cross(push.arm, given);
        for a in 0..3 {
            self.on_body[a] -= given[a];
            self.on_body[3 + a] -= torque[a];
        }
        self.on_matter.add(push.x, given, [0.0; 3]);
        self.friction -= dot(push.exchange.friction, slip);
        self.impact -= dot(push.exchange.normal, slip);
    }
}
