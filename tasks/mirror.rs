use crate::images::Images;
use crate::labels::NodeMotion;
use crate::node::Motion;
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// Nodes beyond a face move as their images do: v_g = R v_q, Δv_g = R Δv_q.
    pub struct Mirror {
        /// The faces.
        pub images: Images,
    }

    Buffers task {
        adapts { motion: NodeMotion @ 3 }
    }
}

impl Body for Mirror {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        for motions in io.motion.chunks_exact_mut(at.origin.shape.buffer_len()) {
            for face in self.images.reached(at) {
                let signs = S::load(&Motion::signs(face.signs));
                for (ghost, image) in face.ghosts() {
                    let image =
                        image.map_or(S::splat(0.0), |image| signs * S::load(&motions[at.in_buffer(image)].0));
                    image.store(&mut motions[at.in_buffer(ghost)].0);
                }
            }
        }
    }
}
