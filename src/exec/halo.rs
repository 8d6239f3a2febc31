//! Node data between blocks: what each block's particles add to nodes of others, and the nodes they read.
//!
//! Only the nodes that a block's particles can touch take part (see `ParticleBlock::touched`): the rest of its buffer
//! holds nothing.
use crate::data::nodes::{NOWHERE, NodeBlock};
use crate::data::particles::ParticleBlock;
use crate::data::warehouse::{NodePatch, ParticlePatch};
use crate::grid::{IndexBox, offset};
use crate::physics::shape::STRIDE;
use crate::simd::{Job, Simd, Wide, prefetch};
use std::ops::Range;

/// For one axis: the nodes (0 to 3) of a block that lie in the buffer of the block at offset `d`, and what to add
/// to them to get their index in that buffer. A buffer begins one node below its block.
fn shared_nodes(d: i32) -> (Range<i32>, i32) {
    match d {
        -1 => (0..3, 5),
        0 => (0..4, 1),
        _ => (3..4, -3),
    }
}

/// The nodes (0 to 3 on each axis) that a block shares with the `touched` part of the buffer of the one at `d`, and what
/// to add to them to get their index in that buffer.
#[inline(always)]
pub fn overlap(d: [i32; 3], touched: &IndexBox) -> Option<(IndexBox, [i32; 3])> {
    let (mut nodes, mut shift) = (IndexBox { lower: [0; 3], upper: [0; 3] }, [0; 3]);
    for a in 0..3 {
        let (shared, to_buffer) = shared_nodes(d[a]);
        let low = shared.start.max(touched.lower[a] - to_buffer);
        let high = shared.end.min(touched.upper[a] - to_buffer);
        if low >= high {
            return None;
        }
        (nodes.lower[a], nodes.upper[a], shift[a]) = (low, high, to_buffer);
    }
    Some((nodes, shift))
}

/// Runs `each(nodes, buffer lines)` on every pencil along z that a block shares with the `touched` part of the buffer
/// of the one at `d`.
#[inline(always)]
pub fn pencils(d: [i32; 3], touched: &IndexBox, mut each: impl FnMut(Range<usize>, Range<usize>)) {
    let Some((nodes, shift)) = overlap(d, touched) else { return };
    let IndexBox { lower: [x0, y0, z0], upper: [x1, y1, z1] } = nodes;
    let stride = STRIDE.map(|s| s as i32);
    for x in x0..x1 {
        for y in y0..y1 {
            let own = ((x * 4 + y) * 4 + z0) as usize;
            let line = (x + shift[0]) * stride[0] + (y + shift[1]) * stride[1] + z0 + shift[2];
            let (line, count) = (line as usize, (z1 - z0) as usize);
            each(own..own + count, line..line + count);
        }
    }
}

/// Sets the touched lines of a partial buffer to zero.
pub struct Clear<'a> {
    /// The buffer.
    pub buffer: &'a mut [Wide],
    /// Its part.
    pub touched: &'a IndexBox,
}

impl Job for Clear<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let [lower, upper] = [self.touched.lower, self.touched.upper].map(|n| n.map(|i| i as usize));
        let zero = S::splat(0.0);
        for x in lower[0]..upper[0] {
            for y in lower[1]..upper[1] {
                let row = x * STRIDE[0] + y * STRIDE[1];
                self.buffer[row + lower[2]..row + upper[2]].iter_mut().for_each(|line| zero.store(line));
            }
        }
    }
}

/// What the blocks around a node block add to the nodes of one material.
#[derive(Clone, Copy)]
pub struct Around<'a> {
    /// Which partial buffers (see [`ParticleBlock::partials`]).
    pub which: usize,
    /// The material.
    pub material: usize,
    /// All particle blocks.
    pub particles: &'a [Vec<ParticlePatch>],
    /// The blocks around.
    pub around: &'a [(u32, u32); 27],
}

impl<'a> Around<'a> {
    /// The buffer of the `q`-th block around and its part that holds something.
    #[inline(always)]
    fn partial(&self, q: usize) -> Option<(&'a [Wide], &'a IndexBox)> {
        let (patch, at) = *self.around.get(q).filter(|&&n| n != NOWHERE)?;
        let block: &ParticleBlock = &self.particles[patch as usize][self.material].blocks[at as usize];
        let partial = &block.partials[self.which];
        (!partial.is_empty()).then_some((partial, &block.touched))
    }

    /// Whether any block around adds anything.
    pub fn is_something(&self) -> bool {
        let adds = |q| self.partial(q).is_some_and(|(_, touched)| overlap(offset(q), touched).is_some());
        // the block itself first: mostly that settles it
        adds(13) || (0..27).any(adds)
    }

    /// Asks for the lines that the `q`-th block around adds.
    #[inline(always)]
    fn announce(&self, q: usize) {
        if let Some((partial, touched)) = self.partial(q) {
            pencils(offset(q), touched, |_, there| there.for_each(|line| prefetch(&partial[line..], 0)));
        }
    }
}

/// A block's 64 node sums: what all blocks around add to them, in the order of `grid::around`.
pub struct SumPartials<'a> {
    /// The summands.
    pub from: Around<'a>,
    /// The 64 sums.
    pub sums: &'a mut [Wide],
}

/// How many neighbors ahead buffers are asked for.
const AHEAD: usize = 3;

impl Job for SumPartials<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        self.sums.fill(Wide::default());
        (0..AHEAD).for_each(|q| self.from.announce(q));
        for q in 0..27 {
            self.from.announce(q + AHEAD);
            let Some((partial, touched)) = self.from.partial(q) else { continue };
            pencils(offset(q), touched, |own, there| {
                for (sum, part) in self.sums[own].iter_mut().zip(&partial[there]) {
                    (S::load(sum) + S::load(part)).store(sum);
                }
            });
        }
    }
}

/// The motion of the nodes around a particle block, as far as its particles touch them.
#[derive(Clone, Copy)]
pub struct MotionAround<'a> {
    /// The material.
    pub material: usize,
    /// All node blocks.
    pub nodes: &'a [NodePatch],
    /// The blocks around.
    pub around: &'a [(u32, u32); 27],
    /// The part of the block's buffer that is touched.
    pub touched: &'a IndexBox,
}

impl<'a> MotionAround<'a> {
    /// The motion of the `q`-th node block around.
    #[inline(always)]
    fn motion(&self, q: usize) -> Option<&'a [Wide]> {
        let (patch, at) = *self.around.get(q).filter(|&&n| n != NOWHERE)?;
        let block: &NodeBlock = &self.nodes[patch as usize].blocks[at as usize];
        block.motion_of(self.material)
    }

    /// Asks for the lines that the `q`-th node block around gives.
    #[inline(always)]
    fn announce(&self, q: usize) {
        if let Some(motion) = self.motion(q) {
            pencils(back(q), self.touched, |own, _| own.for_each(|node| prefetch(&motion[node..], 0)));
        }
    }
}

/// Seen from the `q`-th block around, this one lies the other way.
#[inline(always)]
pub fn back(q: usize) -> [i32; 3] {
    let [x, y, z] = offset(q);
    [-x, -y, -z]
}

/// Fills a block's 8x8x8 buffer.
pub struct LoadRegion<'a> {
    /// With what.
    pub from: MotionAround<'a>,
    /// The buffer.
    pub region: &'a mut [Wide],
}

impl Job for LoadRegion<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { from, region } = self;
        (0..AHEAD).for_each(|q| from.announce(q));
        for q in 0..27 {
            from.announce(q + AHEAD);
            let Some(motion) = from.motion(q) else { continue };
            pencils(back(q), from.touched, |own, here| {
                for (to, from) in region[here].iter_mut().zip(&motion[own]) {
                    S::load(from).store(to);
                }
            });
        }
    }
}
