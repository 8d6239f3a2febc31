use crate::labels::DriveSums;
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// Adds up what blocks of driven particles give to grid nodes, M_I and P_I, for a graph that comes later in the step.
    pub struct DriveSum;

    Nodes task {
        modifies { driven: DriveSums }
    }
}

impl Body for DriveSum {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, _io: Io<'_>) {}
}
