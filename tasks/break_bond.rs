use crate::labels::{Bond, ContactImpulse, Weights};
use engine::graph::task::{At, Body};
use simd::Simd;

/// b_p = 0 for particles most of whose weight lies on nodes where bonds broke in this step.
pub struct BreakBond;

engine::task! { NearParticles task BreakBond {
    requires new { weights: Weights }
    requires now { broken: ContactImpulse @ 3 }
    modifies { bond: Bond }
}}

impl Body for BreakBond {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        for particle in 0..at.count {
            let (tile, lane) = (particle / 8, particle % 8);
            if io.bond[tile].0[lane] == 0.0 {
                continue;
            }
            let nodes = io.weights[tile].nodes(lane, &at.origin);
            let broken: f64 =
                nodes.filter(|(line, ..)| io.broken[*line].is_broken()).map(|(_, s, _)| s).sum();
            if broken > 0.5 {
                io.bond[tile].0[lane] = 0.0;
            }
        }
    }
}
