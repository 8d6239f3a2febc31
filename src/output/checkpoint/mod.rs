//! `checkpoint-NNNNNNNN.h5`: all that a run needs to go on from a step, bit for bit.
//!
//! An HDF5 file with a seal behind its last byte (`seal.rs`), written aside and renamed when the disk has it. Per material
//! a table of blocks, then the particles label by label, block after block in the order within each block: which block
//! a particle belongs to, and where in it, is state, not a consequence of its position.
mod fill;
mod folder;
mod reader;
mod state;
mod writer;

pub use fill::fill;
pub use folder::{Found, last_whole, list, path, prune, set_aside};
pub use reader::Reader;
pub use state::{parts, write};
pub use writer::Writer;

use super::run_id::RunId;

/// Version of the format.
pub const FORMAT: u32 = 3;
/// The version of Sinew that writes.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// All but the particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Head {
    /// The version of Sinew that wrote it.
    pub version: String,
    /// The instruction set that ran.
    pub isa: String,
    /// Name of the scene.
    pub name: String,
    /// The resolved scene.
    pub scene: String,
    /// Simulated time [s].
    pub time: f64,
    /// Steps taken.
    pub steps: u64,
    /// Particles moved, by all ranks.
    pub updates: u64,
    /// What the run's files hold.
    pub recorded: Recorded,
    /// Labels of materials and of the run, bit by bit.
    pub shared: Vec<(String, Vec<u64>)>,
    /// Running totals of what particles do not remember.
    pub ledger: Vec<f64>,
    /// The particles of each material.
    pub materials: Vec<Table>,
    /// The nodes of each velocity field, if nodes have labels that pass from step to step.
    pub nodes: Vec<Table>,
}

/// How far the files of a run had come.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recorded {
    /// Whose they are.
    pub run: RunId,
    /// Frames in `particles.vtkhdf`.
    pub frames: u64,
    /// Number of the frame that is due next.
    pub due: u64,
    /// Whether the last row, and the last frame, are there only because the run ended: a run that goes further drops them.
    pub last: [bool; 2],
    /// Seconds on the clock so far.
    pub wall_s: f64,
    /// Seconds of these that output took.
    pub output_s: f64,
    /// Digests of `history.csv`: but for its last row, and of all.
    pub history: [u64; 2],
    /// What the run has warned of: a key, and the words.
    pub warnings: Vec<(String, String)>,
}

/// What a checkpoint has of the particles of a material, or of the nodes of a field: a row each, block by block.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Its name.
    pub name: String,
    /// Names of its labels, and numbers a row of each.
    pub labels: Vec<(String, usize)>,
    /// Blocks.
    pub blocks: usize,
    /// Rows.
    pub rows: usize,
}

/// A block of a table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BlockRow {
    /// Which block.
    pub index: [i32; 3],
    /// Rows of it.
    pub count: u32,
    /// Of particles: bounds of its extent: largest y on each axis, largest −y.
    pub extent: [f64; 6],
}

/// Some blocks of a table with their rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Part {
    /// Number of the table: of the materials, then of the fields.
    pub table: usize,
    /// The blocks.
    pub blocks: Vec<BlockRow>,
    /// The values of each label, row by row.
    pub columns: Vec<Vec<f64>>,
}

/// Names inside the file.
mod name {
    pub const FORMAT: &str = "format";
    pub const VERSION: &str = "version";
    pub const ISA: &str = "instruction_set";
    pub const SCENE_NAME: &str = "scene_name";
    pub const SCENE_IDENTITY: &str = "scene_identity";
    pub const SCENE: &str = "scene";
    pub const TIME: &str = "time";
    pub const STEPS: &str = "steps";
    pub const UPDATES: &str = "updates";
    pub const FRAMES: &str = "frames";
    pub const DUE: &str = "next_frame";
    pub const LAST_ROW: &str = "last_row_at_end";
    pub const LAST_FRAME: &str = "last_frame_at_end";
    pub const WALL: &str = "wall_s";
    pub const OUTPUT: &str = "output_s";
    pub const HISTORY: &str = "history_digests";
    pub const WARNINGS: &str = "warnings";
    pub const SHARED: &str = "shared";
    pub const LEDGER: &str = "ledger";
    pub const MATERIALS: &str = "materials";
    pub const NODES: &str = "nodes";
    pub const MATERIAL_NAME: &str = "name";
    pub const LABELS: &str = "labels";
    pub const BLOCK_INDEX: &str = "block_index";
    pub const BLOCK_COUNT: &str = "block_count";
    pub const BLOCK_EXTENT: &str = "block_extent";
    pub const PARTICLES: &str = "particles";
    /// The label whose numbers are the bits of integers.
    pub const IDENTITY: &str = "Identity";
}
