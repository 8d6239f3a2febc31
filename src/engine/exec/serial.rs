//! One thread, in order.
use super::Executor;

/// Runs everything on the calling thread.
#[derive(Clone, Copy, Debug, Default)]
pub struct Serial;

impl Executor for Serial {
    fn each<T: Send>(&self, items: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
        items.iter_mut().for_each(|item| work(0, item));
    }

    fn workers(&self) -> usize {
        1
    }
}
