use crate::labels::DriveSums;
use engine::graph::task::{At, Body};
use simd::Simd;

/// Σ of what blocks give to M_I and P_I, for a graph that comes later in the step: the sum is all that is done.
pub struct DriveSum;

engine::task! { Nodes task DriveSum {
    modifies { driven: DriveSums }
}}

impl Body for DriveSum {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, _io: Io<'_>) {}
}
