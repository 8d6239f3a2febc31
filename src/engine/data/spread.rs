//! Work on pieces that have nothing to do with one another.
use std::sync::{Mutex, PoisonError};

/// Who does it: one after the other, or side by side.
pub trait Spread: Sync {
    /// Runs `work` for all numbers below `count`, each once and in any order.
    fn spread(&self, count: usize, work: &(dyn Fn(usize) + Sync));
}

/// Pieces that a worker takes at once: looking for the next one should cost little beside them.
const AT_ONCE: usize = 64;

/// Runs `work` on all `items`, `at_once` by `at_once`.
pub fn each_of<T: Send>(spread: &dyn Spread, items: &mut [T], at_once: usize, work: impl Fn(&mut T) + Sync) {
    // a lock says who has a piece; nobody ever waits for it
    let pieces: Vec<Mutex<&mut [T]>> = items.chunks_mut(at_once).map(Mutex::new).collect();
    spread.spread(pieces.len(), &|n| {
        let mut piece = pieces[n].lock().unwrap_or_else(PoisonError::into_inner);
        piece.iter_mut().for_each(&work);
    });
}

/// The same for many that take a moment each.
pub fn many<T: Send>(spread: &dyn Spread, items: &mut [T], work: impl Fn(&mut T) + Sync) {
    each_of(spread, items, AT_ONCE, work);
}
