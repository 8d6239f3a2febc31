//! Several threads, by rayon.
use super::Executor;
use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// Runs items on a pool of its own, with work stealing. Which thread runs what cannot change a bit of the result.
#[derive(Debug)]
pub struct Threads {
    pool: ThreadPool,
}

impl Threads {
    /// A pool of `threads` threads.
    ///
    /// # Errors
    /// If the system refuses to start threads.
    pub fn new(threads: usize) -> Result<Self, ThreadPoolBuildError> {
        let pool =
            ThreadPoolBuilder::new().num_threads(threads).thread_name(|i| format!("sinew-{i}")).build()?;
        Ok(Self { pool })
    }
}

impl Executor for Threads {
    fn each<T: Send>(&self, items: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
        self.pool.install(|| {
            items.par_iter_mut().with_min_len(2).for_each(|item| {
                work(rayon::current_thread_index().unwrap_or(0), item);
            });
        });
    }

    /// On a worker: it need not wake others from outside.
    fn enter<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.pool.install(work)
    }

    fn workers(&self) -> usize {
        self.pool.current_num_threads()
    }
}
