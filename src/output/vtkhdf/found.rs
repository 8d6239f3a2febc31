//! What there is of the frames of a run that goes on: looked at before anything is changed.
use super::index::{self, Index};
use super::{Entry, file, frame_file};
use crate::output::error::Result;
use crate::output::frame::Field;
use crate::output::run_id::RunId;
use crate::output::seal;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

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
}

impl Found {
    /// The first `frames` frames of a run: what the index names, and, where it contradicts a file or is not this run's,
    /// what the files say of themselves.
    ///
    /// # Errors
    /// If the index or a frame is there and may not be read.
    pub fn look(path: &Path, run: RunId, frames: u64) -> Result<Self> {
        let index = Index { run, fields: Vec::new(), entries: Vec::new() };
        let mut found = Self { index, frames, named: false, wrong: Vec::new(), warnings: Vec::new() };
        let known = found.known(path, run)?;
        let mut entries: HashMap<u64, Entry> =
            known.entries.iter().map(|entry| (entry.number, *entry)).collect();
        for number in 0..frames {
            found.frame(&file(path, number), number, entries.remove(&number), &known.fields)?;
        }
        found.named = found.index.entries == known.entries && path.is_file();
        let missing = frames - found.index.entries.len() as u64;
        if missing > 0 && found.warnings.is_empty() && found.wrong.is_empty() {
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
        if self.frames > 0 {
            self.warnings.push(format!("{problem}. It is made anew of its frames"));
        }
        Ok(self.index.clone())
    }

    /// Looks at a frame, which the index has as `entry`, if it has it.
    fn frame(&mut self, path: &Path, number: u64, entry: Option<Entry>, fields: &[Field]) -> Result<()> {
        let stated = seal::stated(path);
        if let (Ok(digest), Some(entry)) = (&stated, entry)
            && *digest == entry.digest
        {
            self.take(path, entry, fields);
            return Ok(());
        }
        match stated.and_then(|_| frame_file::describe(path, self.index.run, number)) {
            Ok((its, fields)) => {
                if entry.is_some() {
                    let name = path.display();
                    self.warnings.push(format!(
                        "{name}: the index names another frame there; this one is of this run, and kept"
                    ));
                }
                self.take(path, its, &fields);
            }
            Err(error) if error.is_denied() => return Err(error),
            Err(error) if error.is_missing() => {
                if entry.is_some() {
                    self.warnings.push(format!("{error}; the frame is left out"));
                }
            }
            Err(error) => self.wrong.push((path.into(), error.to_string())),
        }
        Ok(())
    }

    fn take(&mut self, path: &Path, entry: Entry, fields: &[Field]) {
        if self.index.entries.is_empty() {
            self.index.fields = fields.to_vec();
        }
        match self.index.fields == fields {
            true => self.index.entries.push(entry),
            false => self.wrong.push((path.into(), format!("{}: it has other fields", path.display()))),
        }
    }
}
