//! Node data between blocks: what each block's particles add to nodes of others, and the nodes they read.
use crate::data::nodes::{NOWHERE, NodeBlock};
use crate::data::particles::ParticleBlock;
use crate::data::warehouse::{NodePatch, ParticlePatch};
use crate::grid::offset;
use crate::physics::shape::STRIDE;
use crate::simd::{Job, Simd, Wide};
use std::ops::Range;

/// For one axis: the nodes (0 to 3) of a block that lie in the buffer of the block at offset `d`, and what to add
/// to them to get their index in that buffer. A buffer begins one node below its block.
fn shared_nodes(d: i32) -> (Range<usize>, isize) {
    match d {
        -1 => (0..3, 5),
        0 => (0..4, 1),
        _ => (3..4, -3),
    }
}

/// Runs `each(nodes, buffer lines)` on every pencil along z that a block shares with the buffer of the one at `d`.
#[inline(always)]
fn pencils(d: [i32; 3], mut each: impl FnMut(Range<usize>, Range<usize>)) {
    let [(xs, dx), (ys, dy), (zs, dz)] = d.map(shared_nodes);
    let z_in_buffer = zs.start.wrapping_add_signed(dz);
    for x in xs {
        for y in ys.clone() {
            let own = (x * 4 + y) * 4;
            let row = x.wrapping_add_signed(dx) * STRIDE[0] + y.wrapping_add_signed(dy) * STRIDE[1];
            let first = row + z_in_buffer;
            each(own + zs.start..own + zs.end, first..first + zs.len());
        }
    }
}

/// A block's 64 node sums: what all blocks around add to them, in the order of `grid::around`.
pub struct SumPartials<'a> {
    /// Which partial buffers (see [`ParticleBlock::partials`]).
    pub which: usize,
    /// The material.
    pub material: usize,
    /// All particle blocks.
    pub particles: &'a [Vec<ParticlePatch>],
    /// The blocks around.
    pub around: &'a [(u32, u32); 27],
    /// The 64 sums.
    pub sums: &'a mut [Wide],
}

impl Job for SumPartials<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        self.sums.fill(Wide::default());
        for (q, &(patch, at)) in (0..).zip(self.around).filter(|(_, n)| **n != NOWHERE) {
            let block: &ParticleBlock = &self.particles[patch as usize][self.material].blocks[at as usize];
            let partial = &block.partials[self.which];
            if partial.is_empty() {
                continue;
            }
            pencils(offset(q), |own, there| {
                for (sum, part) in self.sums[own].iter_mut().zip(&partial[there]) {
                    (S::load(sum) + S::load(part)).store(sum);
                }
            });
        }
    }
}

/// A block's 8x8x8 buffer, filled with the motion of the nodes around.
pub struct LoadRegion<'a> {
    /// The material.
    pub material: usize,
    /// All node blocks.
    pub nodes: &'a [NodePatch],
    /// The blocks around.
    pub around: &'a [(u32, u32); 27],
    /// The buffer.
    pub region: &'a mut [Wide],
}

impl Job for LoadRegion<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        for (q, &(patch, at)) in (0..).zip(self.around) {
            // seen from the other block, this one lies the other way
            let back = offset(q).map(|d| -d);
            let block: Option<&NodeBlock> =
                ((patch, at) != NOWHERE).then(|| &self.nodes[patch as usize].blocks[at as usize]);
            let motion = block.and_then(|b| b.motion_of(self.material));
            pencils(back, |own, here| match motion {
                Some(motion) => {
                    for (to, from) in self.region[here].iter_mut().zip(&motion[own]) {
                        S::load(from).store(to);
                    }
                }
                None => self.region[here].fill(Wide::default()),
            });
        }
    }
}
