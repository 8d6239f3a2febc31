use super::loads::LoadField;
use super::work::Work;
use crate::labels::{BoundaryWork, NodeMotion, NodeSums, OwnStep};
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

/// Work of gravity and damping, with the mean velocity of the whole step (see `ContactPower`).
pub struct LoadPower {
    /// What acts.
    pub field: LoadField,
    /// Mass below which a node carries nothing [kg].
    pub least_mass: f64,
    /// Which materials are rigid: they take their loads as a whole.
    pub rigid: Vec<bool>,
}

engine::task! { Nodes task LoadPower {
    requires new { step: OwnStep, sums: NodeSums, motion: NodeMotion }
    computes { work: BoundaryWork }
}}

impl Body for LoadPower {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let mut work = Work::default();
        let fields = io.sums.chunks_exact(NODES).zip(io.motion.chunks_exact(NODES)).zip(at.fields);
        for ((sums, motions), field) in fields.filter(|(_, f)| f.ends && !self.rigid[f.material]) {
            for (sum, motion) in sums.iter().zip(motions).filter(|(sum, _)| sum.mass() > self.least_mass) {
                work.add(sum.mass(), motion.mean(), self.field.change(motion, field.step));
            }
        }
        work.store(&mut io.work[0]);
    }
}
