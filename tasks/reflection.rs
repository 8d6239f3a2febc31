use crate::labels::Reactions;
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// Opens the account of what faces give to particles that are put back into the domain at the end of a tick.
    pub struct Reflection;

    Once task {
        computes { reactions: Reactions }
    }
}

impl Body for Reflection {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, _io: Io<'_>) {}
}
