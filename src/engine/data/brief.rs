//! What is asked of many blocks of particles at a time, in a list beside them: the blocks themselves need not be brought for it.
use super::layout::ParticleLayout;
use super::particles::ParticleBlock;
use crate::schema::LabelId;
use grid::{BlockShape, IndexBox};
use simd::{Wide, prefetch_at, prefetch_later};

/// What others know of a block of particles.
#[derive(Clone, Copy, Debug)]
pub struct Brief {
    /// The nodes of its buffers that hold something (see [`ParticleBlock::touched`]).
    touched: [[u8; 3]; 2],
    /// The blocks of nodes around that have some of them (see [`BlockShape::reached`]).
    reached: u32,
    /// Lines of its columns; as many as a number can say, if there are more.
    lines: u16,
    /// The address of the first of them.
    first: usize,
    /// The address of the block.
    block: usize,
}

impl Brief {
    /// The most lines that are asked for as a whole.
    const MOST: u16 = 192;
    /// Of no block.
    pub const NOTHING: Self = Self { touched: [[0; 3]; 2], reached: 0, lines: 0, first: 0, block: 0 };

    /// Of a block as it is now.
    #[inline]
    pub fn of(block: &ParticleBlock, shape: &BlockShape) -> Self {
        let (first, lines) = block.address();
        // nodes of a buffer fit
        let corner = |corner: [i32; 3]| corner.map(|i| i as u8);
        Self {
            touched: [corner(block.touched.lower), corner(block.touched.upper)],
            reached: shape.reached(&block.touched),
            lines: lines.try_into().unwrap_or(u16::MAX),
            first: first as usize,
            block: std::ptr::from_ref(block) as usize,
        }
    }

    /// The nodes of its buffers that hold something.
    #[inline(always)]
    pub fn touched(&self) -> IndexBox {
        let [lower, upper] = self.touched.map(|corner| corner.map(i32::from));
        IndexBox { lower, upper }
    }

    /// Whether it touches nodes of the block from which it is seen at the `q`-th of the offsets around.
    #[inline(always)]
    pub fn reaches(&self, q: usize) -> bool {
        self.reached >> q & 1 == 1
    }

    /// Asks for the block, and for its columns if it has few particles: work on them is over before memory has brought them. Of others, for
    /// the first `tiles` of some labels: work on a tile asks for those behind it, and nobody for these.
    pub fn announce(&self, layout: &ParticleLayout, labels: impl Iterator<Item = LabelId>, tiles: usize) {
        let line = |first: usize, line: usize| (first + line * size_of::<Wide>()) as *const Wide;
        let header = size_of::<ParticleBlock>().div_ceil(size_of::<Wide>());
        (0..header).for_each(|n| prefetch_at(line(self.block, n)));
        if self.lines <= Self::MOST {
            return (0..self.lines.into()).for_each(|n| prefetch_at(line(self.first, n)));
        }
        let capacity = usize::from(self.lines) / layout.total;
        for label in labels {
            let first = layout.starts[label.index()] * capacity;
            (first..first + layout.width(label) * tiles).for_each(|n| prefetch_later(line(self.first, n)));
        }
    }
}
