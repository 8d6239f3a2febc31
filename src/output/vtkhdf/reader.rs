//! Reads frames back.
use super::index::{self, Index};
use super::{Entry, part_file};
use crate::output::error::{Error, Result};
use crate::output::frame::{Columns, Field};
use crate::output::snapshot::Snapshot;
use std::path::{Path, PathBuf};

/// The frames of a `particles.vtkhdf`.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    entries: Vec<Entry>,
    times: Vec<f64>,
    columns: Columns,
}

impl Reader {
    /// Opens an index that a [`super::Writer`] wrote, or is still writing.
    ///
    /// # Errors
    /// If the file is missing, damaged, or of another kind.
    pub fn open(path: &Path) -> Result<Self> {
        let Index { columns, entries, .. } = index::read(path)?;
        let times = entries.iter().map(|entry| entry.time).collect();
        Ok(Self { path: path.into(), entries, times, columns })
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        self.entries.len()
    }

    /// Particles of frame `k`; none where there is no such frame.
    pub fn particles(&self, k: usize) -> usize {
        self.entries.get(k).map_or(0, Entry::particles)
    }

    /// Time of each frame [s].
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Fields of every frame.
    pub fn fields(&self) -> &[Field] {
        &self.columns.fields
    }

    /// Names of the materials, in the order of their indices; none in files of old.
    pub fn materials(&self) -> &[String] {
        &self.columns.materials
    }

    /// Frame `k` with all fields.
    ///
    /// # Errors
    /// If there is no such frame, or it is missing or damaged.
    pub fn frame(&self, k: usize) -> Result<Snapshot> {
        let names: Vec<&str> = self.fields().iter().map(|f| f.name.as_str()).collect();
        self.frame_with(k, &names)
    }

    /// Frame `k` with those of the named fields that the file has.
    ///
    /// # Errors
    /// If there is no such frame, or it is missing or damaged.
    pub fn frame_with(&self, k: usize, names: &[&str]) -> Result<Snapshot> {
        let Some(entry) = self.entries.get(k) else {
            let problem = format!("there is no frame {k}: the file has {} (counted from 0)", self.frames());
            return Err(Error::Content { path: self.path.clone(), problem });
        };
        part_file::read(&self.path, entry, self.fields(), names)
    }
}
