//! What ranks agree about.
use super::{Error, Result};
use engine::exec::ranks::{Network, NetworkError, collective};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

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

/// A path of rank 0, on all ranks, byte by byte: a path need not be text.
///
/// # Errors
/// If a rank is gone.
pub fn path_from_first(network: &mut dyn Network, path: &Path) -> std::result::Result<PathBuf, NetworkError> {
    let bytes = collective::bytes_from_first(network, path.as_os_str().as_encoded_bytes())?;
    Ok(PathBuf::from(os_string(bytes)))
}

#[cfg(unix)]
fn os_string(bytes: Vec<u8>) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(bytes)
}

#[cfg(not(unix))]
fn os_string(bytes: Vec<u8>) -> OsString {
    String::from_utf8_lossy(&bytes).into_owned().into()
}
