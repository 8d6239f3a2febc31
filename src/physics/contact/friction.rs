//! Coulomb friction with free separation, after S. G. Bardenhagen et al., CMES 2(4), 2001, 509–522
//! (doi:10.3970/cmes.2001.002.509), made pairwise: each impulse has its opposite, so momentum is conserved for any
//! number of materials at a node.
use super::{Exchange, Pair, dot};

/// When frictional contact acts, besides the gap test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Criterion {
    /// While the surfaces approach.
    Approach,
    /// While the surfaces approach or the normal traction between them is compressive.
    ApproachOrCompression,
    /// While the surfaces approach and the normal traction is compressive.
    ApproachAndCompression,
}

/// Stops approach along the normal, and slip as far as friction `coefficient` allows.
pub fn exchange(pair: &Pair, coefficient: f64, criterion: Criterion) -> Exchange {
    let approach = dot(pair.relative, pair.normal);
    let compressed = pair.traction < 0.0;
    let acts = match criterion {
        Criterion::Approach => approach > 0.0,
        Criterion::ApproachOrCompression => approach > 0.0 || compressed,
        Criterion::ApproachAndCompression => approach > 0.0 && compressed,
    };
    if !acts {
        return Exchange::default();
    }
    let slip: [f64; 3] = std::array::from_fn(|a| pair.relative[a] - approach * pair.normal[a]);
    let speed = dot(slip, slip).sqrt();
    let limit = coefficient * approach.abs();
    let share = if speed > limit { limit / speed } else { 1.0 };
    pair.exchange(approach, slip.map(|s| share * s))
}
