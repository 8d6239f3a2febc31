//! Where one chunk of every label lies. Tasks never see it: `bind` takes each task's `Io` from it.
use super::label::Home;
use super::labels::Label;
use super::labels::{LABELS, LabelId};
use super::view::{Read, Write};
use crate::simd::Wide;
use std::ops::Range;

/// The columns of one block of one material (or of one block's nodes), and the tiles of the current chunk.
pub struct Workspace<'w> {
    /// A column a label; empty where the label does not exist here.
    pub columns: [&'w mut [Wide]; LABELS],
    /// Tiles of the current chunk.
    pub chunk: Range<usize>,
    /// How far ahead of the chunk particle columns are prefetched, in tiles; 0: not.
    pub ahead: usize,
    /// Lines of history a tile.
    pub history: usize,
}

impl Workspace<'_> {
    /// A workspace in which no label exists yet.
    pub fn empty() -> Self {
        Self { columns: std::array::from_fn(|_| &mut [][..]), chunk: 0..0, ahead: 0, history: 0 }
    }
}

/// Extent and prefetch distance of the chunk, for views.
#[derive(Clone)]
pub struct Window {
    chunk: Range<usize>,
    ahead: usize,
    history: usize,
}

impl Window {
    /// The window of the workspace's current chunk.
    #[inline(always)]
    pub fn of(space: &Workspace<'_>) -> Self {
        Self { chunk: space.chunk.clone(), ahead: space.ahead, history: space.history }
    }

    /// Tiles of a label's element type per particle tile.
    #[inline(always)]
    fn stride<L: Label>(&self) -> usize {
        if matches!(L::ID, LabelId::History) { self.history } else { 1 }
    }

    #[inline(always)]
    fn lines<L: Label>(&self) -> Range<usize> {
        let width = L::ID.width() * self.stride::<L>();
        match L::ID.home() {
            Home::Particle => self.chunk.start * width..self.chunk.end * width,
            Home::Chunk => 0..self.chunk.len() * width,
            _ => 0..usize::MAX,
        }
    }

    #[inline(always)]
    fn ahead<L: Label>(&self) -> usize {
        if matches!(L::ID.home(), Home::Particle) { self.ahead * self.stride::<L>() } else { 0 }
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
