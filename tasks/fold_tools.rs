use super::fold_surfaces::fold;
use crate::images::Images;
use crate::labels::ToolSums;
use engine::graph::task::{At, Body};
use grid::Lattice;
use simd::Simd;

engine::task! {
    /// Folds what tools know of surfaces beyond a face onto the images: see `FoldSurfaces`.
    pub struct FoldTools {
        /// The faces.
        pub images: Images,
        /// Where nodes are.
        pub lattice: Lattice,
    }

    Buffers task {
        computes { sums: ToolSums @ 3 }
    }
}

impl Body for FoldTools {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        fold(at, &self.images, &self.lattice, &mut io.sums);
    }
}
