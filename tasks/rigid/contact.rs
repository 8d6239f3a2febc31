use crate::contact::{Contact, Meeting};
use crate::labels::{
    ContactImpulse, ContactSums, NodeMotion, NodeSums, Reactions, RigidImpulse, RigidMotion,
};
use engine::graph::task::{At, Body};
use simd::Simd;

/// Contact where some materials are rigid: they take their part of the impulses as a whole.
pub struct RigidContact(pub Contact);

engine::task! { Nodes task RigidContact {
    requires new { sums: NodeSums, surfaces: ContactSums }
    requires now { bodies: RigidMotion }
    computes { on_bodies: RigidImpulse, reactions: Reactions }
    modifies { motion: NodeMotion, impulse: ContactImpulse }
}}

impl Body for RigidContact {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let Io { sums, surfaces, motion, impulse, bodies, on_bodies, reactions } = &mut io;
        let mut meeting = Meeting { sums, surfaces, motion, impulse, reactions, bodies, on_bodies };
        self.0.exchange_all(at, &mut meeting);
    }
}
