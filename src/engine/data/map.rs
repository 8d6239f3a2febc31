//! Something for each block, in pages: memory follows the blocks that there are, not the level that they lie in.
use super::nodes::{NOWHERE, Place};
use grid::{BlockIndex, IndexBox};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Blocks of a page along an axis: a power of two, so large that most neighbors of a block lie in its own page.
const SIDE: i32 = 8;
/// Blocks of a page.
const PAGE: usize = (SIDE * SIDE * SIDE) as usize;
/// From a block of a page to the next one along each axis.
const STRIDES: [usize; 3] = [(SIDE * SIDE) as usize, SIDE as usize, 1];

/// A table by the indices of blocks or pages. Nobody chooses them to collide, so a cheap hash will do.
pub type ByIndex<T> = HashMap<BlockIndex, T, BuildHasherDefault<Mixer>>;

/// Multiplies and rotates (after FxHash of rustc).
#[derive(Clone, Copy, Debug, Default)]
pub struct Mixer(u64);

impl Mixer {
    #[inline]
    fn mix(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(5) ^ word).wrapping_mul(0x517C_C1B7_2722_0A95);
    }
}

impl Hasher for Mixer {
    #[inline]
    fn write(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks();
        words.iter().for_each(|word| self.mix(u64::from(u32::from_ne_bytes(*word))));
        rest.iter().for_each(|byte| self.mix(u64::from(*byte)));
    }

    #[inline]
    fn write_usize(&mut self, word: usize) {
        self.mix(word as u64);
    }

    /// A table takes the low bits, and a product has mixed the high ones best.
    #[inline]
    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }
}

/// Some words for each block; those of a block that nobody has set are `empty`.
pub struct Map<T> {
    /// Words a block.
    words: usize,
    empty: T,
    /// The pages that there are, by their index.
    directory: ByIndex<u32>,
    /// Index of each page.
    pages: Vec<[i32; 3]>,
    cells: Vec<T>,
}

fn page_of(index: BlockIndex) -> [i32; 3] {
    index.map(|i| i.div_euclid(SIDE))
}

/// Where a block is in its page.
fn within(index: BlockIndex) -> usize {
    (0..3).map(|a| index[a].rem_euclid(SIDE) as usize * STRIDES[a]).sum()
}

/// The blocks of a page.
fn blocks_of(page: [i32; 3]) -> IndexBox {
    IndexBox { lower: page.map(|p| p * SIDE), upper: page.map(|p| (p + 1) * SIDE) }
}

impl<T: Copy + PartialEq> Map<T> {
    /// A map with `empty` everywhere.
    pub fn new(words: usize, empty: T) -> Self {
        Self { words, empty, directory: ByIndex::default(), pages: Vec::new(), cells: Vec::new() }
    }

    /// The number of a page, which is made if it is not there.
    fn page(&mut self, page: [i32; 3]) -> usize {
        let Self { words, empty, directory, pages, cells } = self;
        let number = directory.entry(page).or_insert_with(|| {
            pages.push(page);
            cells.resize(pages.len() * PAGE * *words, *empty);
            pages.len() as u32 - 1
        });
        *number as usize
    }

    /// Where a block is, in a page that is made if need be.
    pub fn place(&mut self, index: BlockIndex) -> usize {
        self.page(page_of(index)) * PAGE + within(index)
    }

    /// Where the 27 blocks around a block are, in the order of `grid::around`; their pages are made if need be.
    pub fn places_around(&mut self, index: BlockIndex) -> [usize; 27] {
        let lower = index.map(|i| i - 1);
        if page_of(lower) == page_of(index.map(|i| i + 1)) {
            let first = self.place(lower);
            return std::array::from_fn(|q| {
                first + [q / 9, q / 3 % 3, q % 3].iter().zip(STRIDES).map(|(i, s)| i * s).sum::<usize>()
            });
        }
        std::array::from_fn(|q| {
            let offset = grid::offset(q);
            self.place([0, 1, 2].map(|a| index[a] + offset[a]))
        })
    }

    /// The words of the block at a place.
    pub fn words_mut(&mut self, place: usize) -> &mut [T] {
        &mut self.cells[place * self.words..][..self.words]
    }

    /// The words of the block at a place.
    pub fn words(&self, place: usize) -> &[T] {
        &self.cells[place * self.words..][..self.words]
    }

    /// The words of a block, if its page is there.
    pub fn get(&self, index: BlockIndex) -> Option<&[T]> {
        let page = *self.directory.get(&page_of(index))? as usize;
        Some(self.words(page * PAGE + within(index)))
    }

    /// The blocks of which a word is set, with their words, in no order.
    pub fn set(&self) -> impl Iterator<Item = (BlockIndex, &[T])> {
        let pages = self.pages.iter().zip(self.cells.chunks_exact(PAGE * self.words));
        pages.flat_map(move |(page, cells)| {
            let blocks = blocks_of(*page).iter().zip(cells.chunks_exact(self.words));
            blocks.filter(|(_, words)| words.iter().any(|word| *word != self.empty))
        })
    }

    /// Parts of a box of blocks, each within a page that is there, with the place of the page's first block.
    fn parts(&self, blocks: IndexBox) -> impl Iterator<Item = (IndexBox, usize)> {
        let last = page_of(blocks.upper.map(|i| i - 1));
        let pages = IndexBox { lower: page_of(blocks.lower), upper: last.map(|p| p + 1) };
        pages.iter().filter_map(move |page| {
            let number = *self.directory.get(&page)? as usize;
            Some((blocks_of(page).common(&blocks), number * PAGE))
        })
    }
}

impl Map<Place> {
    /// Where blocks are, from the indices of each patch's blocks in their order.
    pub fn of_places<I: Iterator<Item = BlockIndex>>(patches: impl Iterator<Item = I>) -> Self {
        let mut map = Self::new(1, NOWHERE);
        for (patch, indices) in (0..).zip(patches) {
            for (position, index) in (0..).zip(indices) {
                let place = map.place(index);
                map.cells[place] = (patch, position);
            }
        }
        map
    }

    /// The blocks around one, in the order of `grid::around`.
    #[inline]
    pub fn around(&self, index: BlockIndex) -> [Place; 27] {
        let lower = index.map(|i| i - 1);
        let (page, mut places) = (page_of(lower), [NOWHERE; 27]);
        if page == page_of(index.map(|i| i + 1)) {
            if let Some(&number) = self.directory.get(&page) {
                let first = number as usize * PAGE + within(lower);
                for (row, places) in places.chunks_exact_mut(3).enumerate() {
                    let at = first + row / 3 * STRIDES[0] + row % 3 * STRIDES[1];
                    places.copy_from_slice(&self.cells[at..at + 3]);
                }
            }
            return places;
        }
        for (part, first) in self.parts(IndexBox::of(index).grown(1)) {
            for block in part.iter() {
                let q = (0..3).fold(0, |q, a| 3 * q + (block[a] - lower[a]) as usize);
                places[q] = self.cells[first + within(block)];
            }
        }
        places
    }

    /// The blocks in a box, in no order.
    pub fn inside(&self, blocks: IndexBox) -> impl Iterator<Item = Place> {
        let parts = self.parts(blocks);
        let all = parts
            .flat_map(move |(part, first)| part.iter().map(move |block| self.cells[first + within(block)]));
        all.filter(|place| *place != NOWHERE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use grid::around;
    use std::collections::{BTreeMap, BTreeSet};

    /// Blocks that crowd around the borders of pages, and some that are far from all.
    fn indices() -> Vec<BlockIndex> {
        let mut seed = 1u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as i32
        };
        let mut all: BTreeSet<BlockIndex> =
            (0..400).map(|_| [0; 3].map(|_| random().rem_euclid(21) - 10)).collect();
        all.extend([[1 << 28, -(1 << 28), 7], [(1 << 28) + 1, -(1 << 28), 8], [-9, 5, 1 << 20]]);
        all.into_iter().collect()
    }

    #[test]
    fn neighbors_are_those_of_a_plain_table() {
        let all = indices();
        let patches = [&all[..150], &all[150..]];
        let map = Map::of_places(patches.iter().map(|patch| patch.iter().copied()));
        let mut plain = BTreeMap::new();
        for (patch, indices) in (0..).zip(patches) {
            plain.extend((0..).zip(indices).map(|(position, &index)| (index, (patch, position))));
        }
        let place = |index: &BlockIndex| plain.get(index).copied().unwrap_or(NOWHERE);
        // of blocks in the map, beside it and far from it
        for index in
            all.iter().flat_map(|&index| around().map(move |d| [0, 1, 2].map(|a| index[a] + 2 * d[a])))
        {
            let shifted = |d: [i32; 3]| [0, 1, 2].map(|a| index[a] + d[a]);
            assert!(map.around(index).into_iter().eq(around().map(|d| place(&shifted(d)))), "{index:?}");
            let cube = IndexBox { lower: shifted([-3; 3]), upper: shifted([4; 3]) };
            let mut inside: Vec<Place> = map.inside(cube).collect();
            inside.sort_unstable();
            let mut wanted: Vec<Place> = cube.iter().map(|i| place(&i)).filter(|p| *p != NOWHERE).collect();
            wanted.sort_unstable();
            assert_eq!(inside, wanted, "{index:?}");
        }
        assert_eq!(map.around([1 << 20; 3]), [NOWHERE; 27]);
    }

    #[test]
    fn words_are_found_where_they_were_set_and_memory_follows_them() {
        let (all, mut map) = (indices(), Map::new(2, 0u64));
        let mut plain: BTreeMap<BlockIndex, [u64; 2]> = BTreeMap::new();
        for (n, &index) in all.iter().enumerate() {
            for place in map.places_around(index) {
                map.words_mut(place)[n % 2] |= 1 << (n % 64);
            }
            for offset in around() {
                plain.entry([0, 1, 2].map(|a| index[a] + offset[a])).or_default()[n % 2] |= 1 << (n % 64);
            }
        }
        let found: BTreeMap<BlockIndex, [u64; 2]> =
            map.set().map(|(index, words)| (index, [words[0], words[1]])).collect();
        assert_eq!(found, plain);
        assert!(plain.iter().all(|(&index, words)| map.get(index) == Some(&words[..])));
        assert_eq!(map.get([1 << 20; 3]), None);
        // at most eight pages a block that stands alone, whatever lies between it and the others
        assert!(map.pages.len() <= 4 * 4 * 4 + 3 * 8, "{}", map.pages.len());
    }
}
