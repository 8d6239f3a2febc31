use crate::labels::{Bond, ContactImpulse, Weights};
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// Breaks the bond of particles, b_p = 0, most of whose weight lies on nodes where bonds broke in this step; nodes that bear none of the
    /// stress do not count.
    pub struct BreakBond;

    NearParticles task {
        requires new { weights: Weights }
        requires now { broken: ContactImpulse @ 3 }
        modifies { bond: Bond }
    }
}

impl Body for BreakBond {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        for particle in 0..at.count {
            let (tile, lane) = (particle / 8, particle % 8);
            if io.bond[tile].0[lane] == 0.0 {
                continue;
            }
            let nodes = io.weights[tile].nodes(lane, &at.origin);
            let (mut broken, mut aside) = (0.0, 0.0);
            for (line, s, _) in nodes {
                broken += if io.broken[line].is_broken() { s } else { 0.0 };
                aside += if io.broken[line].is_aside() { s } else { 0.0 };
            }
            if broken > 0.0 && broken > 0.5 * (1.0 - aside) {
                io.bond[tile].0[lane] = 0.0;
            }
        }
    }
}
