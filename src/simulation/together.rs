//! What ranks agree about, and sums over them.
use super::ledger::Report;
use crate::exec::ranks::{Network, NetworkError, collective, pack, unpack};
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
    let mut words = Vec::new();
    super::parcel::put(
        &mut words,
        mine.as_ref().err().map(ToString::to_string).unwrap_or_default().as_bytes(),
    );
    let all = collective::share(network, &words)?;
    let texts = all.iter().map(|words| super::parcel::take::<u8>(&mut &words[..]));
    let first = texts.enumerate().find(|(_, text)| !text.is_empty());
    match (mine, first) {
        (Ok(_), Some((rank, text))) => {
            Err(Error::Ranks(format!("rank {rank}: {}", String::from_utf8_lossy(&text))))
        }
        (mine, _) => mine,
    }
}

/// The numbers of all ranks, rank by rank.
///
/// # Errors
/// If a rank is gone.
pub fn all(network: &mut dyn Network, mine: &[u64]) -> output::Result<Vec<Vec<u64>>> {
    match network.size() {
        1 => Ok(vec![mine.to_vec()]),
        _ => Ok(collective::share(network, mine)?),
    }
}

/// The numbers of rank 0.
///
/// # Errors
/// If a rank is gone.
pub fn from_first(network: &mut dyn Network, mine: Vec<u64>) -> output::Result<Vec<u64>> {
    if network.size() == 1 {
        return Ok(mine);
    }
    let mut message = pack(&mine);
    collective::broadcast(network, &mut message)?;
    Ok(unpack(&message).to_vec())
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
