use crate::labels::{NodeMotion, OwnStep, Reactions};
use crate::reactions::Reaction;
use engine::graph::task::{At, Body};
use grid::{Lattice, NODES};
use simd::Simd;

engine::task! {
    /// Brakes the grid nodes that are out of balance, axis by axis, at the end of a material's step: Δv_I ← Δv_I − ξ |Δv_I| sign v⁰_I, after all
    /// that acts on a node has acted (P. A. Cundall, in *Analytical and Computational Methods in Engineering Rock Mechanics*, 1987).
    pub struct LocalDamping {
        /// ξ
        pub share: f64,
        /// The tile of `Reactions` of loads.
        pub tile: usize,
        /// Where nodes are.
        pub lattice: Lattice,
    }

    Nodes task {
        requires now { step: OwnStep }
        computes { reactions: Reactions }
        modifies { motion: NodeMotion }
    }
}

impl Body for LocalDamping {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let mut reaction = Reaction::default();
        let fields = io.motion.chunks_exact_mut(NODES).zip(at.fields);
        for (motions, _) in fields.filter(|(_, field)| field.ends) {
            for (n, motion) in motions.iter_mut().enumerate().filter(|(_, motion)| motion.mass() > 0.0) {
                let (start, now) = (motion.start(), motion.velocity());
                let brake = [0, 1, 2].map(|a| match start[a] {
                    0.0 => 0.0,
                    v => -self.share * (now[a] - v).abs() * v.signum(),
                });
                motion.add(brake);
                let impulse = brake.map(|dv| motion.mass() * dv);
                reaction.add(self.lattice.position(at.node_of(n)), impulse, motion.mean());
            }
        }
        reaction.store(&mut io.reactions[self.tile]);
    }
}
