//! Runs a graph on a warehouse. Knows labels, blocks and threads; knows no physics.
pub mod backend;
pub mod buffers;
mod conduct;
mod exchange;
pub mod halo;
mod lending;
pub mod meter;
pub mod moves;
pub mod order;
pub mod ranks;
pub mod recorder;
pub mod region;
pub mod relocate;
pub mod scratch;
pub mod serial;
pub mod spent;
pub mod stage;
pub mod step;
pub mod sums;
pub mod threads;
pub mod trace;
pub mod traffic;
pub mod traveler;
pub mod wave;
pub mod work;

pub use backend::Backend;
pub use conduct::{Conductor, Stopped, Undirected};
pub use serial::Serial;
pub use step::Engine;
pub use threads::Threads;

/// How independent pieces of a phase are spread over the workers of a rank. What passes between ranks is the business of
/// [`ranks::Network`].
pub trait Executor: Send + Sync {
    /// Runs `work(worker, item)` on every item, each on some worker below [`Executor::workers`]; at any time a
    /// worker runs one item.
    fn each<T: Send>(&self, items: &mut [T], work: impl Fn(usize, &mut T) + Sync)
    where
        Self: Sized;

    /// Runs `work` where [`Executor::each`] costs least.
    fn enter<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R
    where
        Self: Sized,
    {
        work()
    }

    /// Number of workers.
    fn workers(&self) -> usize;
}
