//! The sums of nodes: what the particle blocks around a node block add to its nodes, in an order that no decomposition changes.
use super::halo::{Pencils, lines, overlap, pencils};
use crate::data::nodes::{NOWHERE, Place};
use crate::data::particles::ParticleBlock;
use crate::data::reduction;
use crate::data::warehouse::ParticlePatch;
use crate::schema::Combine;
use grid::{BlockShape, offset};
use simd::{Job, Simd, Wide, prefetch};

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

    /// The buffer of the `q`-th block around, and the pencils along z that both blocks have.
    #[inline(always)]
    fn partial(&self, q: usize) -> Option<(&'a [Wide], Pencils)> {
        let block = self.block(q)?;
        let length = self.shape.buffer_len() * self.width;
        let partial = block.partials[self.place].get(self.field * length..(self.field + 1) * length)?;
        Some((partial, pencils(self.shape, offset(q), &block.touched)))
    }

    /// Asks for the lines that the `q`-th block around adds.
    #[inline(always)]
    fn announce(&self, q: usize) {
        if let Some((partial, pencils)) = self.partial(q) {
            for (_, there) in pencils {
                lines(there, self.width).for_each(|line| prefetch(partial, line));
            }
        }
    }

    /// Whether any block around touches the nodes.
    pub fn is_something(&self) -> bool {
        let touches =
            |q| self.block(q).is_some_and(|block| overlap(self.shape, offset(q), &block.touched).is_some());
        (0..27).filter_map(|q| self.block(q)).for_each(ParticleBlock::announce);
        // the block itself first: mostly that settles it
        touches(13) || (0..27).any(touches)
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
                add::<S>(&Around { shape: &BlockShape::FULL, width: 1, ..from }, sums);
            }
            (Combine::Sum, ..) => add::<S>(&from, sums),
            _ => merge(&from, combine, sums),
        }
    }
}

/// Sums up all summands.
#[inline(always)]
fn add<S: Simd>(from: &Around<'_>, sums: &mut [Wide]) {
    sums.fill(Wide::default());
    (0..AHEAD).for_each(|q| from.announce(q));
    for q in 0..27 {
        from.announce(q + AHEAD);
        let Some((partial, pencils)) = from.partial(q) else { continue };
        for (own, there) in pencils {
            let (own, there) = (lines(own, from.width), lines(there, from.width));
            for (sum, part) in sums[own].iter_mut().zip(&partial[there]) {
                (S::load(sum) + S::load(part)).store(sum);
            }
        }
    }
}

/// The same for what combines in any order.
fn merge(from: &Around<'_>, combine: Combine, sums: &mut [Wide]) {
    reduction::clear(combine, sums);
    for q in 0..27 {
        let Some((partial, pencils)) = from.partial(q) else { continue };
        for (own, there) in pencils {
            let (own, there) = (lines(own, from.width), lines(there, from.width));
            reduction::merge(combine, &mut sums[own], &partial[there]);
        }
    }
}
