//! Room on the disk, taken before HDF5 writes.
//!
//! HDF5 (1.10.8) that meets a full disk leaves a damaged file, and closing that file can crash the process. So room is
//! made first, with writes of our own whose failure is an ordinary error: HDF5 then only overwrites blocks it has.
use super::error::{Result, io};
use std::fs::OpenOptions;
use std::io::Write;
use std::path::Path;

/// Lengthens the file by `bytes` of zeros. If that fails, the file is as it was.
///
/// # Errors
/// If the disk is full.
pub fn reserve(path: &Path, bytes: usize) -> Result<()> {
    let mut file = OpenOptions::new().append(true).open(path).map_err(io("open", path))?;
    let length = file.metadata().map_err(io("open", path))?.len();
    let zeros = vec![0u8; bytes.min(1 << 20)];
    let mut missing = bytes;
    while missing > 0 {
        let piece = missing.min(zeros.len());
        if let Err(error) = file.write_all(&zeros[..piece]) {
            // Best effort: the error that matters is the one above.
            let _ = file.set_len(length);
            return Err(io("write", path)(error));
        }
        missing -= piece;
    }
    Ok(())
}

/// Gives back what was not used.
///
/// # Errors
/// If the file cannot be opened for writing.
pub fn trim(path: &Path, length: u64) -> Result<()> {
    let file = OpenOptions::new().write(true).open(path).map_err(io("open", path))?;
    file.set_len(length).map_err(io("trim", path))
}

/// Whether a file of so many bytes can be made at `path`, where there is none that matters.
///
/// # Errors
/// If the disk is full, or the folder cannot be written.
pub fn probe(path: &Path, bytes: usize) -> Result<()> {
    super::create::create(path)?;
    let room = reserve(path, bytes);
    super::create::remove(path)?;
    room
}
