//! `particles.vtkhdf`: particles in time as VTKHDF PolyData, which ParaView opens.
//!
//! Each frame is a file of its own in the folder `particles`, written aside, sealed (`seal.rs`), put in place and never
//! touched again. `particles.vtkhdf` is an index of them: what VTK looks for are virtual datasets, which HDF5 composes of
//! the frames' (<https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/>). It is written anew after
//! frames, and replaced at once. So whoever looks finds whole frames, at any moment and after any kill; a damaged frame is
//! one frame; and the index states the digest of every frame, so that no other file passes for it.
mod about;
mod found;
mod frame_file;
mod index;
mod reader;
mod writer;

pub use found::Found;
pub use reader::Reader;
pub use writer::{Writer, refuse_link, remove_frames};

use crate::output::run_id::RunId;
use std::path::{Path, PathBuf};

/// Rows of a chunk. Pieces of a frame that end at a multiple of it are compressed once.
pub const CHUNK: usize = 65_536;

/// Names inside the files.
mod name {
    pub const ROOT: &str = "VTKHDF";
    pub const POINTS: &str = "Points";
    pub const DATA: &str = "PointData";
    pub const STEPS: &str = "Steps";
    pub const COUNTS: &str = "NumberOfPoints";
    pub const OFFSETS: &str = "Steps/PointOffsets";
    pub const TIMES: &str = "Steps/Values";
    /// Not VTK's: the number of steps taken up to each frame, the number of its file, and its digest.
    pub const TAKEN: &str = "Steps/StepsTaken";
    pub const NUMBERS: &str = "Steps/FileNumber";
    pub const DIGESTS: &str = "Steps/FileDigest";
    /// Attribute of `Steps`: how many frames there are.
    pub const FRAMES: &str = "NSteps";
    pub const IDENTITY: &str = "id";
    pub const MATERIAL: &str = "material";
    pub const UNIT: &str = "unit";
    pub const MEANING: &str = "meaning";
    pub const CODES: &str = "codes";
    pub const NAMES: &str = "names";
    pub const TIME: &str = "time";
    pub const STEP: &str = "step";
    pub const PARTICLES: &str = "particles";
}

/// The name of the index.
pub const INDEX: &str = "particles.vtkhdf";

/// Whose an index is, if that can be read.
pub fn run_of(index: &Path) -> Option<RunId> {
    index::read(index).ok().map(|index| index.run)
}

/// A frame, as the index knows it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    /// Number of its file.
    number: u64,
    time: f64,
    step: u64,
    particles: usize,
    digest: u128,
}

/// The folder of the frames, beside the index.
const FOLDER: &str = "particles";

fn folder(index: &Path) -> PathBuf {
    index.with_file_name(FOLDER)
}

/// Whether a file is one of the frames of the run in a folder.
pub fn is_frame(run: &Path, file: &Path) -> bool {
    file.parent() == Some(&run.join(FOLDER)) && file.extension().is_some_and(|extension| extension == "h5")
}

/// A file of that folder, as seen from the index.
fn relative(file: &str) -> String {
    format!("{FOLDER}/{file}")
}

/// The name of a frame's file.
fn file_name(number: u64) -> String {
    format!("{number:06}.h5")
}

/// The number of a frame, from the name of its file.
fn number(file: &Path) -> Option<u64> {
    file.file_name()?.to_str()?.strip_suffix(".h5")?.parse().ok()
}

/// What is in the folder of the frames under the name of one, with its number.
fn numbered(index: &Path) -> Vec<(u64, PathBuf)> {
    let entries = std::fs::read_dir(folder(index)).into_iter().flatten().flatten();
    entries.filter_map(|entry| Some((number(&entry.path())?, entry.path()))).collect()
}

/// The file of a frame.
fn file(index: &Path, number: u64) -> PathBuf {
    folder(index).join(file_name(number))
}
