//! What MPI grants the threads of a process.
use std::fmt;

/// What an MPI library lets the threads of a process do, in ascending order (MPI 3.1, 12.4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Threading {
    /// There is one thread.
    Single,
    /// One of several threads calls MPI, the one that started it: all that Sinew needs.
    Funneled,
    /// All of them call it, one at a time.
    Serialized,
    /// All of them call it.
    Multiple,
}

impl Threading {
    /// Whether a process may have so many threads.
    pub fn admits(self, threads: usize) -> bool {
        threads <= 1 || self >= Self::Funneled
    }
}

impl fmt::Display for Threading {
    /// As MPI calls it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Single => "MPI_THREAD_SINGLE",
            Self::Funneled => "MPI_THREAD_FUNNELED",
            Self::Serialized => "MPI_THREAD_SERIALIZED",
            Self::Multiple => "MPI_THREAD_MULTIPLE",
        })
    }
}
