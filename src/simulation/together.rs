//! What ranks agree about, and sums over them.
use super::ledger::Report;
use crate::exec::ranks::{Network, NetworkError, collective};
use crate::output::{self, Error};

/// The outcome of something that only some ranks did: all of them go on, or none does. A rank that did not fail itself
/// gets the error of the first one that did, in words.
///
/// # Errors
/// If it failed on any rank, or a rank is gone.
pub fn agree<T>(network: &mut dyn Network, mine: output::Result<T>) -> output::Result<T> {
    if network.size() == 1 {
        return mine;
    }
    let problem = mine.as_ref().err().map(ToString::to_string);
    match (mine, collective::first_error(network, problem.as_deref())?) {
        (Ok(_), Some((rank, problem))) => Err(Error::Ranks(format!("rank {rank}: {problem}"))),
        (mine, _) => mine,
    }
}

/// Counts the particles of all ranks in a report, of which the rest is the same on all of them.
///
/// # Errors
/// If a rank is gone.
pub fn count_particles(network: &mut dyn Network, report: &mut Report) -> Result<(), NetworkError> {
    let mut counts: Vec<u64> = report.materials.iter().map(|material| material.particles).collect();
    collective::sum(network, &mut counts)?;
    report.materials.iter_mut().zip(counts).for_each(|(material, count)| material.particles = count);
    Ok(())
}
