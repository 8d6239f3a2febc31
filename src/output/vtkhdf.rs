//! `particles.vtkhdf`: particles in time as VTKHDF PolyData, which ParaView opens.
//!
//! Each frame is a file of its own in the folder `particles`, or on several ranks one of each: written aside, sealed
//! (`seal.rs`), put in place and never touched again. `particles.vtkhdf` is an index of them: what VTK looks for are virtual
//! datasets, which HDF5 composes of the files' (<https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/>). It is
//! written anew after frames, and replaced at once. So whoever looks finds whole frames, at any moment and after any kill; a
//! damaged file is one damaged frame; and the index states the digest of every file, so that no other file passes for it.
mod about;
mod found;
mod index;
mod named;
mod part_file;
mod reader;
mod token;
mod writer;

pub use found::Found;
pub use named::FileId;
pub use part_file::PartFile;
pub use reader::Reader;
pub use token::Token;
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
    /// Not VTK's: the number of steps taken up to each frame, its own number, and how many files it has.
    pub const TAKEN: &str = "Steps/StepsTaken";
    pub const NUMBERS: &str = "Steps/FileNumber";
    pub const FILES: &str = "Steps/FileParts";
    /// Of each file, frame after frame: its particles, and its digest.
    pub const ROWS: &str = "Steps/FileParticles";
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
    /// Attributes of a file that is a part of a frame: which one, of how many, and who wrote them together.
    pub const PART: &str = "part";
    pub const PARTS: &str = "parts";
    pub const WRITING: &str = "writing";
}

/// The name of the index.
pub const INDEX: &str = "particles.vtkhdf";

/// Whose an index is, if that can be read.
pub fn run_of(index: &Path) -> Option<RunId> {
    index::read(index).ok().map(|index| index.run)
}

/// A frame, as the index knows it.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    number: u64,
    time: f64,
    step: u64,
    parts: Vec<Part>,
}

impl Entry {
    fn particles(&self) -> usize {
        self.parts.iter().map(|part| part.particles).sum()
    }

    /// Its files, with what the index knows of each.
    fn files(&self) -> impl Iterator<Item = (FileId, &Part)> {
        FileId::of_frame(self.number, self.parts.len()).zip(&self.parts)
    }
}

/// A file of a frame: that of a rank, or of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its rows.
    pub particles: usize,
    /// What its seal says.
    pub digest: u128,
}

/// The folder of the frames, beside the index.
const FOLDER: &str = "particles";

/// The folder of the frames that an index names.
pub fn folder(index: &Path) -> PathBuf {
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
