//! A seal behind the last byte of a file: a digest of everything before it, so that no cut and no flipped bit goes
//! unnoticed. HDF5 does not look at bytes behind its own end; and it must not be given a damaged file, at which it may crash.
use super::error::{Error, Result, io};
use super::plain;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;
use twox_hash::XxHash3_128;

const MAGIC: [u8; 8] = *b"SINEWEND";
/// Bytes of a seal: the magic, the number of bytes before it, and their digest (XXH3, 128 bits).
pub const LENGTH: u64 = 32;

/// Appends the seal; the digest.
///
/// # Errors
/// If the file cannot be read or written.
pub fn seal(path: &Path) -> Result<u128> {
    let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(io("open", path))?;
    let length = file.metadata().map_err(io("read", path))?.len();
    let digest = digest(&mut file, length).map_err(io("read", path))?;
    file.write_all(&stamp(length, digest)).map_err(io("write", path))?;
    Ok(digest)
}

/// Waits until the disk has all of a file, or of the names in a folder.
///
/// # Errors
/// If it does not take it.
pub fn sync(path: &Path) -> Result<()> {
    File::open(path).and_then(|file| file.sync_all()).map_err(io("write", path))
}

/// Checks the seal; the digest.
///
/// # Errors
/// If the file cannot be read, was cut off, or is not what was sealed.
pub fn verify(path: &Path) -> Result<u128> {
    let (mut file, length, stated) = open(path)?;
    file.seek(SeekFrom::Start(0)).map_err(io("read", path))?;
    let digest = digest(&mut file, length).map_err(io("read", path))?;
    if digest == stated {
        return Ok(digest);
    }
    Err(broken(path, "it is damaged: its checksum is not that of its content"))
}

/// The digest that a file states, of which only the length is checked.
///
/// # Errors
/// If the file cannot be read, or does not end with a seal.
pub fn stated(path: &Path) -> Result<u128> {
    open(path).map(|(_, _, digest)| digest)
}

fn broken(path: &Path, problem: &str) -> Error {
    Error::Content { path: path.into(), problem: problem.into() }
}

/// The file, the bytes before its seal, and the digest of them that the seal states.
fn open(path: &Path) -> Result<(File, u64, u128)> {
    let mut file = plain::open(path)?;
    let all = file.metadata().map_err(io("read", path))?.len();
    let Some(length) = all.checked_sub(LENGTH) else {
        return Err(broken(path, "it is cut off: it is too short"));
    };
    let mut found = [0; LENGTH as usize];
    let read = file.seek(SeekFrom::Start(length)).and_then(|_| file.read_exact(&mut found));
    read.map_err(io("read", path))?;
    let digest = u128::from_le_bytes(*found.last_chunk().unwrap_or(&[0; 16]));
    if found != stamp(length, digest) {
        return Err(broken(path, "it is cut off or damaged: it does not end as it should"));
    }
    Ok((file, length, digest))
}

fn stamp(length: u64, digest: u128) -> [u8; LENGTH as usize] {
    let mut stamp = [0; LENGTH as usize];
    stamp[..8].copy_from_slice(&MAGIC);
    stamp[8..16].copy_from_slice(&length.to_le_bytes());
    stamp[16..].copy_from_slice(&digest.to_le_bytes());
    stamp
}

/// Digest of the first `length` bytes from where the file stands, behind which it stands afterwards.
fn digest(file: &mut File, length: u64) -> std::io::Result<u128> {
    let mut hasher = XxHash3_128::new();
    let mut buffer = vec![0; 1 << 20];
    let mut left = length;
    while left > 0 {
        let piece = buffer.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        file.read_exact(&mut buffer[..piece])?;
        hasher.write(&buffer[..piece]);
        left -= piece as u64;
    }
    Ok(hasher.finish_128())
}
