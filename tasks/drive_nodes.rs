use crate::labels::{DriveGift, DriveSums, NodeMotion, NodeSums, OwnStep};
use crate::node::Gift;
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

/// v_I = P_I / M_I along driven axes, on all nodes that driven particles touch noticeably, at the end of a material's step: a
/// condition of Dirichlet, so that what is next to a grip is strained by the whole of its motion. What that takes is told to the
/// particles of the drives.
pub struct DriveNodes;

/// Of a node's mass; a grip that holds less of it does not hold the node.
const LEAST: f64 = 1e-9;

engine::task! { Nodes task DriveNodes {
    requires new { step: OwnStep, sums: NodeSums }
    requires now { driven: DriveSums }
    computes { gift: DriveGift }
    modifies { motion: NodeMotion }
}}

impl Body for DriveNodes {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let sums = io.sums.chunks_exact(NODES).zip(io.driven.chunks_exact(NODES));
        let motions = io.motion.chunks_exact_mut(NODES).zip(io.gift.chunks_exact_mut(NODES));
        for (((sums, driven), (motions, gifts)), _) in
            sums.zip(motions).zip(at.fields).filter(|(_, f)| f.ends)
        {
            let nodes = sums.iter().zip(driven).zip(motions.iter_mut().zip(gifts));
            for ((sum, driven), (motion, gift)) in nodes {
                let (mass, momentum) = (driven.mass(), driven.momentum());
                if mass == [0.0; 3] {
                    *gift = Gift::default();
                    continue;
                }
                let (m, v) = (sum.mass(), motion.velocity());
                let held = [0, 1, 2].map(|a| mass[a] > LEAST * m);
                let dv = [0, 1, 2].map(|a| if held[a] { momentum[a] / mass[a] - v[a] } else { 0.0 });
                motion.add(dv);
                let share = [0, 1, 2].map(|a| if held[a] { m * dv[a] / mass[a] } else { 0.0 });
                *gift = Gift::new(share, motion.mean());
            }
        }
    }
}
