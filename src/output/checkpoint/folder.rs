//! The checkpoints in a run's folder.
use super::seal;
use crate::output::error::{Error, Result, io};
use std::fs;
use std::path::{Path, PathBuf};

/// The file of a checkpoint after `steps` steps.
pub fn path(folder: &Path, steps: u64) -> PathBuf {
    folder.join(format!("checkpoint-{steps:08}.h5"))
}

/// Where it is written before it is whole.
pub(super) fn aside(path: &Path) -> PathBuf {
    path.with_added_extension("part")
}

/// Removes what there is of a checkpoint that could not be written.
pub fn discard(path: &Path) {
    // best effort: the error that matters is why it could not be written
    let _ = fs::remove_file(aside(path));
}

/// Steps of a checkpoint, from its file's name.
fn steps(path: &Path) -> Option<u64> {
    path.file_name()?.to_str()?.strip_prefix("checkpoint-")?.strip_suffix(".h5")?.parse().ok()
}

/// The checkpoints in a folder, the latest first, whether whole or not.
pub fn list(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<_> = entries.filter_map(|e| Some((steps(&e.path())?, e.path()))).collect();
    found.sort_by(|a, b| b.cmp(a));
    found.into_iter().map(|(_, path)| path).collect()
}

/// The last whole checkpoint of a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Its file.
    pub path: PathBuf,
    /// Later ones that are damaged.
    pub damaged: Vec<PathBuf>,
    /// What is wrong with these, in words.
    pub warnings: Vec<String>,
}

/// The last checkpoint whose seal is unbroken.
///
/// # Errors
/// If there is none: why each of them cannot be used.
pub fn last_whole(folder: &Path) -> Result<Found> {
    let (mut damaged, mut warnings) = (Vec::new(), Vec::new());
    for path in list(folder) {
        match seal::verify(&path) {
            Ok(()) => return Ok(Found { path, damaged, warnings }),
            Err(error) => {
                warnings.push(error.to_string());
                damaged.push(path);
            }
        }
    }
    let problem = match warnings.as_slice() {
        [] => "holds no checkpoint, so there is nothing to go on from; scenes ask for them in [output.checkpoint]".into(),
        reasons => format!("holds no whole checkpoint: {}", reasons.join("; ")),
    };
    Err(Error::Content { path: folder.into(), problem })
}

/// Renames damaged checkpoints, so that nobody takes them for one, and removes unfinished ones.
///
/// # Errors
/// If the folder cannot be written.
pub fn set_aside(folder: &Path, damaged: &[PathBuf]) -> Result<()> {
    for path in damaged {
        fs::rename(path, path.with_added_extension("damaged")).map_err(io("rename", path))?;
    }
    let unfinished = |path: &PathBuf| {
        path.extension().is_some_and(|extension| extension == "part")
            && steps(&path.with_extension("")).is_some()
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    for path in entries.filter(unfinished) {
        fs::remove_file(&path).map_err(io("remove", &path))?;
    }
    Ok(())
}

/// Deletes all but the last `kept` checkpoints.
///
/// # Errors
/// If one cannot be deleted.
pub fn prune(folder: &Path, kept: usize) -> Result<()> {
    for path in list(folder).into_iter().skip(kept) {
        fs::remove_file(&path).map_err(io("remove", &path))?;
    }
    Ok(())
}
