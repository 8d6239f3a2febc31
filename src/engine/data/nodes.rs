//! The labels of a block's nodes, for the velocity fields that touch it.
use super::fields::FieldId;
use super::layout::NodeLayout;
use crate::schema::LabelId;
use grid::BlockIndex;
use simd::{LANES, Wide, prefetch_at};
use smallvec::SmallVec;
use std::ops::Range;

/// Patch of a block, and its position there.
pub type Place = (u32, u32);

/// A neighbor that does not exist.
pub const NOWHERE: Place = (u32::MAX, u32::MAX);

/// Labels of nodes that a block keeps: few, so that they need no memory of their own.
const FEW: usize = 2;

/// Fields of a block: mostly so few that they need no memory of their own.
pub type Present = SmallVec<[FieldId; 4]>;

/// The labels that outlive a stage over nodes.
#[derive(Clone, Debug)]
pub struct NodeBlock {
    /// Which block.
    pub index: BlockIndex,
    /// Fields that touch its nodes, ascending.
    pub present: Present,
    /// A column a label that is kept (see [`NodeLayout::stored`]): the lines of all nodes, field after field.
    columns: SmallVec<[Vec<Wide>; FEW]>,
    /// For each present field, the number of the tick up to which its nodes have been integrated; below any tick where
    /// they never were.
    pub until: SmallVec<[f64; 4]>,
    /// For each present field, the particle blocks of its material around, in the order of `grid::around`.
    pub around: SmallVec<[[Place; 27]; 1]>,
    /// Whether particles of another rank add to it.
    pub rim: bool,
    /// What work on it took, while that is weighed [ns].
    pub cost: u64,
}

impl NodeBlock {
    /// A block that `present` fields touch.
    pub fn new(index: BlockIndex, present: Present, layout: &NodeLayout) -> Self {
        let column = |label: &LabelId| match is_there(*label, present.len()) {
            true => vec![Wide::default(); layout.nodes * label.width() * present.len()],
            false => Vec::new(),
        };
        let columns = layout.stored().iter().map(column).collect();
        let around = SmallVec::from_elem([NOWHERE; 27], present.len());
        let until = SmallVec::from_elem(NEVER, present.len());
        Self { index, present, columns, until, around, rim: false, cost: 0 }
    }

    /// As `old`, but for other fields: those that stay keep what they have in the middle of a step.
    pub fn succeed(old: &Self, present: Present, layout: &NodeLayout) -> Self {
        let mut block = Self::new(old.index, present, layout);
        for to in 0..block.present.len() {
            let Some(from) = old.slot(block.present[to]) else { continue };
            block.until[to] = old.until[from];
            let columns = block.columns.iter_mut().zip(&old.columns).zip(layout.stored());
            for ((new, old), label) in columns.filter(|((new, old), _)| !new.is_empty() && !old.is_empty()) {
                let length = layout.nodes * label.width();
                new[to * length..][..length].copy_from_slice(&old[from * length..][..length]);
            }
        }
        block
    }

    /// Place of a field among those that are present.
    #[inline(always)]
    pub fn slot(&self, field: FieldId) -> Option<usize> {
        self.present.iter().position(|&f| f == field)
    }

    /// Asks for what says where its columns are.
    #[inline(always)]
    pub fn announce(&self) {
        prefetch_at(&raw const self.present);
        prefetch_at(&raw const self.columns);
    }

    /// The column of the `place`-th label that is kept; empty where it is not there.
    #[inline(always)]
    pub fn column(&self, place: usize) -> &[Wide] {
        &self.columns[place]
    }

    /// The block taken apart for a workspace.
    pub fn split(&mut self) -> Split<'_> {
        let Self { present, around, until, columns, .. } = self;
        Split { present, around, until, columns }
    }

    /// The lines of a label that is kept, of one field; `None` where it is not there.
    #[inline(always)]
    pub fn lines(&self, layout: &NodeLayout, label: LabelId, field: FieldId) -> Option<&[Wide]> {
        let (place, lines) = self.range(layout, label, field)?;
        self.columns[place].get(lines)
    }

    /// As [`NodeBlock::lines`], to write.
    pub fn lines_mut(&mut self, layout: &NodeLayout, label: LabelId, field: FieldId) -> Option<&mut [Wide]> {
        let (place, lines) = self.range(layout, label, field)?;
        self.columns[place].get_mut(lines)
    }

    #[inline(always)]
    fn range(&self, layout: &NodeLayout, label: LabelId, field: FieldId) -> Option<(usize, Range<usize>)> {
        let (place, slot) = (layout.stored_place(label)?, self.slot(field)?);
        let length = layout.nodes * label.width();
        Some((place, slot * length..(slot + 1) * length))
    }

    /// Appends what makes the block between two steps, to be read by [`NodeBlock::from_lines`]: its fields, and the columns
    /// that are carried.
    pub fn to_lines(&self, layout: &NodeLayout, lines: &mut Vec<Wide>) {
        let [x, y, z] = self.index.map(|i| i as u32 as u64);
        lines.push(bytemuck::cast([x, y, z, self.present.len() as u64, 0, 0, 0, 0]));
        for fields in self.present.chunks(LANES) {
            let mut line = [0; LANES];
            line.iter_mut().zip(fields).for_each(|(number, field)| *number = field.index() as u64);
            lines.push(bytemuck::cast(line));
        }
        layout.carried().filter_map(|label| layout.stored_place(label)).for_each(|place| {
            lines.extend_from_slice(&self.columns[place]);
        });
    }

    /// A block from the beginning of `lines`, which go on after it; `None` if they are too few.
    pub fn from_lines(layout: &NodeLayout, lines: &mut &[Wide]) -> Option<Self> {
        let (head, mut after) = lines.split_first()?;
        let [x, y, z, count, ..]: [u64; 8] = bytemuck::cast(*head);
        let mut present = Present::new();
        for first in (0..count as usize).step_by(LANES) {
            let (line, rest) = after.split_first()?;
            let numbers: [u64; LANES] = bytemuck::cast(*line);
            present.extend(
                numbers.iter().take(count as usize - first).map(|&field| FieldId::new(field as usize)),
            );
            after = rest;
        }
        let mut block = Self::new([x, y, z].map(|i| i as u32 as i32), present, layout);
        for place in layout.carried().filter_map(|label| layout.stored_place(label)) {
            let (column, rest) = after.split_at_checked(block.columns[place].len())?;
            block.columns[place].copy_from_slice(column);
            after = rest;
        }
        *lines = after;
        Some(block)
    }

    /// Bytes of all columns.
    pub fn bytes(&self) -> usize {
        self.columns.iter().map(|column| column.len() * size_of::<Wide>()).sum()
    }
}

/// A block's data, taken apart.
pub struct Split<'a> {
    /// See [`NodeBlock::present`].
    pub present: &'a [FieldId],
    /// See [`NodeBlock::around`].
    pub around: &'a [[Place; 27]],
    /// See [`NodeBlock::until`].
    pub until: &'a [f64],
    /// A column a label that is kept.
    pub columns: &'a mut [Vec<Wide>],
}

/// Whether a label of nodes is in a block that so many fields touch.
#[inline(always)]
pub fn is_there(label: LabelId, fields: usize) -> bool {
    fields > 1 || !label.where_fields_meet()
}

/// Before any tick.
const NEVER: f64 = -1.0;
