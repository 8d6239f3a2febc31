use crate::labels::{ContactImpulse, NodeMotion};
use crate::node::Impulse;
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

engine::task! {
    /// Sets the impulse of contact to zero where a step begins.
    pub struct ContactBegin;

    Nodes task {
        requires new { motion: NodeMotion }
        computes { impulse: ContactImpulse }
    }
}

impl Body for ContactBegin {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let fields = io.impulse.chunks_exact_mut(NODES).zip(at.fields);
        fields.filter(|(_, field)| field.begins).for_each(|(impulse, _)| impulse.fill(Impulse::default()));
    }
}
