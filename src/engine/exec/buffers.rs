//! Buffers in which blocks add up what they add to nodes. A block has one from the moment when its particles add to nodes to
//! the moment when they read them; the next block uses it again while it is in cache.
use simd::Wide;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Stacks of idle buffers.
#[derive(Debug, Default)]
pub struct Buffers {
    idle: Mutex<Idle>,
}

#[derive(Debug, Default)]
struct Idle {
    /// A stack for each length.
    stacks: Vec<(usize, Vec<Vec<Wide>>)>,
    /// Lines of all that were ever made.
    made: usize,
}

impl Idle {
    fn stack(&mut self, lines: usize) -> &mut Vec<Vec<Wide>> {
        let at = self.stacks.iter().position(|(length, _)| *length == lines).unwrap_or_else(|| {
            self.stacks.push((lines, Vec::new()));
            self.stacks.len() - 1
        });
        &mut self.stacks[at].1
    }
}

impl Buffers {
    fn idle(&self) -> MutexGuard<'_, Idle> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The buffer of so many lines that was put back last, whatever it holds; a new one if there is none.
    pub fn take(&self, lines: usize) -> Vec<Wide> {
        let mut idle = self.idle();
        idle.stack(lines).pop().unwrap_or_else(|| {
            idle.made += lines;
            vec![Wide::default(); lines]
        })
    }

    /// Puts a buffer back; one without lines is none.
    pub fn put_back(&self, buffer: Vec<Wide>) {
        if !buffer.is_empty() {
            self.idle().stack(buffer.len()).push(buffer);
        }
    }

    /// Bytes of all buffers.
    pub fn bytes(&self) -> usize {
        self.idle().made * size_of::<Wide>()
    }
}
