//! Buffers in which blocks add up what they give to nodes. A block has one from the moment when its particles give to
//! the moment when they take; the next block uses it again while it is in cache.
use crate::physics::shape::BUFFER;
use crate::simd::Wide;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A stack of idle buffers.
#[derive(Debug, Default)]
pub struct Buffers {
    idle: Mutex<Idle>,
}

#[derive(Debug, Default)]
struct Idle {
    stack: Vec<Vec<Wide>>,
    /// All that were ever made.
    made: usize,
}

impl Buffers {
    fn idle(&self) -> MutexGuard<'_, Idle> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The buffer that was put back last, whatever it holds; a new one if there is none.
    pub fn take(&self) -> Vec<Wide> {
        let mut idle = self.idle();
        idle.stack.pop().unwrap_or_else(|| {
            idle.made += 1;
            vec![Wide::default(); BUFFER]
        })
    }

    /// Gives a buffer back; one without lines is none.
    pub fn put_back(&self, buffer: Vec<Wide>) {
        if !buffer.is_empty() {
            self.idle().stack.push(buffer);
        }
    }

    /// Bytes of all buffers.
    pub fn bytes(&self) -> usize {
        self.idle().made * BUFFER * size_of::<Wide>()
    }
}
