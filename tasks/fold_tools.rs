use super::fold_surfaces::fold;
use crate::images::Images;
use crate::labels::ToolSums;
use engine::graph::task::{At, Body};
use grid::Lattice;
use simd::Simd;

/// What tools know of surfaces, with that of the images beyond faces: see `FoldSurfaces`.
pub struct FoldTools {
    /// The faces.
    pub images: Images,
    /// Where nodes are.
    pub lattice: Lattice,
}

engine::task! { Buffers task FoldTools {
    computes { sums: ToolSums @ 3 }
}}

impl Body for FoldTools {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        fold(at, &self.images, &self.lattice, &mut io.sums);
    }
}
