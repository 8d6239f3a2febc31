use crate::labels::{NodeMotion, NodeSums, OwnStep, RigidSite, ToolSums};
use crate::node::Site;
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

/// What nodes know of the matter near free rigid bodies: kept, because their motion is found in several rounds.
pub struct RigidSites {
    /// Mass below which a node carries nothing [kg].
    pub least_mass: f64,
}

engine::task! { Nodes task RigidSites {
    requires new { step: OwnStep, sums: NodeSums, motion: NodeMotion }
    requires now { surfaces: ToolSums }
    computes { site: RigidSite }
}}

impl Body for RigidSites {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let known = io.sums.chunks_exact(NODES).zip(io.surfaces.chunks_exact(NODES));
        let fields =
            known.zip(io.motion.chunks_exact(NODES)).zip(io.site.chunks_exact_mut(NODES)).zip(at.fields);
        for ((((sums, surfaces), motions), sites), field) in fields {
            for (n, site) in sites.iter_mut().enumerate() {
                let (sum, v) = (&sums[n], motions[n].velocity());
                *site = match sum.mass() > self.least_mass {
                    true => Site::of(sum, &surfaces[n], field.elapsed, v),
                    false => Site::default(),
                };
            }
        }
    }
}
