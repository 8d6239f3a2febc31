use crate::data::labels::{ContactImpulse, ContactSums, NodeMotion, NodeSums, RigidImpulse, RigidMotion};
use crate::graph::task::{At, Body};
use crate::simd::Simd;
use crate::tasks::contact::{Contact, Meeting};

/// Contact where some materials are rigid: they take their part of the impulses as a whole.
pub struct RigidContact(pub Contact);

crate::task! { Nodes task RigidContact {
    requires old { bodies: RigidMotion }
    requires new { sums: NodeSums, surfaces: ContactSums }
    computes { on_bodies: RigidImpulse }
    modifies { motion: NodeMotion, impulse: ContactImpulse }
}}

impl Body for RigidContact {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let Io { sums, surfaces, motion, impulse, bodies, on_bodies } = &mut io;
        self.0.exchange_all(at, &mut Meeting { sums, surfaces, motion, impulse, bodies, on_bodies });
    }
}
