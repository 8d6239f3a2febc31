//! Files for people and for other programs.
mod error;
pub mod frame;

pub mod snapshot;
pub mod space;

pub mod vtkhdf;

pub use error::{Error, Result};
