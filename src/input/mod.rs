//! Scene files: TOML as written, read into a validated [`Scene`](scene::Scene) in SI units.
mod blame;
mod build;
mod check;
mod choose;
mod document;
mod documentation;
mod error;
mod fields;
mod form;
pub mod identity;
mod meetings;
mod meshes;
mod moved;
mod read;
mod references;
mod rigid;
mod shapes;
mod source;
pub mod units;
mod validate;

pub use documentation::documentation;
pub use error::SceneError;
pub use read::{Written, read, read_text};
pub use validate::{BYTES_PER_PARTICLE, available_memory};
