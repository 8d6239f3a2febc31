use crate::bonds::bonded_to;
use crate::labels::{
    ContactWork, NodeMotion, OwnStep, Reactions, RigidImpulse, RigidMotion, RigidSite, RigidTrial,
};
use crate::node::{Impulse, Motion, Site};
use crate::reactions::{NUMBERS, Reaction};
use crate::rigid::bodies::{Bodies, Push, held};
use crate::rigid::state::{RigidState, RigidTrial as Trial};
use engine::data::exact_sum::ExactSum;
use engine::graph::task::{At, Body};
use physics::contact::{cross, dot};
use simd::Simd;

engine::task! {
    /// Contact of free rigid bodies, whose motion is found: the matter receives P_s, and they receive −Σ J_sᵀ P_s, to the last bit.
    pub struct RigidPush(pub Bodies);

    Nodes task {
        requires now { step: OwnStep, site: RigidSite, bodies: RigidMotion, trial: RigidTrial }
        computes { on_bodies: RigidImpulse, reactions: Reactions, work: ContactWork }
        modifies { motion: NodeMotion }
    }
}

impl Body for RigidPush {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let Io { site, bodies, trial, on_bodies, reactions, work, motion, .. } = &mut io;
        let given = Given { on_bodies, reactions, work: &mut work[0] };
        self.0.give(at, (site, motion), (bodies, trial), &[], given);
    }
}

pub use bonded::BondedPush;

mod bonded {
    use super::*;
    use crate::labels::ContactImpulse;

    engine::task! {
        /// As `RigidPush`, where bonds make one of several materials: what is one moves together.
        pub struct BondedPush(pub Bodies);

        Nodes task {
            requires now { step: OwnStep, site: RigidSite, bodies: RigidMotion, trial: RigidTrial, one: ContactImpulse }
            computes { on_bodies: RigidImpulse, reactions: Reactions, work: ContactWork }
            modifies { motion: NodeMotion }
        }
    }

    impl Body for BondedPush {
        #[inline(always)]
        fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
            let Io { site, bodies, trial, one, on_bodies, reactions, work, motion, .. } = &mut io;
            let given = Given { on_bodies, reactions, work: &mut work[0] };
            self.0.give(at, (site, motion), (bodies, trial), one, given);
        }
    }
}

/// Where what is given is counted.
struct Given<'a> {
    on_bodies: &'a mut [[ExactSum; 6]],
    reactions: &'a mut [[ExactSum; NUMBERS]],
    work: &'a mut [ExactSum; 2],
}

impl Bodies {
    /// Gives what the bodies give to the nodes of a block.
    fn give(
        &self,
        at: &At<'_>,
        (sites, motions): (&[Site], &mut [Motion]),
        (states, trials): (&[RigidState], &[Trial]),
        one: &[Impulse],
        to: Given<'_>,
    ) {
        let mut pushes = Vec::new();
        self.each_push(at, (sites, &*motions), (states, trials), one, |push| pushes.push(push));
        // first all move, and then each is accounted with the motion that all make
        for push in &pushes {
            // of what is held, drives take it at the end of its step
            let dv = push.impulse().map(|p| p / push.mass);
            bonded_to(one, at.fields.len(), push.line).for_each(|other| motions[other].add(dv));
            motions[push.line].add(dv);
        }
        for (number, tool) in self.tools.iter().enumerate() {
            let Some(body) = tool.body() else { continue };
            for meeting in &tool.meets {
                let is_here = |push: &&Push<'_>| push.number == number && std::ptr::eq(push.meeting, meeting);
                let mut received = Received::default();
                for push in pushes.iter().filter(is_here) {
                    // the mean of the body's motion over the tick
                    let (before, after) =
                        (states[body].velocity_at(push.x), trials[body].velocity_at(push.arm));
                    let (motion, lines) = (&motions[push.line], bonded_to(one, at.fields.len(), push.line));
                    let (start, held) = (motion.start(), held(sites, lines.chain([push.line])));
                    let mean =
                        held.map_or(motion.mean(), |v| std::array::from_fn(|a| 0.5 * (start[a] + v[a])));
                    received.add(push, [0, 1, 2].map(|a| mean[a] - 0.5 * (before[a] + after[a])));
                }
                received.on_body.iter().zip(&mut to.on_bodies[body]).for_each(|(x, sum)| sum.add(*x));
                if let Some((tile, sign)) = meeting.tile {
                    received.on_matter.times(sign).store(&mut to.reactions[tile]);
                }
                to.work[0].add(received.friction);
                to.work[1].add(received.impact);
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
