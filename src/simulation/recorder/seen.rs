//! A checkpoint that rank 0 has found, on ranks of other hosts: a path may lead to nothing there, or to another run.
use crate::output::checkpoint::Reader;
use crate::output::{Error, Result, seal, together};
use engine::exec::ranks::{Network, collective, launch};
use std::io::ErrorKind;
use std::path::Path;

const REMEDY: &str = "all ranks read it: put the folder of the run where all hosts see it, under one path, or start all ranks on \
    the host that has it";

/// Opens on all ranks what rank 0, which has checked its seal, sees at `path`.
///
/// # Errors
/// If a rank sees nothing there, or another file: on all ranks.
pub fn open(network: &mut dyn Network, path: &Path) -> Result<Reader> {
    let mine = seal::stated(path);
    let wanted = mine.as_ref().map_or(0, |digest| *digest).to_le_bytes();
    let wanted = collective::bytes_from_first(network, &wanted)?;
    let seen = same(path, mine, &wanted).and_then(|()| Reader::open_verified(path));
    together::agree(network, seen)
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
