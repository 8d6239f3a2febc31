use crate::labels::{NodeMotion, OwnStep, Reactions, Time};
use crate::reactions::Reaction;
use engine::graph::task::{At, Body};
use grid::{BLOCK, Lattice, NODES};
use physics::faces::{AnyFaceCondition, FaceCondition};
use simd::Simd;

engine::task! {
    /// Holds the nodes at or beyond the faces of the domain to the conditions there, at the end of a material's step.
    pub struct Boundary {
        /// On x−, x+, y−, y+, z−, z+.
        pub faces: [AnyFaceCondition; 6],
        /// Their tiles of `Reactions`.
        pub tiles: [usize; 6],
        /// Where nodes are.
        pub lattice: Lattice,
        /// Cells of the level along each axis.
        pub cells: [usize; 3],
    }

    Nodes task {
        requires now { time: Time, step: OwnStep }
        computes { reactions: Reactions }
        modifies { motion: NodeMotion }
    }
}

impl Boundary {
    /// Whether a node lies at or beyond the face.
    fn holds(&self, face: usize, node: [i32; 3]) -> bool {
        let axis = face / 2;
        if face.is_multiple_of(2) { node[axis] <= 0 } else { node[axis] >= self.cells[axis] as i32 }
    }
}

impl Body for Boundary {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let last = at.node.map(|n| n + BLOCK - 1);
        let reached = |face: &usize| {
            self.faces[*face].acts() && (self.holds(*face, at.node) || self.holds(*face, last))
        };
        let time = io.time[0].time + io.time[0].tick;
        for face in (0..6).filter(reached) {
            let mut reaction = Reaction::default();
            let fields = io.motion.chunks_exact_mut(NODES).zip(at.fields);
            for (motions, _) in fields.filter(|(_, field)| field.ends) {
                for (n, motion) in motions.iter_mut().enumerate() {
                    let node = at.node_of(n);
                    if self.holds(face, node) {
                        let dv = self.faces[face].correction(face / 2, time, motion.velocity());
                        motion.add(dv);
                        let impulse = dv.map(|dv| motion.mass() * dv);
                        reaction.add(self.lattice.position(node), impulse, motion.mean());
                    }
                }
            }
            reaction.store(&mut io.reactions[self.tiles[face]]);
        }
    }
}
