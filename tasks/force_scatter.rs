use crate::forces::Forces;
use crate::labels::{Deformation, ForceIndex, NodeSums, OwnStep, SurfaceArea, Weights};
use engine::graph::task::{At, Body};
use simd::{LANES, Simd};

engine::task! {
    /// Adds the forces on particles to the grid nodes: f_I += Σ_p S_Ip F_p.
    pub struct ForceScatter {
        /// The forces.
        pub forces: Forces,
    }

    Particles task {
        requires old { index: ForceIndex, area: SurfaceArea, deformation: Deformation }
        requires new { step: OwnStep, weights: Weights }
        computes { nodes: NodeSums @ 3 }
    }
}

impl Body for ForceScatter {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        for (tile, index) in io.index.iter().enumerate() {
            for lane in (0..LANES).filter(|&lane| index.0[lane] > 0.0) {
                let area = io.area[tile].map(|n| n.0[lane]);
                let f = io.deformation[tile].map(|f| f.0[lane]);
                let force = self.forces.of(index.0[lane], &io.step[0], area, &f);
                for (line, s, _) in io.weights[tile].nodes(lane, &at.origin) {
                    io.nodes[line].add_force(force.map(|force| s * force));
                }
            }
        }
    }
}
