use crate::labels::{NodeMotion, NodeSums, OwnStep};
use crate::node::Motion;
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

/// v_I ← v_I + Δt (g − α v⁰_I): gravity, and damping in proportion to mass and to the velocity that the step began with.
pub struct Loads {
    /// What acts.
    pub field: LoadField,
    /// Mass below which a node carries nothing [kg].
    pub least_mass: f64,
    /// Which materials are rigid: they take their loads as a whole.
    pub rigid: Vec<bool>,
}

/// Accelerations that act everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadField {
    /// g [m/s²]
    pub gravity: [f64; 3],
    /// α [1/s]
    pub damping: f64,
}

impl LoadField {
    /// Δt (g − α v⁰) of a node.
    #[inline(always)]
    pub fn change(&self, motion: &Motion, dt: f64) -> [f64; 3] {
        let start = motion.start();
        std::array::from_fn(|a| dt * (self.gravity[a] - self.damping * start[a]))
    }
}

engine::task! { Nodes task Loads {
    requires new { step: OwnStep, sums: NodeSums }
    modifies { motion: NodeMotion }
}}

impl Body for Loads {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let fields = io.sums.chunks_exact(NODES).zip(io.motion.chunks_exact_mut(NODES)).zip(at.fields);
        for ((sums, motions), field) in fields.filter(|(_, f)| !self.rigid[f.material]) {
            for (_, motion) in sums.iter().zip(motions).filter(|(sum, _)| sum.mass() > self.least_mass) {
                let dv = self.field.change(motion, field.missed + field.tick);
                motion.add(dv);
            }
        }
    }
}
