use crate::labels::{DriveGift, DriveSums, NodeMotion, OwnStep};
use crate::node::Gift;
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

engine::task! {
    /// Moves all nodes that driven particles touch noticeably as their drives say, along driven axes, at the end of a material's step:
    /// v_I = P_I / M_I. It is a condition of Dirichlet, so that what is next to a grip is strained by the whole of its motion. What that takes is
    /// told to the particles of the drives.
    pub struct DriveNodes;

    Nodes task {
        requires now { step: OwnStep, driven: DriveSums }
        computes { gift: DriveGift }
        modifies { motion: NodeMotion }
    }
}

impl Body for DriveNodes {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let motions = io.motion.chunks_exact_mut(NODES).zip(io.gift.chunks_exact_mut(NODES));
        let fields = io.driven.chunks_exact(NODES).zip(motions).zip(at.fields);
        for ((driven, (motions, gifts)), _) in fields.filter(|(_, field)| field.ends) {
            for (driven, (motion, gift)) in driven.iter().zip(motions.iter_mut().zip(gifts)) {
                let mass = driven.mass();
                if mass == [0.0; 3] {
                    *gift = Gift::default();
                    continue;
                }
                let (m, v) = (motion.mass(), motion.velocity());
                let held = [0, 1, 2].map(|a| driven.velocity(a, m));
                let dv = [0, 1, 2].map(|a| held[a].map_or(0.0, |to| to - v[a]));
                motion.add(dv);
                let share = [0, 1, 2].map(|a| held[a].map_or(0.0, |_| m * dv[a] / mass[a]));
                *gift = Gift::new(share, motion.mean());
            }
        }
    }
}
