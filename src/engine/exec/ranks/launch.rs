//! What a launcher such as `mpirun` tells a process before MPI has begun.
use super::threading::Threading;
use super::{Alone, Network, NetworkError};
use std::env;

/// Place of this process among those that were launched together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Launch {
    /// Its rank.
    pub rank: usize,
    /// Number of ranks.
    pub size: usize,
}

/// Variables for rank and size: Open MPI, MPICH and Intel MPI, Slurm with PMIx.
const VARIABLES: [[&str; 2]; 3] = [
    ["OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"],
    ["PMI_RANK", "PMI_SIZE"],
    ["PMIX_RANK", "SLURM_NTASKS"],
];

impl Launch {
    /// What the environment says; one rank if it says nothing.
    pub fn of_this_process() -> Self {
        let number = |name: &str| env::var(name).ok().and_then(|text| text.parse().ok());
        let launched = VARIABLES.iter().find_map(|[rank, size]| {
            Some(Self { rank: number(rank)?, size: number(size)? }).filter(|launch| launch.size > 0)
        });
        launched.unwrap_or(Self { rank: 0, size: 1 })
    }

    /// The ranks that were launched together, and what this one finds where it runs.
    ///
    /// # Errors
    /// Several processes, and a Sinew that was built without MPI.
    pub fn connect(self) -> Result<(Box<dyn Network>, Machine), String> {
        if self.size == 1 {
            return Ok((Box::new(Alone), Machine { ranks: 1, threading: Threading::Multiple }));
        }
        #[cfg(feature = "mpi")]
        {
            let mpi = super::mpi::Mpi::start().ok_or("MPI was started before in this process")?;
            let site = Machine { ranks: mpi.ranks_here(), threading: mpi.threading() };
            Ok((Box::new(mpi), site))
        }
        #[cfg(not(feature = "mpi"))]
        Err(format!(
            "this Sinew was built without MPI and cannot run as one of {} ranks: build it with cargo build --release \
             --features mpi, or start it without mpirun",
            self.size
        ))
    }
}

/// What a rank finds where it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Machine {
    /// Ranks on this machine, itself included.
    pub ranks: usize,
    /// What MPI lets its threads do.
    pub threading: Threading,
}

/// Name of the machine on which this process runs.
pub fn host() -> String {
    let name =
        std::fs::read_to_string("/proc/sys/kernel/hostname").ok().or_else(|| env::var("HOSTNAME").ok());
    name.map_or_else(|| "unknown".into(), |name| name.trim().into())
}

/// Whether a rank may have so many threads.
///
/// # Errors
/// If MPI lets it have one alone.
pub fn admit(granted: Threading, threads: usize) -> Result<(), NetworkError> {
    if granted.admits(threads) { Ok(()) } else { Err(NetworkError::Threading { granted, threads }) }
}

/// Cores of this machine, and those that this process may use. `None`: unknown.
pub fn cores() -> (Option<usize>, usize) {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let all = info.lines().filter(|line| line.starts_with("processor")).count();
    ((all > 0).then_some(all), available_threads())
}

/// Cores that this process may use.
pub fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// Threads for each of `here` ranks that share this machine, if nobody asks for a number; and what to say about it.
pub fn threads(asked: Option<usize>, here: usize) -> (usize, Option<String>) {
    let (all, allowed) = cores();
    let shared = all.map_or(1, |all| (all / here).max(1));
    // a launcher that binds each rank to cores of its own has divided them already
    let fair = if all.is_some_and(|all| allowed < all) { allowed } else { shared };
    let threads = asked.unwrap_or(fair);
    let wanted = asked.unwrap_or(shared);
    let launched = VARIABLES.iter().any(|[rank, _]| env::var_os(rank).is_some());
    let bound = launched && allowed < wanted;
    let cores = all.map_or(String::new(), |all| format!(" of {all}"));
    let note = bound.then(|| {
        format!(
            "the launcher binds each rank to {allowed} core{}{cores}: for {wanted} threads a rank start with mpirun --bind-to \
             none (Open MPI) or -bind-to none (MPICH)",
            if allowed == 1 { "" } else { "s" }
        )
    });
    (threads, note)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn several_threads_need_an_mpi_that_knows_of_them() {
        let levels = [Threading::Single, Threading::Funneled, Threading::Serialized, Threading::Multiple];
        for level in levels {
            assert!(level.admits(1), "{level}");
            assert_eq!(level.admits(2), level != Threading::Single, "{level}");
        }
        let error = admit(Threading::Single, 8).expect_err("too many").to_string();
        for fact in ["8 threads", "MPI_THREAD_FUNNELED", "MPI_THREAD_SINGLE", "--threads 1"] {
            assert!(error.contains(fact), "{error}");
        }
    }
}
