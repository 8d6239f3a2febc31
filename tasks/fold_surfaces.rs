use crate::images::Images;
use crate::labels::ContactSums;
use engine::graph::task::{At, Body};
use grid::Lattice;
use simd::Simd;

/// What contact knows of surfaces, with that of the images beyond faces: a body that ends at a face goes on there, and has no
/// surface.
pub struct FoldSurfaces {
    /// The faces.
    pub images: Images,
    /// Where nodes are.
    pub lattice: Lattice,
}

engine::task! { Buffers task FoldSurfaces {
    computes { sums: ContactSums @ 3 }
}}

impl Body for FoldSurfaces {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        for sums in io.sums.chunks_exact_mut(at.origin.shape.buffer_len()) {
            for face in self.images.reached(at) {
                let plane = self.lattice.lower[face.axis] + self.lattice.cell * f64::from(face.plane);
                for (ghost, image) in face.ghosts() {
                    let given = std::mem::take(&mut sums[at.in_buffer(ghost)]);
                    if let Some(image) = image {
                        sums[at.in_buffer(image)].add_image(&given, face.axis, plane);
                    }
                }
                face.on.iter().for_each(|node| sums[at.in_buffer(node)].center_on(face.axis, plane));
            }
        }
    }
}
