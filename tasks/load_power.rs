use super::loads::LoadField;
use crate::labels::{NodeMotion, NodeSums, OwnStep, Reactions, Time};
use crate::reactions::Reaction;
use engine::graph::task::{At, Body};
use grid::{Lattice, NODES};
use simd::Simd;

/// Work of gravity and damping, with the mean velocity of the whole step (see `ContactPower`).
pub struct LoadPower {
    /// What acts.
    pub field: LoadField,
    /// Its tile of `Reactions`.
    pub tile: usize,
    /// Where nodes are.
    pub lattice: Lattice,
    /// Mass below which a node carries nothing [kg].
    pub least_mass: f64,
    /// Which materials are rigid: they take their loads as a whole.
    pub rigid: Vec<bool>,
}

engine::task! { Nodes task LoadPower {
    requires new { time: Time, step: OwnStep, sums: NodeSums, motion: NodeMotion }
    computes { reactions: Reactions }
}}

impl Body for LoadPower {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let (mut reaction, now) = (Reaction::default(), io.time[0].time);
        let fields = io.sums.chunks_exact(NODES).zip(io.motion.chunks_exact(NODES)).zip(at.fields);
        for ((sums, motions), field) in fields.filter(|(_, f)| f.ends && !self.rigid[f.material]) {
            for (n, (sum, motion)) in sums.iter().zip(motions).enumerate() {
                if sum.mass() > self.least_mass {
                    let dv = self.field.change(sum, motion, now - field.elapsed, field.step);
                    let impulse = dv.map(|dv| sum.mass() * dv);
                    reaction.add(self.lattice.position(at.node_of(n)), impulse, motion.mean());
                }
            }
        }
        reaction.store(&mut io.reactions[self.tile]);
    }
}
