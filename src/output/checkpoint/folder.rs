//! The checkpoints in a run's folder.
use crate::output::create::{self, remove};
use crate::output::error::{Error, Result, io};
use crate::output::{draft, seal, vtkhdf};
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The file of a checkpoint after `steps` steps.
pub fn path(folder: &Path, steps: u64) -> PathBuf {
    folder.join(format!("checkpoint-{steps:08}.h5"))
}

/// Steps of a checkpoint, from its file's name.
fn steps(path: &Path) -> Option<u64> {
    path.file_name()?.to_str()?.strip_prefix("checkpoint-")?.strip_suffix(".h5")?.parse().ok()
}

/// The checkpoints in a folder, the latest first, whether whole or not. Folders and pipes of such a name are none.
pub fn list(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let files = entries.filter(|path| path.is_file());
    let mut found: Vec<_> = files.filter_map(|path| Some((steps(&path)?, path))).collect();
    found.sort_by(|a, b| b.cmp(a));
    found.into_iter().map(|(_, path)| path).collect()
}

/// The last whole checkpoint of a folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Its file.
    pub path: PathBuf,
    /// Later ones that are damaged or another run's, but for files that never were checkpoints.
    pub damaged: Vec<PathBuf>,
    /// What is wrong with these, in words.
    pub warnings: Vec<String>,
}

/// The last checkpoint whose seal is unbroken, and that is of the run whose frames are there.
///
/// # Errors
/// If there is none: why each of them cannot be used; or if one may not be read.
pub fn last_whole(folder: &Path) -> Result<Found> {
    let (mut damaged, mut warnings) = (Vec::new(), Vec::new());
    // whose folder it is, says the index of the frames
    let owner = vtkhdf::run_of(&folder.join(vtkhdf::INDEX));
    let foreign =
        |path: &Path| owner.is_some_and(|owner| super::Reader::run_of(path).is_some_and(|run| run != owner));
    let mut others = Vec::new();
    for path in list(folder) {
        match seal::verify(&path) {
            Ok(_) if foreign(&path) => others.push(path),
            Ok(_) => {
                let told = |path: &PathBuf| format!("{}: it is a checkpoint of another run", path.display());
                warnings.extend(others.iter().map(told));
                damaged.extend(others);
                return Ok(Found { path, damaged, warnings });
            }
            // whoever goes on from an earlier one loses what somebody may still make readable
            Err(error) if error.is_denied() => return Err(error),
            Err(error) => {
                warnings.push(error.to_string());
                damaged.extend(is_hdf5(&path).then_some(path));
            }
        }
    }
    // then it is the index that is another run's
    if let Some(path) = others.into_iter().next() {
        return Ok(Found { path, damaged, warnings });
    }
    let problem = match warnings.as_slice() {
        [] => "holds no checkpoint, so there is nothing to go on from; scenes ask for them in [output.checkpoint]".into(),
        reasons => format!("holds no whole checkpoint: {}", reasons.join("; ")),
    };
    Err(Error::Content { path: folder.into(), problem })
}

/// Whether a file begins as HDF5 does.
fn is_hdf5(path: &Path) -> bool {
    let mut begin = [0; 8];
    let read = fs::File::open(path).and_then(|mut file| file.read_exact(&mut begin));
    read.is_ok() && begin == *b"\x89HDF\r\n\x1a\n"
}

/// Renames damaged checkpoints, so that nobody takes them for one, and removes unfinished ones.
///
/// # Errors
/// If the folder cannot be written.
pub fn set_aside(folder: &Path, damaged: &[PathBuf]) -> Result<()> {
    for path in damaged {
        create::set_aside(path)?;
    }
    let unfinished = |path: &PathBuf| draft::of(path).is_some_and(|whole| steps(&whole).is_some());
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    for path in entries.filter(unfinished) {
        fs::remove_file(&path).map_err(io("remove", &path))?;
    }
    Ok(())
}

/// Deletes all but the last `kept` checkpoints. What only has such a name neither counts nor goes.
///
/// # Errors
/// If one cannot be deleted.
pub fn prune(folder: &Path, kept: usize) -> Result<()> {
    for path in list(folder).into_iter().filter(|path| seal::stated(path).is_ok()).skip(kept) {
        remove(&path)?;
    }
    Ok(())
}
