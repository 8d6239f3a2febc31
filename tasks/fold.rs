use crate::images::{Images, Reached};
use crate::labels::{NodeSums, OwnStep, Reactions};
use crate::node::Sums;
use crate::pic::Pic;
use crate::reactions::Reaction;
use engine::graph::task::{At, Body};
use grid::Lattice;
use simd::Simd;

/// m_q += m_g, p_q += R p_g, f_q += R f_g, V_q += V_g: what a block's particles gave to nodes g beyond a face goes to their
/// images q. Nodes on the face keep what they have (half of what they and their image would have together), but do not move where
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

engine::task! { Buffers task Fold {
    requires new { step: OwnStep }
    computes { sums: NodeSums @ 3, reactions: Reactions }
}}

impl Body for Fold {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let dt = io.step[0].size;
        for face in self.images.reached(at) {
            let mut reaction = Reaction::default();
            for sums in io.sums.chunks_exact_mut(at.origin.shape.buffer_len()) {
                self.fold(at, &face, dt, sums, &mut reaction);
            }
            reaction.store(&mut io.reactions[self.tiles[face.face]]);
        }
    }
}

impl Fold {
    fn fold(&self, at: &At<'_>, face: &Reached, dt: f64, sums: &mut [Sums], reaction: &mut Reaction) {
        let pic = self.pic.of(dt);
        let mut count = |node: [i32; 3], sign: f64, sums: &Sums| {
            let (force, momentum) = (sums.force(), sums.momentum());
            let impulse = [0, 1, 2].map(|a| sign * (dt * force[a] + pic * momentum[a]));
            reaction.add(self.lattice.position(node), impulse, [0.0; 3]);
        };
        for (ghost, image) in face.ghosts() {
            let given = std::mem::take(&mut sums[at.in_buffer(ghost)]);
            count(ghost, -1.0, &given);
            let Some(image) = image else { continue };
            let sum = &mut sums[at.in_buffer(image)];
            count(image, -1.0, sum);
            sum.add_image(&given, face.signs);
            count(image, 1.0, sum);
        }
        for node in face.on.iter() {
            let sum = &mut sums[at.in_buffer(node)];
            count(node, -1.0, sum);
            sum.hold(face.signs);
            count(node, 1.0, sum);
        }
    }
}
