//! Something for each block of a box.
use super::nodes::{NOWHERE, Place};
use grid::{BlockIndex, IndexBox, around};

/// Layers around a box that maps hold, so that no neighbor of a block in it is outside of them.
const PADDING: i32 = 3;

/// Some words for each block of a box, and of some layers around it.
pub struct Map<T> {
    bounds: IndexBox,
    strides: [isize; 3],
    /// Words a block.
    pub words: usize,
    cells: Vec<T>,
}

impl<T: Copy> Map<T> {
    /// A map with `value` everywhere.
    pub fn new(level: IndexBox, words: usize, value: T) -> Self {
        let bounds = level.grown(PADDING);
        let [_, ny, nz] = bounds.size().map(|n| n as isize);
        Self { bounds, strides: [ny * nz, nz, 1], words, cells: vec![value; words * bounds.len()] }
    }

    /// Whether a block and all at most `layers` from it are in the map.
    pub fn holds(&self, index: BlockIndex, layers: i32) -> bool {
        self.bounds.grown(-layers).contains(index)
    }

    /// Where a block is, if it is in the box or near it.
    pub fn find(&self, index: BlockIndex) -> Option<usize> {
        self.bounds.contains(index).then(|| self.at(index))
    }

    /// Where a block of the box is.
    pub fn at(&self, index: BlockIndex) -> usize {
        self.delta([0, 1, 2].map(|a| index[a] - self.bounds.lower[a])) as usize
    }

    /// From a block to the one at `offset`.
    pub fn delta(&self, offset: [i32; 3]) -> isize {
        (0..3).map(|a| offset[a] as isize * self.strides[a]).sum()
    }

    /// From a block to those around it.
    pub fn deltas(&self) -> [isize; 27] {
        let mut deltas = [0; 27];
        deltas.iter_mut().zip(around()).for_each(|(delta, offset)| *delta = self.delta(offset));
        deltas
    }

    /// The words of a block.
    pub fn get(&self, at: usize) -> &[T] {
        &self.cells[at * self.words..(at + 1) * self.words]
    }

    /// One of the words of a block.
    #[inline(always)]
    pub fn word_mut(&mut self, at: usize, word: usize) -> &mut T {
        &mut self.cells[at * self.words + word]
    }
}

impl Map<Place> {
    /// Where blocks are, from the indices of each patch's blocks in their order; for the smallest box around them, so that
    /// what is small costs little.
    pub fn of_places<I: Iterator<Item = BlockIndex>>(patches: impl Iterator<Item = I> + Clone) -> Self {
        let one = |index: BlockIndex| IndexBox { lower: index, upper: index.map(|i| i + 1) };
        let bounds = patches.clone().flatten().map(one).reduce(|a, b| a.around(&b));
        let mut map = Self::new(bounds.unwrap_or(IndexBox { lower: [0; 3], upper: [0; 3] }), 1, NOWHERE);
        for (patch, indices) in (0..).zip(patches) {
            for (position, index) in (0..).zip(indices) {
                let at = map.at(index);
                map.cells[at] = (patch, position);
            }
        }
        map
    }

    /// The blocks around one, which may lie outside of the map, in the order of `grid::around`.
    #[inline]
    pub fn around(&self, index: BlockIndex, deltas: &[isize; 27]) -> [Place; 27] {
        if self.holds(index, 1) {
            let at = self.at(index);
            return deltas.map(|delta| self.cells[at.wrapping_add_signed(delta)]);
        }
        let mut places = [NOWHERE; 27];
        for (place, offset) in places.iter_mut().zip(around()) {
            let at = self.find([0, 1, 2].map(|a| index[a] + offset[a]));
            *place = at.map_or(NOWHERE, |at| self.cells[at]);
        }
        places
    }

    /// The block `delta` from the one at `at`.
    #[inline(always)]
    pub fn place(&self, at: usize, delta: isize) -> Place {
        self.cells[at.wrapping_add_signed(delta)]
    }
}
