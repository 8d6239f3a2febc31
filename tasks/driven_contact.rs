use crate::contact::{Contact, Meeting};
use crate::labels::{ContactImpulse, ContactSums, DriveSums, NodeMotion, NodeSums, Reactions};
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// Contact of pairs of materials, as in `Contact`, where drives hold some of what meets: that goes as they say, whatever it receives.
    pub struct DrivenContact(pub Contact);

    Nodes task {
        requires new { sums: NodeSums, surfaces: ContactSums }
        requires now { driven: DriveSums }
        computes { reactions: Reactions }
        modifies { motion: NodeMotion, impulse: ContactImpulse }
    }
}

impl Body for DrivenContact {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let Io { sums, surfaces, driven, motion, impulse, reactions } = &mut io;
        let mut meeting = Meeting { sums, surfaces, driven, motion, impulse, reactions };
        self.0.exchange_all(at, &mut meeting);
    }
}
