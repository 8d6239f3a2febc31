//! What there is of the frames of a run that goes on: looked at before anything is changed.
use super::index::{self, Index};
use super::{Entry, FileId, named, part_file};
use crate::output::error::{Error, Result};
use crate::output::frame::Columns;
use crate::output::run_id::RunId;
use crate::output::{draft, seal, space};
use std::collections::BTreeMap;
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
    /// Files in the place of the others, and what is wrong with each of them.
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
        let mut frames_there: BTreeMap<u64, (Option<Entry>, Vec<FileId>)> = BTreeMap::new();
        for entry in known.entries.iter().filter(|entry| entry.number < frames) {
            frames_there.entry(entry.number).or_default().0 = Some(entry.clone());
        }
        for (id, _) in named::list(path).into_iter().filter(|(id, _)| id.number < frames) {
            frames_there.entry(id.number).or_default().1.push(id);
        }
        for (number, (entry, there)) in frames_there {
            found.frame(path, number, entry, &there, &known.columns)?;
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

    /// Looks at a frame, which the index has as `entry`, if it has it, and of which these files are there.
    fn frame(
        &mut self,
        index: &Path,
        number: u64,
        entry: Option<Entry>,
        there: &[FileId],
        columns: &Columns,
    ) -> Result<()> {
        let as_named = |entry: &Entry| {
            let mut files = entry.files();
            files.all(|(id, part)| seal::stated(&id.path(index)).is_ok_and(|digest| digest == part.digest))
        };
        let is_named = entry.is_some();
        let parts = match entry {
            Some(entry) if as_named(&entry) => {
                self.take(index, entry, columns);
                return Ok(());
            }
            Some(entry) if there.iter().any(|id| id.parts == entry.parts.len()) => entry.parts.len(),
            Some(entry) => there.first().map_or(entry.parts.len(), |id| id.parts),
            None => there.first().map_or(1, |id| id.parts),
        };
        let Some((its, columns)) = self.of_files(index, (number, parts), is_named)? else { return Ok(()) };
        if is_named {
            let path = FileId { number, parts, part: 0 }.path(index);
            self.warnings.push(format!(
                "{}: the index names another frame there; this one is of this run, and kept",
                path.display()
            ));
        }
        self.take(index, its, &columns);
        Ok(())
    }

    /// A frame as its files say, if all of them are there, whole, and belong together. What is missing is told of a frame
    /// that the index names.
    fn of_files(
        &mut self,
        index: &Path,
        (number, parts): (u64, usize),
        is_named: bool,
    ) -> Result<Option<(Entry, Columns)>> {
        let (mut all, mut first, mut whole) = (Vec::new(), None, true);
        for id in FileId::of_frame(number, parts) {
            match part_file::describe(index, id, self.index.run) {
                Ok(its) => {
                    all.push(its.part);
                    let first = first.get_or_insert_with(|| its.of_frame.clone());
                    if *first != its.of_frame {
                        let (path, one) = (id.path(index), FileId { part: 0, ..id }.name());
                        let problem =
                            format!("{}: it is no part of the frame that {one} is of", path.display());
                        self.wrong.push((path, problem));
                        whole = false;
                    }
                }
                Err(error) if error.is_denied() => return Err(error),
                Err(error) if error.is_missing() => {
                    if is_named {
                        self.warnings.push(format!("{error}; the frame is left out"));
                        self.lost += u64::from(whole);
                    }
                    return Ok(None);
                }
                Err(error) => {
                    self.wrong.push((id.path(index), error.to_string()));
                    whole = false;
                }
            }
        }
        Ok(first
            .filter(|_| whole)
            .map(|its| (Entry { number, time: its.time, step: its.step, parts: all }, its.columns)))
    }

    fn take(&mut self, index: &Path, entry: Entry, columns: &Columns) {
        if self.index.entries.is_empty() {
            self.index.columns = columns.clone();
        }
        let later = self.index.entries.last().is_none_or(|last| last.step < entry.step);
        let problem = match self.index.columns == *columns {
            true if later => return self.index.entries.push(entry),
            true => "it is not later than the frame before it",
            false => "it has other fields",
        };
        let paths = entry.files().map(|(id, _)| id.path(index));
        self.wrong.extend(paths.map(|path| (path.clone(), format!("{}: {problem}", path.display()))));
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
    let later = named::list(index).into_iter().filter(|(id, _)| id.number >= frames);
    if let Some((_, path)) = later.into_iter().find(|(_, path)| path.is_dir()) {
        return Err(blocked(&path, "it is a folder, where a run writes a frame: move it away"));
    }
    space::probe(&draft::aside(index), 2 * size + ROOM)
}
