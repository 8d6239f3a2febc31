use super::Channel;
use super::threading::Threading;

/// Why ranks cannot go on together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NetworkError {
    /// A rank that does not answer any more.
    #[error(
        "rank {rank} is gone: it ended or was killed. Go on from the last whole checkpoint: sinew run --restart DIR"
    )]
    Lost {
        /// The rank.
        rank: usize,
    },
    /// An MPI library that does not know of threads.
    #[error(
        "{threads} threads a rank need {}, but this MPI library grants {granted}: run with --threads 1, or with an MPI \
         library that was built for threads",
        Threading::Funneled
    )]
    Threading {
        /// What it grants.
        granted: Threading,
        /// Threads of this rank.
        threads: usize,
    },
    /// Particles that left a rank and came nowhere.
    #[error(
        "{sent} particles changed their rank, but {came} arrived. This is an error in Sinew, please report it"
    )]
    Particles {
        /// How many left a rank.
        sent: u64,
        /// How many came to one.
        came: u64,
    },
    /// A patch that did not arrive whole at its new rank.
    #[error("patch {patch} from rank {rank} is not whole. This is an error in Sinew, please report it")]
    Patch {
        /// The patch.
        patch: usize,
        /// Who sent it.
        rank: usize,
    },
    /// A message that MPI cannot count.
    #[error(
        "a message between this rank and rank {rank} about {channel:?} has {lines} lines of 64 bytes; MPI counts to {}. Cut \
         the scene into more patches with --patches, or start more ranks",
        i32::MAX
    )]
    TooLong {
        /// The other rank.
        rank: usize,
        /// What it is about.
        channel: Channel,
        /// Its lines.
        lines: usize,
    },
    /// A message that is no whole number of lines, or has more than MPI counts.
    #[error(
        "a message of rank {rank} about {channel:?} is no whole number of lines that MPI can count. This is an error in \
         Sinew, please report it; or do all ranks run the same Sinew?"
    )]
    Torn {
        /// Who sent it.
        rank: usize,
        /// What it is about.
        channel: Channel,
    },
    /// A message that does not hold what both sides know it must.
    #[error(
        "a message of rank {rank} about {channel:?} has {lines} lines instead of {expected}. This is an error in Sinew, please report it"
    )]
    Length {
        /// Who sent it.
        rank: usize,
        /// What it is about.
        channel: Channel,
        /// Lines that came.
        lines: usize,
        /// Lines that should have come.
        expected: usize,
    },
}
