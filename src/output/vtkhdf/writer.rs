//! Writes frames.
use super::frame_file::FrameFile;
use super::index::{self, Index};
use super::{Entry, Found, file, folder, number};
use crate::output::create::{remove, set_aside};
use crate::output::error::{self, Error, Result};
use crate::output::frame::{Columns, Field, Frame, Head, Piece};
use crate::output::run_id::RunId;
use crate::output::{draft, seal};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// So many frames the index names at once. More it names as often as that takes one part in `SHARE` of the time, and when the disk is to have all:
/// its length, and so the time to write it, grows with their number.
const PROMPT: usize = 64;
const SHARE: u32 = 20;

/// Writes `particles.vtkhdf` and its frames. What it names is whole and readable after every frame.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    run: RunId,
    /// Of the first frame, fields by name; empty before it.
    columns: Columns,
    entries: Vec<Entry>,
    /// Number of the next frame's file.
    next: u64,
    /// Vertices that frames share.
    cells: usize,
    /// Frames of which the disk may not have all.
    unsynced: Vec<PathBuf>,
    /// The frame that is being written.
    open: Option<FrameFile>,
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
        Ok(Self::at(path, Index { run, columns: Columns::default(), entries: Vec::new() }, 0))
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
        Ok((Self::at(path, index, frames), warnings))
    }

    fn at(path: &Path, Index { run, columns, entries }: Index, next: u64) -> Self {
        let (named, index) = (entries.len(), (Instant::now(), Duration::ZERO));
        let (path, unsynced) = (path.into(), Vec::new());
        Self { path, run, columns, entries, next, cells: 0, unsynced, open: None, named, index }
    }

    /// Writes one more frame that is in memory. Its fields must be those of the first frame.
    ///
    /// # Errors
    /// If the disk is full, or fields differ from the first frame's; frames written before stay.
    pub fn append(&mut self, frame: &dyn Frame) -> Result<()> {
        let fields = frame.fields();
        let piece = Piece {
            identities: frame.identities(),
            materials: frame.materials(),
            positions: frame.positions(),
            columns: fields.iter().map(|field| frame.column(field)).collect(),
        };
        let (time, step, particles) = (frame.time(), frame.step(), frame.particles());
        let columns = Columns { fields, materials: Vec::new() };
        self.begin(Head { time, step, particles, columns })?;
        self.piece(&piece)?;
        self.end()
    }

    /// Begins one more frame. Its fields must be those of the first frame.
    ///
    /// # Errors
    /// If there is no room for it on the disk, or fields differ from the first frame's.
    pub fn begin(&mut self, head: Head) -> Result<()> {
        self.open = None;
        let columns = head.columns.clone().sorted();
        if !self.entries.is_empty() && columns != self.columns {
            let list = |f: &[Field]| f.iter().map(|f| f.name.clone()).collect::<Vec<_>>().join(", ");
            let problem = format!(
                "the fields of a frame changed from [{}] to [{}]; write other fields to another file",
                list(&self.columns.fields),
                list(&columns.fields)
            );
            return Err(Error::Content { path: self.path.clone(), problem });
        }
        self.columns = columns;
        let particles = head.particles;
        let path = file(&self.path, self.next);
        self.open = Some(FrameFile::create(&path, self.run, head)?);
        let most = self.entries.iter().map(|entry| entry.particles).fold(particles, usize::max);
        if self.cells < most {
            index::write_cells(&self.path, most)?;
            self.cells = most;
        }
        Ok(())
    }

    /// Writes the next particles of the frame that was begun.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn piece(&mut self, piece: &Piece) -> Result<()> {
        let Some(open) = &mut self.open else { return Ok(()) };
        let written = open.piece(piece);
        if written.is_err() {
            self.open = None;
        }
        written
    }

    /// Ends the frame: from now on it counts.
    ///
    /// # Errors
    /// If it cannot be written, or pieces are missing; frames written before stay.
    pub fn end(&mut self) -> Result<()> {
        let Some(open) = self.open.take() else { return Ok(()) };
        let path = file(&self.path, self.next);
        let entry = open.finish(self.next)?;
        self.entries.push(entry);
        let (last, took) = self.index;
        if (self.entries.len() <= PROMPT || last.elapsed() > SHARE * took)
            && let Err(error) = self.name_all()
        {
            self.entries.pop();
            return Err(error);
        }
        self.unsynced.push(path);
        self.next += 1;
        Ok(())
    }

    /// Writes the index, if frames came after it.
    fn name_all(&mut self) -> Result<()> {
        if self.named == self.entries.len() {
            return Ok(());
        }
        let began = Instant::now();
        index::write(&self.path, self.run, &self.columns, &self.entries)?;
        (self.named, self.index) = (self.entries.len(), (Instant::now(), began.elapsed()));
        Ok(())
    }

    /// Number of frames that were begun so far, whether all are still there or not.
    pub fn frames(&self) -> u64 {
        self.next
    }

    /// Waits until the disk has all frames, and the index names them.
    ///
    /// # Errors
    /// If it does not take them.
    pub fn sync(&mut self) -> Result<()> {
        self.name_all()?;
        if self.unsynced.is_empty() {
            return Ok(());
        }
        for path in self.unsynced.drain(..) {
            seal::sync(&path)?;
        }
        seal::sync(&folder(&self.path))?;
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
        Some(whole) => number(&whole).is_some(),
        None => number(path).is_some_and(|n| n >= first),
    };
    entries.filter(goes).try_for_each(|path| remove(&path))
}
