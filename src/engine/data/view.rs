//! What a task body holds: the current chunk of one declared label.
//! Iterating asks for the same column of the next chunk, so no body mentions prefetching.
use bytemuck::Pod;
use simd::{Wide, prefetch};
use std::ops::{Deref, DerefMut};
use std::slice;

/// Read access to the tiles of a chunk.
pub struct Read<'a, T> {
    tiles: &'a [T],
    /// How many tiles ahead to prefetch; 0: not at all.
    ahead: usize,
}

/// Read and write access to the tiles of a chunk.
pub struct Write<'a, T> {
    tiles: &'a mut [T],
    ahead: usize,
}

impl<'a, T: Pod> Read<'a, T> {
    /// A view that prefetches `ahead` tiles ahead of what it hands out.
    #[inline(always)]
    pub fn new(tiles: &'a [T], ahead: usize) -> Self {
        Self { tiles, ahead }
    }
    /// Tile by tile.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = &'a T> + use<'a, T> {
        let ahead = self.ahead;
        self.tiles.iter().inspect(move |tile| announce(*tile, ahead))
    }
}

impl<'a, T: Pod> Write<'a, T> {
    /// A view that prefetches `ahead` tiles ahead of what it hands out.
    #[inline(always)]
    pub fn new(tiles: &'a mut [T], ahead: usize) -> Self {
        Self { tiles, ahead }
    }
    /// Tile by tile.
    #[inline(always)]
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut T> {
        let ahead = self.ahead;
        self.tiles.iter_mut().inspect(move |tile| announce(*tile, ahead))
    }
    /// Tile `tile` of a label whose tiles have `width` elements each.
    #[inline(always)]
    pub fn tile_mut(&mut self, tile: usize, width: usize) -> &mut [T] {
        let tile = &mut self.tiles[tile * width..(tile + 1) * width];
        tile.iter().for_each(|element| announce(element, self.ahead));
        tile
    }
}

/// Prefetches the tile `ahead` tiles after this one.
#[inline(always)]
fn announce<T: Pod>(tile: &T, ahead: usize) {
    if ahead > 0 {
        let lines: &[Wide] = bytemuck::cast_slice(slice::from_ref(tile));
        (0..lines.len()).for_each(|line| prefetch(lines, ahead * lines.len() + line));
    }
}

impl<T> Deref for Read<'_, T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        self.tiles
    }
}
impl<T> Deref for Write<'_, T> {
    type Target = [T];
    #[inline(always)]
    fn deref(&self) -> &[T] {
        self.tiles
    }
}
impl<T> DerefMut for Write<'_, T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T] {
        self.tiles
    }
}
