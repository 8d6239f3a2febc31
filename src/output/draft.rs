//! HDF5 files of Sinew's, written aside and put in place when they are whole: whoever looks, at any moment and after any
//! kill, finds the old file or the new one.
use super::create::{create, remove};
use super::error::{self, Result};
use super::{seal, space, stored};
use hdf5::File;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

const EXTENSION: &str = "part";

/// A file that is being written. Dropped before its end, it leaves nothing behind.
#[derive(Debug)]
pub struct Draft {
    file: File,
    aside: Aside,
    path: PathBuf,
}

/// Where it lies meanwhile.
#[derive(Debug)]
struct Aside(PathBuf);

impl Drop for Aside {
    fn drop(&mut self) {
        // best effort: what matters is the error for which it is given up; and where it is in place there is none
        let _ = remove(&self.0);
    }
}

impl Draft {
    /// Begins the file at `path`, with room for its first `bytes`.
    ///
    /// # Errors
    /// If the disk is full or the folder cannot be written.
    pub fn create(path: &Path, bytes: usize) -> Result<Self> {
        let aside = Aside(aside(path));
        create(&aside.0)?;
        space::reserve(&aside.0, bytes)?;
        let file = stored::create(&aside.0)?;
        Ok(Self { file, aside, path: path.into() })
    }

    /// Makes room for more bytes, before HDF5 asks for it.
    ///
    /// # Errors
    /// If the disk is full.
    pub fn reserve(&self, bytes: usize) -> Result<()> {
        space::reserve(&self.aside.0, bytes)
    }

    /// Writes into the file.
    ///
    /// # Errors
    /// If HDF5 cannot.
    pub fn write<T>(&self, act: impl FnOnce(&File) -> hdf5::Result<T>) -> Result<T> {
        act(&self.file).map_err(error::hdf5("write", &self.aside.0))
    }

    /// Seals the file and puts it in place; its digest. Nothing of it may be open any more.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> Result<u128> {
        self.place(|_| Ok(()))
    }

    /// The same, when the disk has all of it.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish_on_disk(self) -> Result<u128> {
        let path = self.path.clone();
        let digest = self.place(seal::sync)?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        seal::sync(folder.unwrap_or(Path::new(".")))?;
        Ok(digest)
    }

    fn place(self, wait: impl FnOnce(&Path) -> Result<()>) -> Result<u128> {
        let Self { file, aside, path } = self;
        let length = file.flush().map(|()| file.size()).map_err(error::hdf5("write", &aside.0))?;
        file.close().map_err(error::hdf5("close", &aside.0))?;
        space::trim(&aside.0, length)?;
        let digest = seal::seal(&aside.0)?;
        wait(&aside.0)?;
        std::fs::rename(&aside.0, &path).map_err(error::io("rename", &aside.0))?;
        Ok(digest)
    }
}

/// Where the draft of a file lies.
pub fn aside(path: &Path) -> PathBuf {
    path.with_added_extension(EXTENSION)
}

/// The file that this would have become, if a draft has such a name.
pub fn of(path: &Path) -> Option<PathBuf> {
    (path.extension() == Some(OsStr::new(EXTENSION))).then(|| path.with_extension(""))
}
