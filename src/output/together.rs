//! What ranks agree about.
use super::{Error, Result};
use engine::exec::ranks::{Network, collective};

/// The outcome of something that only some ranks did: all of them go on, or none does. A rank that did not fail itself
/// gets the error of the first one that did, in words.
///
/// # Errors
/// If it failed on any rank, or a rank is gone.
pub fn agree<T>(network: &mut dyn Network, mine: Result<T>) -> Result<T> {
    if network.size() == 1 {
        return mine;
    }
    let problem = mine.as_ref().err().map(ToString::to_string);
    match (mine, collective::first_error(network, problem.as_deref())?) {
        (Ok(_), Some((rank, problem))) => Err(Error::Ranks(format!("rank {rank}: {problem}"))),
        (mine, _) => mine,
    }
}
