//! Files for people and for other programs.
pub mod checkpoint;
pub mod compare;
pub(crate) mod error;
pub mod frame;
pub mod history;
pub mod parcel;
pub mod snapshot;
pub mod space;
pub mod summary;
pub mod together;
pub mod trace;
pub mod vtkhdf;

pub(crate) use error::io;
pub use error::{Error, Result};
