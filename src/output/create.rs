//! Files of one's own: made anew, never written through a link to somewhere else.
use super::draft;
use super::error::{Result, io};
use std::fs::{self, File, OpenOptions};
use std::io::{self as std_io, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// A new, empty file. What had its name before, a symbolic link among others, is removed, and not what that pointed to. Devices stay, and
/// are written to.
///
/// # Errors
/// If the folder cannot be written, or a folder has that name.
pub fn create(path: &Path) -> Result<File> {
    let made = || -> std_io::Result<File> {
        if is_device(path) {
            return OpenOptions::new().write(true).open(path);
        }
        vanish(path)?;
        OpenOptions::new().write(true).create_new(true).open(path)
    };
    made().map_err(io("create", path))
}

/// Removes a file or a link, if there is one.
///
/// # Errors
/// If it cannot be removed.
pub fn remove(path: &Path) -> Result<()> {
    vanish(path).map_err(io("remove", path))
}

#[cfg(unix)]
fn is_device(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt;
    let kind = fs::symlink_metadata(path).map(|found| found.file_type());
    kind.is_ok_and(|kind| kind.is_char_device() || kind.is_block_device())
}

#[cfg(not(unix))]
fn is_device(_: &Path) -> bool {
    false
}

fn vanish(path: &Path) -> std_io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        result => result,
    }
}

/// Writes a file aside, waits until the disk has it, and puts it in place.
///
/// # Errors
/// If it cannot be written; the old file, if any, stays.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    write_by(path, |file| file.write_all(bytes))
}

/// The same of a file that is made bit by bit.
///
/// # Errors
/// If it cannot be written; the old file, if any, stays.
pub fn write_by(path: &Path, write: impl FnOnce(&mut BufWriter<&File>) -> std_io::Result<()>) -> Result<()> {
    write_aside(path, |file| {
        let mut file = BufWriter::new(file);
        write(&mut file).and_then(|()| file.flush()).map_err(io("write", path))
    })
}

/// The same by who has errors of another kind, too.
///
/// # Errors
/// If it cannot be written, or `write` fails; the old file, if any, stays.
pub fn write_aside(path: &Path, write: impl FnOnce(&File) -> Result<()>) -> Result<()> {
    let aside = draft::aside(path);
    let written = create(&aside).and_then(|file| {
        write(&file)?;
        file.sync_all().and_then(|()| fs::rename(&aside, path)).map_err(io("write", path))
    });
    if written.is_err() {
        // best effort: the error that matters is the one returned
        let _ = fs::remove_file(&aside);
    }
    written
}

/// Renames a file that cannot be used, so that nobody takes it for one; what it is called now.
///
/// # Errors
/// If it cannot be renamed.
pub fn set_aside(path: &Path) -> Result<PathBuf> {
    let aside = path.with_added_extension("damaged");
    fs::rename(path, &aside).map_err(io("rename", path))?;
    Ok(aside)
}
