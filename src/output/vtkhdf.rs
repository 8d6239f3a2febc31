//! `particles.vtkhdf`: particles in time as VTKHDF PolyData, which ParaView opens.
//!
//! Format: <https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/>. Every particle is a vertex cell.
//! Frames share one connectivity 0, 1, 2…: all cell offsets are zero, and rows of equal content are one dataset
//! under several names (hard links). Each frame starts on a chunk boundary, so appending never touches the bytes
//! of an earlier frame; the frame counter is written last.
mod reader;
mod rows;
mod writer;

pub use reader::Reader;
pub use writer::{CHUNK, Writer};

/// Names inside the file.
mod name {
    pub const ROOT: &str = "VTKHDF";
    pub const POINTS: &str = "Points";
    pub const DATA: &str = "PointData";
    pub const STEPS: &str = "Steps";
    pub const COUNTS: &str = "NumberOfPoints";
    pub const OFFSETS: &str = "Steps/PointOffsets";
    pub const TIMES: &str = "Steps/Values";
    /// Not VTK's: the number of steps taken up to each frame.
    pub const TAKEN: &str = "Steps/StepsTaken";
    /// Attribute of `Steps`: how many frames are whole.
    pub const FRAMES: &str = "NSteps";
    pub const IDENTITY: &str = "id";
    pub const MATERIAL: &str = "material";
    pub const UNIT: &str = "unit";
}
