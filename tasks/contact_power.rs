use crate::labels::{ContactImpulse, ContactWork, NodeMotion};
use engine::graph::task::{At, Body};
use grid::NODES;
use physics::contact::dot;
use simd::Simd;

engine::task! {
    /// Energy that contact takes: − Σ J · (v⁰ + v)/2 over nodes and materials, with J all impulse of a material's step, v⁰ and v
    /// the velocities at its start and end.
    ///
    /// Measured against the motion of the whole step, because a surface that is merely pressed against another is
    /// pushed in by its stress and back by contact within every step: neither is work.
    pub struct ContactPower;

    Nodes task {
        requires now { impulse: ContactImpulse, motion: NodeMotion }
        computes { work: ContactWork }
    }
}

impl Body for ContactPower {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        if at.fields.len() < 2 {
            return;
        }
        let (mut friction, mut impact) = (0.0, 0.0);
        let fields = io.impulse.chunks_exact(NODES).zip(io.motion.chunks_exact(NODES)).zip(at.fields);
        for ((impulses, motions), _) in fields.filter(|(_, field)| field.ends) {
            for (impulse, motion) in impulses.iter().zip(motions) {
                let mean = motion.mean();
                impact -= dot(impulse.normal(), mean);
                friction -= dot(impulse.friction(), mean);
            }
        }
        io.work[0][0].add(friction);
        io.work[0][1].add(impact);
    }
}
