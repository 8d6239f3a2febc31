use crate::images::Images;
use crate::labels::ContactSums;
use crate::node::Surface;
use engine::graph::task::{At, Body};
use grid::Lattice;
use simd::Simd;

engine::task! {
    /// Folds what contact knows of surfaces beyond a face onto the images: a body that ends at a face goes on there, and has no surface.
    pub struct FoldSurfaces {
        /// The faces.
        pub images: Images,
        /// Where nodes are.
        pub lattice: Lattice,
    }

    Buffers task {
        computes { sums: ContactSums @ 3 }
    }
}

impl Body for FoldSurfaces {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        fold(at, &self.images, &self.lattice, &mut io.sums);
    }
}

/// Folds the surfaces that a block's particles gave to nodes beyond faces onto their images.
pub fn fold(at: &At<'_>, images: &Images, lattice: &Lattice, sums: &mut [Surface]) {
    for sums in sums.chunks_exact_mut(at.origin.shape.buffer_len()) {
        for face in images.reached(at) {
            let plane = lattice.lower[face.axis] + lattice.cell * f64::from(face.plane);
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
