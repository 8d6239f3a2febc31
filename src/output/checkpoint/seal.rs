//! A seal behind the last byte of a file: a digest of everything before it, so that no cut and no flipped bit goes
//! unnoticed. HDF5 does not look at bytes behind its own end; and it must not be given a damaged file, at which it may crash.
use crate::output::error::{Error, Result, io};
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;
use twox_hash::XxHash3_128;

const MAGIC: [u8; 8] = *b"SINEWEND";
/// Bytes of a seal: the magic, the number of bytes before it, and their digest (XXH3, 128 bits).
pub const LENGTH: u64 = 32;

/// Appends the seal, and waits until the disk has all of the file.
///
/// # Errors
/// If the file cannot be read or written.
pub fn seal(path: &Path) -> Result<()> {
    let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(io("open", path))?;
    let length = file.metadata().map_err(io("read", path))?.len();
    let digest = digest(&mut file, length).map_err(io("read", path))?;
    let seal = stamp(length, digest);
    file.write_all(&seal).and_then(|()| file.sync_all()).map_err(io("write", path))
}

/// Checks the seal.
///
/// # Errors
/// If the file cannot be read, was cut off, or is not what was sealed.
pub fn verify(path: &Path) -> Result<()> {
    let broken = |problem: &str| Error::Content { path: path.into(), problem: problem.into() };
    let mut file = File::open(path).map_err(io("open", path))?;
    let all = file.metadata().map_err(io("read", path))?.len();
    let Some(length) = all.checked_sub(LENGTH) else {
        return Err(broken("it is cut off: a checkpoint is longer"));
    };
    let digest = digest(&mut file, length).map_err(io("read", path))?;
    let mut found = [0; LENGTH as usize];
    file.read_exact(&mut found).map_err(io("read", path))?;
    if found == stamp(length, digest) {
        return Ok(());
    }
    Err(broken(match found.starts_with(&MAGIC) {
        true => "it is damaged: its checksum is not that of its content",
        false => "it is cut off or damaged: it does not end as a checkpoint does",
    }))
}

fn stamp(length: u64, digest: u128) -> [u8; LENGTH as usize] {
    let mut stamp = [0; LENGTH as usize];
    stamp[..8].copy_from_slice(&MAGIC);
    stamp[8..16].copy_from_slice(&length.to_le_bytes());
    stamp[16..].copy_from_slice(&digest.to_le_bytes());
    stamp
}

/// Digest of the first `length` bytes, behind which the file stands afterwards.
fn digest(file: &mut File, length: u64) -> std::io::Result<u128> {
    file.seek(SeekFrom::Start(0))?;
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
