use crate::labels::{NodeMotion, NodeSums, OwnStep, RigidSite, ToolSums};
use crate::node::{Driven, Motion, Site, Sums, Surface};
use engine::graph::task::{At, Body};
use grid::NODES;
use simd::Simd;

engine::task! {
    /// What nodes know of the matter near free rigid bodies: kept, because their motion is found in several rounds.
    pub struct RigidSites {
        /// Mass below which a node carries nothing [kg].
        pub least_mass: f64,
    }

    Nodes task {
        requires new { step: OwnStep, sums: NodeSums, motion: NodeMotion }
        requires now { surfaces: ToolSums }
        computes { site: RigidSite }
    }
}

impl Body for RigidSites {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        self.tell(at, (&io.sums, &io.surfaces, &io.motion), &[], &mut io.site);
    }
}

pub use driven::DrivenSites;

mod driven {
    use super::*;
    use crate::labels::DriveSums;

    engine::task! {
        /// As `RigidSites`, where drives hold matter.
        pub struct DrivenSites(pub RigidSites);

        Nodes task {
            requires new { step: OwnStep, sums: NodeSums, motion: NodeMotion }
            requires now { surfaces: ToolSums, driven: DriveSums }
            computes { site: RigidSite }
        }
    }

    impl Body for DrivenSites {
        #[inline(always)]
        fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
            self.0.tell(at, (&io.sums, &io.surfaces, &io.motion), &io.driven, &mut io.site);
        }
    }
}

impl RigidSites {
    /// Tells the sites of a block.
    fn tell(
        &self,
        at: &At<'_>,
        (sums, surfaces, motions): (&[Sums], &[Surface], &[Motion]),
        driven: &[Driven],
        sites: &mut [Site],
    ) {
        for (slot, field) in at.fields.iter().enumerate() {
            for line in NODES * slot..NODES * (slot + 1) {
                let (sum, v) = (&sums[line], motions[line].velocity());
                let held = |a: usize| driven.get(line).and_then(|driven| driven.velocity(a, sum.mass()));
                sites[line] = match sum.mass() > self.least_mass {
                    true => Site::of(sum, &surfaces[line], field.elapsed, v, [0, 1, 2].map(held)),
                    false => Site::default(),
                };
            }
        }
    }
}
