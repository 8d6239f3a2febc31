use super::integrate::change;
use super::work::Work;
use crate::data::labels::{BoundaryWork, NodeMotion, NodeSums, Time};
use crate::data::nodes::NODES;
use crate::graph::task::{At, Body};
use crate::simd::Simd;

/// v_I ← v_I + Δt (g − α v_I): gravity, and damping in proportion to mass.
pub struct Loads {
    /// g [m/s²]
    pub gravity: [f64; 3],
    /// α [1/s]
    pub damping: f64,
    /// Mass below which a node carries nothing [kg].
    pub least_mass: f64,
    /// Which materials are rigid: they take their loads as a whole.
    pub rigid: Vec<bool>,
}

crate::task! { Nodes task Loads {
    requires new { time: Time, sums: NodeSums }
    computes { work: BoundaryWork }
    modifies { motion: NodeMotion }
}}

impl Body for Loads {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let dt = io.time[0].step;
        let mut work = Work::default();
        let fields = io.sums.chunks_exact(NODES).zip(io.motion.chunks_exact_mut(NODES));
        let deformable = |m: &u8| !self.rigid[*m as usize];
        for ((sums, motions), _) in fields.zip(at.present).filter(|(_, m)| deformable(m)) {
            for (sum, motion) in sums.iter().zip(motions).filter(|(sum, _)| sum.0[0] > self.least_mass) {
                let v = [motion.0[0], motion.0[1], motion.0[2]];
                let dv = std::array::from_fn(|a| dt * (self.gravity[a] - self.damping * v[a]));
                work.add(sum.0[0], std::array::from_fn(|a| v[a] + 0.5 * dv[a]), dv);
                change(motion, dv);
            }
        }
        work.store(&mut io.work[0]);
    }
}
