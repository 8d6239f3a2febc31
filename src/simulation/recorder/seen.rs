//! What rank 0 has found or made, on ranks of other hosts: a path may lead to nothing there, or to another run.
use crate::output::checkpoint::{self, Reader};
use crate::output::run_id::RunId;
use crate::output::vtkhdf::Token;
use crate::output::{Error, Result, seal, together};
use engine::exec::ranks::{Network, collective, launch};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

const REMEDY: &str = "all ranks read it: put the folder of the run where all hosts see it, under one path, or start all ranks on \
    the host that has it";

/// The last whole checkpoint of a folder, open on all ranks, and the damaged ones after it with what is wrong with them.
/// Rank 0 looks for it.
///
/// # Errors
/// If there is none, or it cannot be read: on all ranks.
pub fn last_checkpoint(network: &mut dyn Network, folder: &Path) -> Result<(Reader, checkpoint::Found)> {
    let found = match network.rank() {
        0 => checkpoint::last_whole(folder).map(Some),
        _ => Ok(None),
    };
    let found = together::agree(network, found)?;
    let path = found.as_ref().map_or_else(PathBuf::new, |found| found.path.clone());
    let path = together::path_from_first(network, &path)?;
    let reader = open(network, &path)?;
    let none = checkpoint::Found { path, damaged: Vec::new(), warnings: Vec::new() };
    Ok((reader, found.unwrap_or(none)))
}

/// Opens on all ranks what rank 0, which has checked its seal, sees at `path`.
///
/// # Errors
/// If a rank sees nothing there, or another file: on all ranks.
fn open(network: &mut dyn Network, path: &Path) -> Result<Reader> {
    let mine = seal::stated(path);
    let wanted = mine.as_ref().map_or(0, |digest| *digest).to_le_bytes();
    let wanted = collective::bytes_from_first(network, &wanted)?;
    let seen = same(path, mine, &wanted).and_then(|()| Reader::open_verified(path));
    together::agree(network, seen)
}

/// Which ranks see the folder of the frames that rank 0 has. `name` is one that no file has yet.
///
/// # Errors
/// If it cannot be written: on all ranks.
pub fn folder(network: &mut dyn Network, index: &Path, name: RunId) -> Result<Vec<bool>> {
    if network.size() == 1 {
        return Ok(vec![true]);
    }
    let token = match network.rank() {
        0 => Token::show(index, name).map(Some),
        _ => Ok(None),
    };
    let token = together::agree(network, token)?;
    let all = collective::share(network, &[u64::from(Token::is_seen(index, name))])?;
    drop(token);
    Ok(all.iter().map(|seen| seen[0] == 1).collect())
}

fn same(path: &Path, mine: Result<u128>, wanted: &[u8]) -> Result<()> {
    let problem = match mine {
        Ok(digest) if digest.to_le_bytes() == *wanted => return Ok(()),
        Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound => {
            "does not see this checkpoint, which rank 0 has found".into()
        }
        Err(Error::Io { source, .. }) => {
            format!("cannot read this checkpoint, which rank 0 has read: {source}")
        }
        _ => "sees another file than rank 0 under this name".into(),
    };
    Err(Error::Content { path: path.into(), problem: format!("host {} {problem}; {REMEDY}", launch::host()) })
}
