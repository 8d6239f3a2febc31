//! Files for people and for other programs.
pub mod beside;
pub mod checkpoint;
pub mod claim;
pub mod compare;
pub mod create;
pub mod draft;
pub(crate) mod error;
pub mod frame;
pub mod history;
pub mod parcel;
mod plain;
pub mod run_id;
pub mod seal;
pub mod snapshot;
pub mod space;
mod stored;
pub mod summary;
pub mod together;
pub mod trace;
pub mod vtkhdf;

pub use error::{Error, Result, io};
