//! Ordinary files to read: a pipe of such a name would never end to open, and a folder is none.
use super::error::{Error, Result, io};
use std::fs::File;
use std::path::Path;

/// Opens a file.
///
/// # Errors
/// If it cannot be read, or is no ordinary file.
pub fn open(path: &Path) -> Result<File> {
    if !std::fs::metadata(path).map_err(io("open", path))?.is_file() {
        return Err(Error::Content { path: path.into(), problem: "it is no file".into() });
    }
    File::open(path).map_err(io("open", path))
}

/// Reads a text.
///
/// # Errors
/// If it cannot be read, or is no text.
pub fn read(path: &Path) -> Result<String> {
    let bytes = open(path).and_then(|mut file| {
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut file, &mut bytes).map_err(io("read", path))?;
        Ok(bytes)
    })?;
    let problem = "it is damaged: it is not text";
    String::from_utf8(bytes).map_err(|_| Error::Content { path: path.into(), problem: problem.into() })
}
