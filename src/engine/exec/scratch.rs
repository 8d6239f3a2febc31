//! What one worker keeps between pieces of work.
use super::meter::Tally;
use crate::data::schedule::FieldTime;
use crate::data::shared::Shared;
use crate::data::warehouse::Warehouse;
use crate::data::workspace::no_columns;
use crate::schema::{Crossing, Home, LabelId, Life};
use simd::Wide;

/// Tiles of a chunk: small, so that what passes between tasks stays in the first-level cache, and the unit of the order
/// of summation.
pub const CHUNK: usize = 4;
/// How far ahead of a chunk particle columns are prefetched, in tiles.
pub const AHEAD: usize = CHUNK;

/// Chunk labels, a region of node lines, node sums, and shared labels of one worker.
pub struct Scratch {
    lines: Vec<Wide>,
    /// Labels of which something is in `lines`, with how many there are.
    lengths: Vec<(LabelId, usize)>,
    /// Labels of the schema.
    labels: usize,
    /// Contributions to shared labels, and copies of those that are read.
    pub shared: Shared,
    /// Memory for the fields at a block's nodes.
    pub fields: Vec<FieldTime>,
    /// Memory for lists of columns, which are empty between pieces of work.
    pub columns: Vec<&'static mut [Wide]>,
    /// What the worker's work took, if it is metered.
    pub tally: Tally,
}

/// Lines of a label in a worker's scratch.
fn length(label: LabelId, warehouse: &Warehouse) -> usize {
    let layout = &warehouse.node_layout;
    let used = layout.stored_place(label).is_some() || layout.partial_place(label).is_some();
    let fields = warehouse.materials.iter().map(|material| material.fields).max().unwrap_or(1);
    match (label.home(), label.crossing()) {
        (Home::Chunk, _) => CHUNK * label.width(),
        (Home::Node, Crossing::Values(_)) if used => layout.buffer * fields * label.width(),
        (Home::Node, Crossing::Partials(_)) if used && label.life() == Life::Stage => {
            layout.nodes * warehouse.fields.len() * label.width()
        }
        _ => 0,
    }
}

impl Scratch {
    /// Scratch for work on `warehouse`.
    pub fn new(warehouse: &Warehouse) -> Self {
        let lengths = warehouse.schema.labels().map(|label| (label, length(label, warehouse)));
        let lengths: Vec<(LabelId, usize)> = lengths.filter(|(_, length)| *length > 0).collect();
        Self {
            lines: vec![Wide::default(); lengths.iter().map(|(_, length)| length).sum()],
            lengths,
            labels: warehouse.schema.len(),
            shared: warehouse.shared.clone(),
            fields: Vec::new(),
            columns: Vec::new(),
            tally: Tally::default(),
        }
    }

    /// A column a label, the shared labels, and the memory for fields.
    pub fn lend(&mut self) -> (Vec<&mut [Wide]>, &mut Shared, &mut Vec<FieldTime>) {
        let mut columns = no_columns(std::mem::take(&mut self.columns), self.labels);
        let mut rest = &mut self.lines[..];
        for &(label, length) in &self.lengths {
            let (own, after) = std::mem::take(&mut rest).split_at_mut(length);
            (columns[label.index()], rest) = (own, after);
        }
        (columns, &mut self.shared, &mut self.fields)
    }
}
