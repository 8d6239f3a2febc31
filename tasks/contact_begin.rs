use crate::data::labels::{ContactImpulse, NodeMotion};
use crate::graph::task::{At, Body};
use crate::simd::{Simd, Wide};

/// No impulse yet in this step.
pub struct ContactBegin;

crate::task! { Nodes task ContactBegin {
    requires new { motion: NodeMotion }
    computes { impulse: ContactImpulse }
}}

impl Body for ContactBegin {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        if at.present.len() > 1 {
            io.impulse[..io.motion.len()].fill(Wide::default());
        }
    }
}
