use crate::labels::{LoadChange, NodeMotion, OwnStep, Reactions};
use crate::reactions::Reaction;
use engine::graph::task::{At, Body};
use grid::{Lattice, NODES};
use simd::Simd;

engine::task! {
    /// Work of gravity and damping, with the mean velocity of the whole step (see `ContactPower`).
    pub struct LoadPower {
        /// Its tile of `Reactions`.
        pub tile: usize,
        /// Where nodes are.
        pub lattice: Lattice,
    }

    Nodes task {
        requires now { step: OwnStep, change: LoadChange, motion: NodeMotion }
        computes { reactions: Reactions }
    }
}

impl Body for LoadPower {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let mut reaction = Reaction::default();
        let fields = io.change.chunks_exact(NODES).zip(io.motion.chunks_exact(NODES)).zip(at.fields);
        for ((changes, motions), _) in fields.filter(|(_, field)| field.ends) {
            for (n, (change, motion)) in changes.iter().zip(motions).enumerate() {
                let impulse = change.velocity().map(|dv| motion.mass() * dv);
                reaction.add(self.lattice.position(at.node_of(n)), impulse, motion.mean());
            }
        }
        reaction.store(&mut io.reactions[self.tile]);
    }
}
