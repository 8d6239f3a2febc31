//! Values that are the same everywhere: of materials, and of the run.
use super::reduction;
use crate::schema::{LabelId, Life, Schema, Tiles};
use bytemuck::Pod;
use simd::Wide;

/// Labels of home `Material` (a tile a material) and `Run` (one tile, or as many as the recipe says).
#[derive(Clone, Debug)]
pub struct Shared {
    /// The shared labels, in the order of the schema.
    labels: Vec<LabelId>,
    lines: Vec<Wide>,
    /// First line of each label of the schema, and the end.
    starts: Vec<usize>,
}

impl Shared {
    /// Values to which nobody has contributed.
    pub fn new(schema: &'static Schema, materials: usize, tiles: &Tiles) -> Self {
        let mut starts = vec![0];
        for label in schema.labels() {
            let tiles = if label.is_shared() { tiles.of(label, materials) } else { 0 };
            starts.push(starts[label.index()] + tiles * label.width());
        }
        let total = starts[schema.len()];
        let labels: Vec<LabelId> = schema.labels().filter(|label| label.is_shared()).collect();
        let mut shared = Self { labels, lines: vec![Wide::default(); total], starts };
        shared.columns_mut().for_each(|(label, column)| reduction::clear(label.combine(), column));
        shared
    }

    /// All tiles of a label.
    pub fn column(&self, label: LabelId) -> &[Wide] {
        &self.lines[self.starts[label.index()]..self.starts[label.index() + 1]]
    }

    /// All tiles of a label.
    pub fn column_mut(&mut self, label: LabelId) -> &mut [Wide] {
        &mut self.lines[self.starts[label.index()]..self.starts[label.index() + 1]]
    }

    /// A tile of a label: that of a material, or one of the run.
    pub fn get<T: Pod>(&self, label: LabelId, material: usize) -> T {
        let tiles: &[T] = bytemuck::cast_slice(self.column(label));
        tiles[material]
    }

    /// Sets a tile of a label.
    pub fn set<T: Pod>(&mut self, label: LabelId, material: usize, value: T) {
        let tiles: &mut [T] = bytemuck::cast_slice_mut(self.column_mut(label));
        tiles[material] = value;
    }

    /// The labels that pass from step to step.
    pub fn carried(&self) -> impl Iterator<Item = LabelId> {
        self.labels.iter().copied().filter(|label| label.life() == Life::Carried)
    }

    /// The shared labels with their columns, in the order of the schema.
    pub fn columns_mut(&mut self) -> impl Iterator<Item = (LabelId, &mut [Wide])> {
        let (mut rest, starts) = (&mut self.lines[..], &self.starts);
        self.labels.iter().map(move |&label| {
            let length = starts[label.index() + 1] - starts[label.index()];
            let (column, after) = std::mem::take(&mut rest).split_at_mut(length);
            rest = after;
            (label, column)
        })
    }
}
