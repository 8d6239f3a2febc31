//! HDF5 files as Sinew opens them: without locks, under names that need not be text, and with nothing in them that lies
//! elsewhere.
use super::error::{Error, Result, hdf5 as wrong};
use hdf5::plist::dataset_create::Layout;
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File, FileBuilder, Group, H5Type, IndexType, IterationOrder, LinkType};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Groups within groups at most: a file may hold itself.
const DEPTH: usize = 8;
/// The most that deflate makes of a byte, rounded up.
const LARGEST_RATIO: u64 = 1100;

/// Which datasets may be made of those of other files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Virtual {
    /// Some: they are not read.
    Passed,
    /// None.
    Refused,
}

/// A new file, in place of an empty one that was made before.
///
/// # Errors
/// If HDF5 cannot write it.
pub fn create(path: &Path) -> Result<File> {
    named(path, |name| unlocked().create(name)).map_err(wrong("create", path))
}

/// A file to read, whose seal was checked.
///
/// # Errors
/// If it is no HDF5 file, or takes a part of it from elsewhere.
pub fn open(path: &Path, others: Virtual) -> Result<File> {
    let file = named(path, |name| unlocked().open(name)).map_err(wrong("open", path))?;
    let elsewhere = elsewhere(&file, others, DEPTH).map_err(wrong("read", path))?;
    match elsewhere {
        None => Ok(file),
        Some(name) => Err(Error::Content {
            path: path.into(),
            problem: format!(
                "{name} in it lies in another place, which is not read: Sinew has not written this"
            ),
        }),
    }
}

/// A dataset of `rows` rows of `width` numbers, flat.
///
/// # Errors
/// If there is none of that name and shape.
pub fn table<T: H5Type>(group: &Group, name: &str, rows: usize, width: usize) -> hdf5::Result<Vec<T>> {
    let dataset = group.dataset(name)?;
    let shape = dataset.shape();
    let fits = shape == [rows, width] || (width == 1 && shape == [rows]);
    if !fits {
        return Err(hdf5::Error::Internal(format!("{name} has the shape {shape:?}, not {rows} x {width}")));
    }
    refuse_bomb(&dataset, name)?;
    if rows * width == 0 { Ok(Vec::new()) } else { dataset.read_raw() }
}

/// A text as HDF5 has it.
///
/// # Errors
/// If there is a NUL in it.
pub fn word(text: &str) -> hdf5::Result<VarLenUnicode> {
    text.parse().map_err(|_| hdf5::Error::Internal("a text holds a NUL".into()))
}

/// Refuses a dataset that says that it is larger than its bytes can be.
///
/// # Errors
/// If it is, or cannot be read.
pub fn refuse_bomb(dataset: &Dataset, name: &str) -> hdf5::Result<()> {
    let size = dataset.dtype()?.size() as u64;
    let bytes = dataset.shape().iter().try_fold(size, |bytes, &count| bytes.checked_mul(count as u64));
    let most = dataset.file()?.size().saturating_mul(LARGEST_RATIO);
    if bytes.is_some_and(|bytes| bytes <= most) {
        return Ok(());
    }
    Err(hdf5::Error::Internal(format!("{name} has more numbers than bytes for them")))
}

/// Nobody else writes these files, and a file system without locks is no reason to fail.
fn unlocked() -> FileBuilder {
    let mut builder = File::with_options();
    builder.with_fapl(|access| access.file_locking(false));
    builder
}

/// The first thing in a group that is not in this file.
fn elsewhere(group: &Group, others: Virtual, depth: usize) -> hdf5::Result<Option<String>> {
    for (name, link) in group.links(IndexType::Name, IterationOrder::Native)? {
        if link.link_type != LinkType::Hard || depth == 0 {
            return Ok(Some(name));
        }
        if let Ok(inner) = group.group(&name) {
            if let Some(found) = elsewhere(&inner, others, depth - 1)? {
                return Ok(Some(format!("{name}/{found}")));
            }
            continue;
        }
        let made = group.dataset(&name)?.dcpl()?;
        let foreign = made.get_layout()? == Layout::Virtual && others == Virtual::Refused;
        if foreign || !made.get_external()?.is_empty() {
            return Ok(Some(name));
        }
    }
    Ok(None)
}

/// Gives HDF5, which takes names that are text, one for any path.
fn named<T>(path: &Path, act: impl FnOnce(&Path) -> hdf5::Result<T>) -> hdf5::Result<T> {
    if path.to_str().is_some() {
        return act(path);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let text = |problem: &str| hdf5::Error::Internal(format!("{}: {problem}", path.display()));
    let name = path.file_name().and_then(OsStr::to_str).ok_or_else(|| text("its name is not text"))?;
    // the folder is known by the number of its descriptor as long as this lives
    let opened = std::fs::File::open(folder).map_err(|error| text(&error.to_string()))?;
    act(&by_number(&opened).ok_or_else(|| text("its folder's name is not text"))?.join(name))
}

#[cfg(target_os = "linux")]
fn by_number(folder: &std::fs::File) -> Option<PathBuf> {
    Some(PathBuf::from(format!("/proc/self/fd/{}", std::os::fd::AsRawFd::as_raw_fd(folder))))
}

#[cfg(not(target_os = "linux"))]
fn by_number(_: &std::fs::File) -> Option<PathBuf> {
    None
}
