//! The start of a run: what is known of all particles is counted by all ranks together, and none of them walks through all.
pub mod census;
pub(super) mod maker;
pub mod memory;
mod moments;
pub mod roll;

pub use census::census;
pub use moments::{center, place_bodies};
pub use roll::Roll;

/// Which of many pieces of work a rank does: every so-manieth, so that it is spread evenly wherever it is dense.
fn share(network: &dyn engine::exec::ranks::Network, pieces: usize) -> impl Iterator<Item = usize> + use<> {
    (network.rank()..pieces).step_by(network.size())
}
