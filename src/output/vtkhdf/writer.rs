//! Keeps the index of frames whose files are written.
use super::index::{self, Index};
use super::{Entry, FileId, Found, Part, folder, token};
use crate::output::create::{remove, set_aside};
use crate::output::error::{self, Error, Result};
use crate::output::frame::{Columns, Field, Head};
use crate::output::run_id::RunId;
use crate::output::{draft, seal};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// So many files the index names at once. More it names as often as that takes one part in `SHARE` of the time, and when the disk is to have all:
/// its length, and so the time to write it, grows with their number.
const PROMPT: usize = 64;
const SHARE: u32 = 20;

/// Writes `particles.vtkhdf`. What it names is whole and readable after every frame.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    run: RunId,
    /// Of the first frame, fields by name; empty before it.
    columns: Columns,
    entries: Vec<Entry>,
    /// Vertices that frames share.
    cells: usize,
    /// Frames that the index names.
    named: usize,
    /// When it was written, and how long that took.
    index: (Instant, Duration),
}

impl Writer {
    /// A new index of a run, without frames. An old one of that name is replaced, and its frames are deleted.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(path: &Path, run: RunId) -> Result<Self> {
        own_folder(path)?;
        // the index first: it must not name what is no longer there
        index::write(path, run, &Columns::default(), &[])?;
        forget_from(path, 0)?;
        Ok(Self::at(path, Index { run, columns: Columns::default(), entries: Vec::new() }))
    }

    /// Goes on after a restart with the frames that were found. Says what was not as it should be.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn resume(path: &Path, found: Found) -> Result<(Self, Vec<String>)> {
        let Found { index, frames, named, wrong, mut warnings, .. } = found;
        own_folder(path)?;
        for (file, problem) in &wrong {
            let aside = set_aside(file)?;
            warnings.push(format!("{problem}; it is now {}, and left out of the frames", aside.display()));
        }
        if !named {
            index::write(path, index.run, &index.columns, &index.entries)?;
        }
        forget_from(path, frames)?;
        Ok((Self::at(path, index), warnings))
    }

    fn at(path: &Path, Index { run, columns, entries }: Index) -> Self {
        let (named, index) = (entries.len(), (Instant::now(), Duration::ZERO));
        Self { path: path.into(), run, columns, entries, cells: 0, named, index }
    }

    /// Whether a frame with these columns can be one of them.
    ///
    /// # Errors
    /// If its fields differ from those of the first frame.
    pub fn admits(&self, columns: &Columns) -> Result<()> {
        let columns = columns.clone().sorted();
        if self.entries.is_empty() || columns == self.columns {
            return Ok(());
        }
        let list = |f: &[Field]| f.iter().map(|f| f.name.clone()).collect::<Vec<_>>().join(", ");
        let problem = format!(
            "the fields of a frame changed from [{}] to [{}]; write other fields to another file",
            list(&self.columns.fields),
            list(&columns.fields)
        );
        Err(Error::Content { path: self.path.clone(), problem })
    }

    /// One more frame, whose files are in place.
    pub fn add(&mut self, number: u64, head: Head, parts: Vec<Part>) {
        self.columns = head.columns.sorted();
        self.entries.push(Entry { number, time: head.time, step: head.step, parts });
    }

    /// Writes the index if frames came after it, and it is short, or was not written for a while.
    ///
    /// # Errors
    /// If it cannot be written: the last frame does not count.
    pub fn name_soon(&mut self) -> Result<()> {
        let (last, took) = self.index;
        let files: usize = self.entries.iter().map(|entry| entry.parts.len()).sum();
        if files > PROMPT && last.elapsed() <= SHARE * took {
            return Ok(());
        }
        self.name_all().inspect_err(|_| drop(self.entries.pop()))
    }

    /// Writes the index, if frames came after it.
    fn name_all(&mut self) -> Result<()> {
        if self.named == self.entries.len() {
            return Ok(());
        }
        let began = Instant::now();
        let most = self.entries.iter().map(Entry::particles).max().unwrap_or(0);
        if self.cells < most {
            index::write_cells(&self.path, most)?;
            self.cells = most;
        }
        index::write(&self.path, self.run, &self.columns, &self.entries)?;
        (self.named, self.index) = (self.entries.len(), (Instant::now(), began.elapsed()));
        Ok(())
    }

    /// Waits until the index names all frames, and the disk has it.
    ///
    /// # Errors
    /// If it does not take it.
    pub fn sync(&mut self) -> Result<()> {
        self.name_all()?;
        seal::sync(&self.path)
    }
}

/// The folder of the frames is one, and not a link to another.
fn own_folder(index: &Path) -> Result<()> {
    refuse_link(index)?;
    let folder = folder(index);
    match fs::create_dir(&folder) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => Err(error::io("create", &folder)(error)),
        _ => Ok(()),
    }
}

/// Refuses a folder of frames that lies elsewhere.
///
/// # Errors
/// If it does.
pub fn refuse_link(index: &Path) -> Result<()> {
    let folder = folder(index);
    if !fs::symlink_metadata(&folder).is_ok_and(|found| found.is_symlink()) {
        return Ok(());
    }
    let problem =
        "it is a link to another folder, in which a run does not write: put that folder in its place";
    Err(Error::Content { path: folder, problem: problem.into() })
}

/// Deletes all frames of an index that is no longer there. A link to a folder of frames goes, what it points to stays.
///
/// # Errors
/// If they cannot be deleted.
pub fn remove_frames(index: &Path) -> Result<()> {
    let folder = folder(index);
    match fs::symlink_metadata(&folder) {
        Ok(found) if found.is_symlink() => remove(&folder),
        Ok(found) if found.is_dir() => {
            forget_from(index, 0)?;
            remove(&folder.join(index::CELLS))?;
            // what others have put there stays
            let _ = fs::remove_dir(&folder);
            Ok(())
        }
        _ => Ok(()),
    }
}

/// Deletes the frames from a number on, and unfinished ones.
fn forget_from(index: &Path, first: u64) -> Result<()> {
    let entries = fs::read_dir(folder(index)).into_iter().flatten().flatten().map(|entry| entry.path());
    let goes = |path: &PathBuf| match draft::of(path) {
        Some(whole) => FileId::of(&whole).is_some(),
        None if token::is_one(path) => true,
        None => FileId::of(path).is_some_and(|id| id.number >= first),
    };
    entries.filter(goes).try_for_each(|path| remove(&path))
}
