//! Messages between ranks: who may send what to whom, without a word about how they travel.
pub mod collective;
mod error;
pub mod halos;
pub mod launch;
pub mod local;
pub mod migrate;
#[cfg(feature = "mpi")]
pub mod mpi;
pub mod occupied;
pub mod reduction;
pub mod threading;
pub mod words;

pub use error::NetworkError;
pub use words::{pack, unpack};

use simd::Wide;
use std::time::Duration;

/// What a message is about. Messages from one rank to another on one channel arrive in the order in which they were sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// An exchange of a graph, by its number: partial sums or values of nodes.
    Halo(u16),
    /// Particles that come to blocks of the receiver.
    Travelers,
    /// Which blocks are occupied beside the receiver's.
    Occupied,
    /// A part of a reduction, or its result.
    Reduction,
    /// Whole patches that change their rank.
    Patches,
    /// Rows of an output file, for the rank that writes.
    Output,
}

impl Channel {
    /// Whether such messages come in every tick, so that their memory is worth keeping; others may be large.
    pub fn is_of_every_tick(self) -> bool {
        matches!(self, Channel::Halo(_) | Channel::Reduction)
    }

    /// A number of its own.
    pub fn tag(self) -> i32 {
        match self {
            Channel::Travelers => 0,
            Channel::Occupied => 1,
            Channel::Reduction => 2,
            Channel::Patches => 3,
            Channel::Output => 4,
            Channel::Halo(number) => 5 + i32::from(number),
        }
    }
}

/// The ranks of a run, seen from one of them. A message is a number of cache lines.
pub trait Network {
    /// Which rank this is.
    fn rank(&self) -> usize;

    /// Number of ranks.
    fn size(&self) -> usize;

    /// Whether a process may have more threads than the one that sends and receives.
    fn admits_threads(&self) -> bool {
        true
    }

    /// Sends a message and goes on at once.
    fn send(&mut self, to: usize, channel: Channel, message: Vec<Wide>);

    /// Says that a message of at most `most` lines will come, so that it can travel while this rank works.
    fn expect(&mut self, from: usize, channel: Channel, most: usize);

    /// The next message, if it is here.
    ///
    /// # Errors
    /// If the sender is gone.
    fn arrived(&mut self, from: usize, channel: Channel) -> Result<Option<Vec<Wide>>, NetworkError>;

    /// The next message; waits for it.
    ///
    /// # Errors
    /// If the sender is gone.
    fn receive(&mut self, from: usize, channel: Channel) -> Result<Vec<Wide>, NetworkError>;

    /// Waits until all that was sent has left, so that its memory is free again.
    fn settle(&mut self);

    /// Empty memory for a message of some lines: of an old one, if there is one.
    fn memory(&mut self, lines: usize) -> Vec<Wide> {
        Vec::with_capacity(lines)
    }

    /// A message of some lines, to be overwritten whatever it holds.
    fn message(&mut self, lines: usize) -> Vec<Wide> {
        vec![Wide::default(); lines]
    }

    /// Takes back the memory of a message that has been read.
    fn give_back(&mut self, _message: Vec<Wide>) {}

    /// Waits until all ranks have come to their end, at most for `patience`; returns whether they have.
    fn part(&mut self, _patience: Option<Duration>) -> bool {
        true
    }

    /// The first rank calls it last in a run that a signal ended in good order, so that the launcher ends with this status.
    fn end_by_signal(&mut self, _status: i32) {}

    /// Ends all ranks at once, where they cannot agree on an end.
    fn abort(&mut self, status: i32) {
        std::process::exit(status);
    }
}

/// A run on one rank.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Network for Alone {
    fn rank(&self) -> usize {
        0
    }

    fn size(&self) -> usize {
        1
    }

    fn send(&mut self, to: usize, channel: Channel, _message: Vec<Wide>) {
        debug_assert!(false, "one rank sends to nobody, not {channel:?} to {to}");
    }

    fn expect(&mut self, _from: usize, _channel: Channel, _most: usize) {}

    fn arrived(&mut self, from: usize, _channel: Channel) -> Result<Option<Vec<Wide>>, NetworkError> {
        Err(NetworkError::Lost { rank: from })
    }

    fn receive(&mut self, from: usize, _channel: Channel) -> Result<Vec<Wide>, NetworkError> {
        Err(NetworkError::Lost { rank: from })
    }

    fn settle(&mut self) {}
}
