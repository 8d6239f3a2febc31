//! One velocity for both materials.
use super::{Exchange, Pair, dot};

/// Takes away all relative velocity.
pub fn exchange(pair: &Pair) -> Exchange {
    let along = dot(pair.relative, pair.normal);
    pair.exchange(along, std::array::from_fn(|a| pair.relative[a] - along * pair.normal[a]))
}
