//! A file that is there for a moment, so that ranks learn who of them sees the folder of the frames.
use super::folder;
use crate::output::create::{create, remove};
use crate::output::error::Result;
use crate::output::run_id::RunId;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

const EXTENSION: &str = "token";

/// Such a file, until this is dropped.
#[derive(Debug)]
pub struct Token(PathBuf);

impl Token {
    /// Puts it there under a new name: a folder that looks the same on another host does not have it.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn show(index: &Path, name: RunId) -> Result<Self> {
        let token = Self(path(index, name));
        create(&token.0)?;
        Ok(token)
    }

    /// Whether it is seen here.
    pub fn is_seen(index: &Path, name: RunId) -> bool {
        path(index, name).is_file()
    }
}

impl Drop for Token {
    fn drop(&mut self) {
        // one that stays goes with the next start
        let _ = remove(&self.0);
    }
}

fn path(index: &Path, name: RunId) -> PathBuf {
    folder(index).join(format!("{name}.{EXTENSION}"))
}

/// Whether a file is one.
pub fn is_one(path: &Path) -> bool {
    path.extension() == Some(OsStr::new(EXTENSION))
}
