//! Where one chunk of every label lies. Tasks never see it: `bind` takes each task's `Io` from it.
use super::view::{Read, Write};
use crate::schema::{Home, Label};
use simd::Wide;
use std::ops::Range;

/// The columns of one block of one material (or of one block's nodes), and the tiles of the current chunk.
pub struct Workspace<'w> {
    /// A column a label of the schema; empty where the label does not exist here.
    pub columns: Vec<&'w mut [Wide]>,
    /// Tiles of the current chunk.
    pub chunk: Range<usize>,
    /// How far ahead of the chunk particle columns are prefetched, in tiles; 0: not.
    pub ahead: usize,
    /// Lines a tile of each particle label; empty where there are none.
    pub widths: &'w [usize],
}

/// Empty columns for `labels` labels, in the memory of an empty list.
pub fn no_columns<'w>(memory: Vec<&'static mut [Wide]>, labels: usize) -> Vec<&'w mut [Wide]> {
    let mut columns = recycle(memory);
    columns.extend((0..labels).map(|_| &mut [][..]));
    columns
}

/// An empty list that takes over the memory of another: no allocation a step.
pub fn recycle<T, U>(mut list: Vec<T>) -> Vec<U> {
    list.clear();
    list.into_iter().map(|_| unreachable!("the list is empty")).collect()
}

/// Extent and prefetch distance of the chunk, for views.
#[derive(Clone)]
pub struct Window<'w> {
    chunk: Range<usize>,
    ahead: usize,
    widths: &'w [usize],
}

impl<'w> Window<'w> {
    /// The window of the workspace's current chunk.
    #[inline(always)]
    pub fn of(space: &Workspace<'w>) -> Self {
        Self { chunk: space.chunk.clone(), ahead: space.ahead, widths: space.widths }
    }

    /// Elements a tile.
    #[inline(always)]
    fn stride<L: Label>(&self) -> usize {
        if const { L::ID.by_material() } { self.widths[L::ID.index()] / const { L::ID.width() } } else { 1 }
    }

    #[inline(always)]
    fn lines<L: Label>(&self) -> Range<usize> {
        let width = const { L::ID.width() } * self.stride::<L>();
        match const { L::ID.home() } {
            Home::Particle => self.chunk.start * width..self.chunk.end * width,
            Home::Chunk => 0..self.chunk.len() * width,
            _ => 0..usize::MAX,
        }
    }

    #[inline(always)]
    fn ahead<L: Label>(&self) -> usize {
        if matches!(const { L::ID.home() }, Home::Particle) { self.ahead * self.stride::<L>() } else { 0 }
    }

    /// The current chunk of a column, for reading.
    #[inline(always)]
    pub fn read<'a, L: Label>(&self, column: &'a mut &mut [Wide]) -> Read<'a, L::Tile> {
        let lines = clamp(self.lines::<L>(), column.len());
        Read::new(bytemuck::cast_slice(&column[lines]), self.ahead::<L>())
    }

    /// The current chunk of a column, for writing.
    #[inline(always)]
    pub fn write<'a, L: Label>(&self, column: &'a mut &mut [Wide]) -> Write<'a, L::Tile> {
        let lines = clamp(self.lines::<L>(), column.len());
        Write::new(bytemuck::cast_slice_mut(&mut column[lines]), self.ahead::<L>())
    }
}

/// Whole columns end where they end; a column that does not exist gives an empty view.
#[inline(always)]
fn clamp(range: Range<usize>, end: usize) -> Range<usize> {
    range.start.min(end)..range.end.min(end)
}
