//! Runs a graph on a warehouse. Knows labels, blocks and threads; knows no physics.
pub mod buffers;
pub mod halo;
pub mod meter;
pub mod ranks;
pub mod relocate;
pub mod scratch;
pub mod serial;
pub mod stage;
pub mod step;
pub mod threads;
pub mod trace;
pub mod traffic;
pub mod wave;

pub use serial::Serial;
pub use step::Engine;
pub use threads::Threads;

/// How independent pieces of a phase are spread over workers. A rank executor joins here: its pieces are those of
/// its own patches, and it exchanges halos and reductions between phases.
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
