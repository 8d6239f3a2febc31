//! Node data between blocks: what each block's particles add to nodes of others, and the nodes they read.
//!
//! Only the nodes that a block's particles can touch take part (see `ParticleBlock::touched`): the rest of its buffer
//! holds nothing.
use crate::data::nodes::{NOWHERE, NodeBlock, Place};
use crate::data::particles::ParticleBlock;
use crate::data::reduction;
use crate::data::warehouse::{NodePatch, ParticlePatch};
use crate::schema::Combine;
use grid::{BlockShape, IndexBox, SharedNodes, offset};
use simd::{Job, Simd, Wide, prefetch};
use std::ops::Range;

/// The nodes that a block shares with the `touched` part of the buffer of the one at `d`, and what to add to them to get their
/// index in that buffer.
#[inline(always)]
pub fn overlap(shape: &BlockShape, d: [i32; 3], touched: &IndexBox) -> Option<(IndexBox, [i32; 3])> {
    let (mut nodes, mut shift) = (IndexBox { lower: [0; 3], upper: [0; 3] }, [0; 3]);
    for a in 0..3 {
        let SharedNodes { first, end, to_buffer } = shape.shared[a][(d[a] + 1) as usize];
        let low = first.max(touched.lower[a] - to_buffer);
        let high = end.min(touched.upper[a] - to_buffer);
        if low >= high {
            return None;
        }
        (nodes.lower[a], nodes.upper[a], shift[a]) = (low, high, to_buffer);
    }
    Some((nodes, shift))
}

/// Every pencil along z that a block shares with the `touched` part of the buffer of the one at `d`: its nodes, and those of
/// the buffer. An iterator: what a closure does may be compiled as a function of its own, without the instruction set of the
/// caller.
#[inline(always)]
pub fn pencils(shape: &BlockShape, d: [i32; 3], touched: &IndexBox) -> Pencils {
    const NOTHING: (IndexBox, [i32; 3]) = (IndexBox { lower: [0; 3], upper: [0; 3] }, [0; 3]);
    let (nodes, shift) = overlap(shape, d, touched).unwrap_or(NOTHING);
    Pencils {
        at: [nodes.lower[0], nodes.lower[1]],
        nodes,
        shift,
        node_strides: shape.node_strides,
        buffer_strides: shape.buffer_strides,
    }
}

/// See [`pencils`].
pub struct Pencils {
    /// x and y of the next one.
    at: [i32; 2],
    nodes: IndexBox,
    shift: [i32; 3],
    node_strides: [i32; 3],
    buffer_strides: [i32; 3],
}

impl Iterator for Pencils {
    type Item = (Range<usize>, Range<usize>);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let ([x, y], IndexBox { lower, upper }) = (self.at, self.nodes);
        if x >= upper[0] {
            return None;
        }
        self.at = if y + 1 < upper[1] { [x, y + 1] } else { [x + 1, lower[1]] };
        let ([nx, ny, _], [bx, by, _], shift) = (self.node_strides, self.buffer_strides, self.shift);
        let own = (x * nx + y * ny + lower[2]) as usize;
        let there = ((x + shift[0]) * bx + (y + shift[1]) * by + lower[2] + shift[2]) as usize;
        let count = (upper[2] - lower[2]) as usize;
        Some((own..own + count, there..there + count))
    }
}

/// The lines of some nodes, of so many lines each.
#[inline(always)]
pub fn lines(nodes: Range<usize>, width: usize) -> Range<usize> {
    nodes.start * width..nodes.end * width
}

/// Sets the touched lines of the buffers of some fields to what adds nothing.
pub struct Clear<'a> {
    /// The buffers, one after the other.
    pub buffers: &'a mut [Wide],
    /// Lines a node.
    pub width: usize,
    /// What adds nothing.
    pub nothing: f64,
    /// How nodes follow one another.
    pub shape: &'a BlockShape,
    /// Their part.
    pub touched: &'a IndexBox,
}

impl Job for Clear<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let (shape, width) = (self.shape, self.width);
        match (shape.is_full(), width) {
            (true, 1) => self.clear::<S>(&BlockShape::FULL, 1),
            _ => self.clear::<S>(shape, width),
        }
    }
}

impl Clear<'_> {
    #[inline(always)]
    fn clear<S: Simd>(self, shape: &BlockShape, width: usize) {
        let [lower, upper] = [self.touched.lower, self.touched.upper].map(|n| n.map(|i| i as usize));
        let [sx, sy, _] = shape.buffer_strides.map(|s| s as usize);
        let nothing = S::splat(self.nothing);
        for buffer in self.buffers.chunks_exact_mut(shape.buffer_len() * width) {
            for x in lower[0]..upper[0] {
                for y in lower[1]..upper[1] {
                    let row = x * sx + y * sy;
                    let row = lines(row + lower[2]..row + upper[2], width);
                    buffer[row].iter_mut().for_each(|line| nothing.store(line));
                }
            }
        }
    }
}

/// What the blocks around a node block add to the nodes of one field.
#[derive(Clone, Copy)]
pub struct Around<'a> {
    /// Which label (see [`ParticleBlock::partials`]).
    pub place: usize,
    /// The material.
    pub material: usize,
    /// Which field of the material.
    pub field: usize,
    /// Lines a node.
    pub width: usize,
    /// How nodes follow one another.
    pub shape: &'a BlockShape,
    /// All particle blocks.
    pub particles: &'a [Vec<ParticlePatch>],
    /// The blocks around.
    pub around: &'a [Place; 27],
}

impl<'a> Around<'a> {
    #[inline(always)]
    fn block(&self, q: usize) -> Option<&'a ParticleBlock> {
        let (patch, at) = *self.around.get(q).filter(|&&n| n != NOWHERE)?;
        Some(&self.particles[patch as usize][self.material].blocks[at as usize])
    }

    /// The buffer of the `q`-th block around and its part that holds something.
    #[inline(always)]
    fn partial(&self, q: usize) -> Option<(&'a [Wide], &'a IndexBox)> {
        let block = self.block(q)?;
        let length = self.shape.buffer_len() * self.width;
        let partial = block.partials[self.place].get(self.field * length..(self.field + 1) * length)?;
        Some((partial, &block.touched))
    }

    /// Whether any block around touches the nodes.
    pub fn is_something(&self) -> bool {
        let touches =
            |q| self.block(q).is_some_and(|block| overlap(self.shape, offset(q), &block.touched).is_some());
        // the block itself first: mostly that settles it
        touches(13) || (0..27).any(touches)
    }

    /// Asks for the lines that the `q`-th block around adds.
    #[inline(always)]
    fn announce(&self, q: usize) {
        if let Some((partial, touched)) = self.partial(q) {
            for (_, there) in pencils(self.shape, offset(q), touched) {
                lines(there, self.width).for_each(|line| prefetch(&partial[line..], 0));
            }
        }
    }
}

/// The sums of a block's nodes: what all blocks around add to them, in the order of `grid::around`.
pub struct SumPartials<'a> {
    /// The summands.
    pub from: Around<'a>,
    /// How they combine.
    pub combine: Combine,
    /// The sums.
    pub sums: &'a mut [Wide],
}

/// How many neighbors ahead buffers are asked for.
const AHEAD: usize = 3;

impl Job for SumPartials<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { from, combine, sums } = self;
        match (combine, from.shape.is_full(), from.width) {
            (Combine::Sum, true, 1) => {
                Around { shape: &BlockShape::FULL, width: 1, ..from }.add::<S>(sums);
            }
            (Combine::Sum, ..) => from.add::<S>(sums),
            _ => merge(&from, combine, sums),
        }
    }
}

impl Around<'_> {
    /// Sums up all summands.
    #[inline(always)]
    fn add<S: Simd>(self, sums: &mut [Wide]) {
        let from = self;
        sums.fill(Wide::default());
        (0..AHEAD).for_each(|q| from.announce(q));
        for q in 0..27 {
            from.announce(q + AHEAD);
            let Some((partial, touched)) = from.partial(q) else { continue };
            for (own, there) in pencils(from.shape, offset(q), touched) {
                let (own, there) = (lines(own, from.width), lines(there, from.width));
                for (sum, part) in sums[own].iter_mut().zip(&partial[there]) {
                    (S::load(sum) + S::load(part)).store(sum);
                }
            }
        }
    }
}

/// The same for what combines in any order.
fn merge(from: &Around<'_>, combine: Combine, sums: &mut [Wide]) {
    reduction::clear(combine, sums);
    for q in 0..27 {
        let Some((partial, touched)) = from.partial(q) else { continue };
        for (own, there) in pencils(from.shape, offset(q), touched) {
            let (own, there) = (lines(own, from.width), lines(there, from.width));
            reduction::merge(combine, &mut sums[own], &partial[there]);
        }
    }
}

/// The values of the nodes around a particle block, as far as its particles touch them.
#[derive(Clone, Copy)]
pub struct ValuesAround<'a> {
    /// Which label (see [`NodeBlock::column`]).
    pub place: usize,
    /// The field.
    pub field: crate::data::fields::FieldId,
    /// Lines a node.
    pub width: usize,
    /// How nodes follow one another.
    pub shape: &'a BlockShape,
    /// All node blocks.
    pub nodes: &'a [NodePatch],
    /// The blocks around.
    pub around: &'a [Place; 27],
    /// The part of the block's buffer that is touched.
    pub touched: &'a IndexBox,
}

impl<'a> ValuesAround<'a> {
    /// The values of the `q`-th node block around.
    #[inline(always)]
    fn values(&self, q: usize) -> Option<&'a [Wide]> {
        let (patch, at) = *self.around.get(q).filter(|&&n| n != NOWHERE)?;
        let block: &NodeBlock = &self.nodes[patch as usize].blocks[at as usize];
        let length = self.shape.node_count() * self.width;
        let slot = block.slot(self.field)?;
        block.column(self.place).get(slot * length..(slot + 1) * length)
    }

    /// Asks for the lines that the `q`-th node block around has.
    #[inline(always)]
    fn announce(&self, q: usize) {
        if let Some(values) = self.values(q) {
            for (own, _) in pencils(self.shape, back(q), self.touched) {
                lines(own, self.width).for_each(|line| prefetch(&values[line..], 0));
            }
        }
    }
}

/// Seen from the `q`-th block around, this one lies the other way.
#[inline(always)]
pub fn back(q: usize) -> [i32; 3] {
    let [x, y, z] = offset(q);
    [-x, -y, -z]
}

/// Fills a block's buffer with the values of the nodes around; with zeros where they are not there.
pub struct LoadRegion<'a> {
    /// With what.
    pub from: ValuesAround<'a>,
    /// The buffer.
    pub region: &'a mut [Wide],
}

impl Job for LoadRegion<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { from, region } = self;
        match (from.shape.is_full(), from.width) {
            (true, 1) => ValuesAround { shape: &BlockShape::FULL, width: 1, ..from }.load::<S>(region),
            _ => from.load::<S>(region),
        }
    }
}

impl ValuesAround<'_> {
    /// Fills a buffer.
    #[inline(always)]
    fn load<S: Simd>(self, region: &mut [Wide]) {
        let from = self;
        (0..AHEAD).for_each(|q| from.announce(q));
        for q in 0..27 {
            from.announce(q + AHEAD);
            let values = from.values(q);
            for (own, here) in pencils(from.shape, back(q), from.touched) {
                let (own, here) = (lines(own, from.width), lines(here, from.width));
                let Some(values) = values else {
                    region[here].fill(Wide::default());
                    continue;
                };
                for (to, from) in region[here].iter_mut().zip(&values[own]) {
                    S::load(from).store(to);
                }
            }
        }
    }
}
