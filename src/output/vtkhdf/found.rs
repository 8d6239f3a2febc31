//! What there is of the frames of a run that goes on: looked at before anything is changed.
use super::index::{self, Index};
use super::{Entry, file, frame_file};
use crate::output::error::{Error, Result};
use crate::output::frame::Columns;
use crate::output::run_id::RunId;
use crate::output::{draft, seal, space};
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

/// Bytes that a restart finds room for before it changes anything.
const ROOM: usize = 1 << 15;

/// The first frames of a run, those that are whole.
#[derive(Debug)]
pub struct Found {
    pub(super) index: Index,
    /// How many there were.
    pub(super) frames: u64,
    /// Whether the index that is there names just these.
    pub(super) named: bool,
    /// Files in the place of the others, and what is wrong with each.
    pub(super) wrong: Vec<(PathBuf, String)>,
    pub(super) warnings: Vec<String>,
    /// Frames that are missing and were told one by one.
    lost: u64,
    /// Whether there is no index of this run.
    rebuilt: bool,
}

impl Found {
    /// The first `frames` frames of a run: what the index names, and, where it contradicts a file or is not this run's,
    /// what the files say of themselves.
    ///
    /// # Errors
    /// If the index or a frame is there and may not be read, or the folder cannot be written.
    pub fn look(path: &Path, run: RunId, frames: u64) -> Result<Self> {
        writable(path, frames)?;
        let index = Index { run, columns: Columns::default(), entries: Vec::new() };
        let mut found = Self {
            index,
            frames,
            named: false,
            wrong: Vec::new(),
            warnings: Vec::new(),
            lost: 0,
            rebuilt: false,
        };
        let known = found.known(path, run)?;
        let mut entries: HashMap<u64, Entry> =
            known.entries.iter().map(|entry| (entry.number, *entry)).collect();
        let there = super::numbered(path).into_iter().map(|(number, _)| number);
        let numbers: BTreeSet<u64> = there.chain(entries.keys().copied()).filter(|n| *n < frames).collect();
        for number in numbers {
            found.frame(&file(path, number), number, entries.remove(&number), &known.columns)?;
        }
        found.named = found.index.entries == known.entries && path.is_file();
        // what an index of this run does not name was told before
        let told = if found.rebuilt { found.lost + found.wrong.len() as u64 } else { frames };
        let missing = frames - found.index.entries.len() as u64;
        if missing > told {
            let missing = missing - told;
            found.warnings.push(format!("{}: {missing} of its {frames} frames are missing", path.display()));
        }
        Ok(found)
    }

    /// What the index says, if it is this run's.
    fn known(&mut self, path: &Path, run: RunId) -> Result<Index> {
        let problem = match index::read(path) {
            Ok(index) if index.run == run => return Ok(index),
            Ok(_) => format!("{}: it is the index of another run", path.display()),
            Err(error) if error.is_denied() => return Err(error),
            Err(error) => error.to_string(),
        };
        self.rebuilt = true;
        if self.frames > 0 {
            self.warnings.push(format!("{problem}. It is made anew of its frames"));
        }
        Ok(self.index.clone())
    }

    /// Looks at a frame, which the index has as `entry`, if it has it.
    fn frame(&mut self, path: &Path, number: u64, entry: Option<Entry>, columns: &Columns) -> Result<()> {
        let stated = seal::stated(path);
        if let (Ok(digest), Some(entry)) = (&stated, entry)
            && *digest == entry.digest
        {
            self.take(path, entry, columns);
            return Ok(());
        }
        match stated.and_then(|_| frame_file::describe(path, self.index.run, number)) {
            Ok((its, columns)) => {
                if entry.is_some() {
                    let name = path.display();
                    self.warnings.push(format!(
                        "{name}: the index names another frame there; this one is of this run, and kept"
                    ));
                }
                self.take(path, its, &columns);
            }
            Err(error) if error.is_denied() => return Err(error),
            Err(error) if error.is_missing() => {
                if entry.is_some() {
                    self.warnings.push(format!("{error}; the frame is left out"));
                    self.lost += 1;
                }
            }
            Err(error) => self.wrong.push((path.into(), error.to_string())),
        }
        Ok(())
    }

    fn take(&mut self, path: &Path, entry: Entry, columns: &Columns) {
        if self.index.entries.is_empty() {
            self.index.columns = columns.clone();
        }
        let later = self.index.entries.last().is_none_or(|last| last.step < entry.step);
        let problem = match self.index.columns == *columns {
            true if later => return self.index.entries.push(entry),
            true => "it is not later than the frame before it",
            false => "it has other fields",
        };
        self.wrong.push((path.into(), format!("{}: {problem}", path.display())));
    }
}

/// Whether there is room for the index, and the frames from `frames` on can be written.
fn writable(index: &Path, frames: u64) -> Result<()> {
    let folder = super::folder(index);
    let size = std::fs::metadata(index).map_or(0, |found| found.len()) as usize;
    let blocked = |path: &Path, problem: &str| Error::Content { path: path.into(), problem: problem.into() };
    match std::fs::metadata(&folder) {
        Ok(found) if !found.is_dir() => {
            return Err(blocked(&folder, "it is no folder, where a run has its frames: move it away"));
        }
        Ok(_) => space::probe(&draft::aside(&folder.join(index::CELLS)), ROOM)?,
        Err(_) => {}
    }
    let later = super::numbered(index).into_iter().filter(|(number, _)| *number >= frames);
    if let Some((_, path)) = later.into_iter().find(|(_, path)| path.is_dir()) {
        return Err(blocked(&path, "it is a folder, where a run writes a frame: move it away"));
    }
    space::probe(&draft::aside(index), 2 * size + ROOM)
}
