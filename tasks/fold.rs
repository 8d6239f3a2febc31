use crate::images::{Images, Reached};
use crate::labels::{NodeSums, OwnStep, Reactions};
use crate::node::Sums;
use crate::pic::Pic;
use crate::reactions::Reaction;
use engine::graph::task::{At, Body};
use grid::Lattice;
use physics::contact::cross;
use physics::solid::add;
use simd::{Simd, Wide, store};

engine::task! {
    /// Folds what a block's particles gave to nodes g beyond a face onto their images q: m_q += m_g, p_q += R p_g, f_q += R f_g, V_q += V_g.
    /// Nodes on the face keep what they have (half of what they and their image would have together), but do not move where
    /// R turns. What that changes of momentum and force, the face gives; at rest, it does no work.
    pub struct Fold {
        /// The faces.
        pub images: Images,
        /// Their tiles of `Reactions`.
        pub tiles: [usize; 6],
        /// Where nodes are.
        pub lattice: Lattice,
        /// See `Advance`: the share of the nodes' momentum that particles take over.
        pub pic: Pic,
    }

    Buffers task {
        requires new { step: OwnStep }
        computes { sums: NodeSums @ 3, reactions: Reactions }
    }
}

impl Body for Fold {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        for face in self.images.reached(at) {
            let mut change = Change::<S>::none();
            for sums in io.sums.chunks_exact_mut(at.origin.shape.buffer_len()) {
                fold(at, &face, sums, &mut change);
            }
            let reaction = change.reaction(&self.lattice, io.step[0].size, self.pic);
            reaction.store(&mut io.reactions[self.tiles[face.face]]);
        }
    }
}

#[inline(always)]
fn fold<S: Simd>(at: &At<'_>, face: &Reached, sums: &mut [Sums], change: &mut Change<S>) {
    let turned = S::load(&Sums::signs(face.signs));
    for (ghost, image) in face.ghosts() {
        let given = std::mem::take(&mut sums[at.in_buffer(ghost)]);
        if given.mass() == 0.0 {
            continue;
        }
        let given = S::load(&given.0);
        change.add(ghost, S::splat(0.0) - given);
        if let Some(image) = image {
            let (sum, more) = (&mut sums[at.in_buffer(image)].0, turned * given);
            (S::load(sum) + more).store(sum);
            change.add(image, more);
        }
    }
    for node in face.on.iter() {
        let sum = &mut sums[at.in_buffer(node)];
        let before = S::load(&sum.0);
        sum.hold(face.signs);
        change.add(node, S::load(&sum.0) - before);
    }
}

/// Σ of what changes of the sums of nodes, and Σ of it times the node's index along each axis.
struct Change<S>([S; 4]);

impl<S: Simd> Change<S> {
    #[inline(always)]
    fn none() -> Self {
        Self([S::splat(0.0); 4])
    }

    #[inline(always)]
    fn add(&mut self, node: [i32; 3], change: S) {
        self.0[0] = self.0[0] + change;
        for axis in 0..3 {
            self.0[1 + axis] = S::splat(f64::from(node[axis])).fma(change, self.0[1 + axis]);
        }
    }

    /// The impulse Δt f + β p of a step, and its torque.
    #[inline(always)]
    fn reaction(&self, lattice: &Lattice, dt: f64, pic: Pic) -> Reaction {
        let (pic, mut sums) = (pic.of(dt), [Wide::default(); 4]);
        store(&self.0, &mut sums);
        let impulse = |sum: Wide| {
            let sum = Sums(sum);
            [0, 1, 2].map(|a| dt * sum.force()[a] + pic * sum.momentum()[a])
        };
        let [whole, x, y, z] = sums.map(impulse);
        let mut reaction = Reaction::default();
        reaction.add(lattice.lower, whole, [0.0; 3]);
        for (axis, moment) in [x, y, z].into_iter().enumerate() {
            let arm = [0, 1, 2].map(|a| if a == axis { lattice.cell } else { 0.0 });
            reaction.torque = add(reaction.torque, cross(arm, moment));
        }
        reaction
    }
}
