//! What one worker keeps between pieces of work.
use super::meter::Tally;
use crate::data::label::Home;
use crate::data::labels::{LABELS, LabelId};
use crate::data::nodes::NODES;
use crate::data::schedule::Field;
use crate::data::warehouse::Shared;
use crate::physics::shape::{BUFFER, GROUP};
use crate::simd::Wide;

/// Tiles of a chunk: small, so that what passes between tasks stays in the first-level cache, and a multiple of
/// the group that fixes the order of summation.
pub const CHUNK: usize = GROUP;
/// How far ahead of a chunk particle columns are prefetched, in tiles.
pub const AHEAD: usize = CHUNK;

/// Chunk labels, a region of node lines, node sums, and shared labels of one worker.
pub struct Scratch {
    lines: Vec<Wide>,
    widths: [usize; LABELS],
    /// Contributions to shared labels, and copies of those that are read.
    pub shared: Shared,
    /// Memory for the materials at a block's nodes.
    pub fields: Vec<Field>,
    /// What the worker's work took, if it is metered.
    pub tally: Tally,
}

impl Scratch {
    /// Scratch for up to `materials` materials at a node.
    pub fn new(materials: usize, shared: &Shared) -> Self {
        let widths: [usize; LABELS] = std::array::from_fn(|i| {
            let label = LabelId::ALL[i];
            match label.home() {
                Home::Chunk => CHUNK * label.width(),
                Home::Node => BUFFER.max(NODES * materials),
                _ => 0,
            }
        });
        Self {
            lines: vec![Wide::default(); widths.iter().sum()],
            widths,
            shared: shared.clone(),
            fields: Vec::new(),
            tally: Tally::default(),
        }
    }

    /// A column a label, and the shared labels.
    pub fn split(&mut self) -> ([&mut [Wide]; LABELS], &mut Shared) {
        let mut rest = &mut self.lines[..];
        let columns = self.widths.map(|width| {
            let (column, after) = std::mem::take(&mut rest).split_at_mut(width);
            rest = after;
            column
        });
        (columns, &mut self.shared)
    }
}
