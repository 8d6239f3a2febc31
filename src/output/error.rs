//! What can go wrong with an output file: which file, what happened, what to do.
use engine::exec::ranks::NetworkError;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

/// A failed output file.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("cannot {action} {}: {source}; {}", path.display(), remedy(source))]
    Io {
        /// What was tried, for example `write`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The HDF5 library refused.
    #[error("cannot {action} {}: {source}; is the disk full, the folder writable, the file whole?", path.display())]
    Hdf5 {
        /// What was tried, for example `append a frame to`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// What the library said.
        source: hdf5::Error,
    },
    /// Ranks that cannot go on together.
    #[error("{0}")]
    Network(#[from] NetworkError),
    /// The file is readable, but does not hold what is needed.
    #[error("{}: {problem}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What is missing or wrong, and what to do.
        problem: String,
    },
    /// Another rank failed, or is gone.
    #[error("{0}")]
    Ranks(String),
}

impl Error {
    /// Whether a file is there, and may not be read or written.
    pub fn is_denied(&self) -> bool {
        matches!(self, Self::Io { source, .. } if source.kind() == ErrorKind::PermissionDenied)
    }

    /// Whether there is no such file.
    pub fn is_missing(&self) -> bool {
        matches!(self, Self::Io { source, .. } if source.kind() == ErrorKind::NotFound)
    }
}

/// A result with [`Error`].
pub type Result<T> = std::result::Result<T, Error>;

/// What a user can do about an error of the system.
fn remedy(source: &io::Error) -> &'static str {
    match source.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "free some space, or write elsewhere with --out"
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "make it readable and its folder writable, or write elsewhere with --out"
        }
        ErrorKind::NotFound | ErrorKind::NotADirectory => {
            "check the path: the file, or a folder of it, is not there"
        }
        _ => "check the path and the disk",
    }
}

/// Names the file of a system error: `.map_err(io("write", path))`.
pub fn io<'a>(action: &'static str, path: &'a Path) -> impl Fn(io::Error) -> Error + 'a {
    move |source| Error::Io { action, path: path.into(), source }
}

/// Names the file of an HDF5 error.
pub(crate) fn hdf5<'a>(action: &'static str, path: &'a Path) -> impl Fn(::hdf5::Error) -> Error + 'a {
    move |source| Error::Hdf5 { action, path: path.into(), source }
}
