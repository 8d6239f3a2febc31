use super::work::Work;
use crate::images::Images;
use crate::labels::{BoundaryWork, NodeSums, OwnStep};
use crate::node::Sums;
use engine::graph::task::{At, Body};
use simd::Simd;

/// m_q += m_g, p_q += R p_g, f_q += R f_g, V_q += V_g: what a block's particles gave to nodes g beyond a face goes to their
/// images q. Nodes on the face keep what they have (half of what they and their image would have together), but do not move where
/// R turns.
pub struct Fold {
    /// The faces.
    pub images: Images,
    /// β, see `Advance`: the share of the nodes' momentum that particles take over.
    pub pic: f64,
}

engine::task! { Buffers task Fold {
    requires new { step: OwnStep }
    computes { sums: NodeSums @ 3, work: BoundaryWork }
}}

impl Body for Fold {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        if self.images.reached(at).next().is_none() {
            return;
        }
        let (mut force, mut momentum) = ([0.0; 3], [0.0; 3]);
        let mut count = |sign: f64, sums: &Sums| {
            for a in 0..3 {
                force[a] += sign * sums.force()[a];
                momentum[a] += sign * sums.momentum()[a];
            }
        };
        for sums in io.sums.chunks_exact_mut(at.origin.shape.buffer_len()) {
            for face in self.images.reached(at) {
                for (ghost, image) in face.ghosts() {
                    let given = std::mem::take(&mut sums[at.in_buffer(ghost)]);
                    count(-1.0, &given);
                    let Some(image) = image else { continue };
                    let image = &mut sums[at.in_buffer(image)];
                    count(-1.0, image);
                    image.add_image(&given, face.signs);
                    count(1.0, image);
                }
                for node in face.on.iter() {
                    let node = &mut sums[at.in_buffer(node)];
                    count(-1.0, node);
                    node.hold(face.signs);
                    count(1.0, node);
                }
            }
        }
        // a face at rest does no work
        let impulse = std::array::from_fn(|a| io.step[0].size * force[a] + self.pic * momentum[a]);
        Work { work: 0.0, impulse }.store(&mut io.work[0]);
    }
}
