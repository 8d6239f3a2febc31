//! The sums of nodes: what the particle blocks around a node block add to its nodes, in an order that no decomposition changes.
use super::halo::{Pencils, lines, pencils};
use crate::data::nodes::{NOWHERE, Place};
use crate::data::reduction;
use crate::data::warehouse::ParticlePatch;
use crate::schema::Combine;
use grid::{BlockShape, offset};
use simd::{Job, Simd, Wide, prefetch};

/// What the blocks around a node block add to the nodes of one field.
#[derive(Clone, Copy)]
pub struct Around<'a> {
    /// Which label (see [`partials`](crate::data::particles::ParticleBlock::partials)).
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
    /// The `q`-th block around is one of these blocks, at this position.
    #[inline(always)]
    fn home(&self, q: usize) -> Option<(&'a ParticlePatch, usize)> {
        let (patch, at) = *self.around.get(q).filter(|&&n| n != NOWHERE)?;
        Some((&self.particles[patch as usize][self.material], at as usize))
    }

    /// The buffer of the `q`-th block around, and the pencils along z that both blocks have.
    #[inline(always)]
    fn partial(&self, q: usize) -> Option<(&'a [Wide], Pencils)> {
        let (home, at) = self.home(q)?;
        let length = self.shape.buffer_len() * self.width;
        let partials = &home.blocks[at].partials[self.place];
        let partial = partials.get(self.field * length..(self.field + 1) * length)?;
        Some((partial, pencils(self.shape, offset(q), &home.briefs[at].touched())))
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

    /// The blocks around that touch the nodes; what says where their buffers are is asked for.
    pub fn touching(&self) -> Touching {
        let mut bits = 0;
        for q in 0..27 {
            if let Some((home, at)) = self.home(q)
                && home.briefs[at].reaches(q)
            {
                home.blocks[at].announce();
                bits |= 1 << q;
            }
        }
        Touching(bits)
    }
}

/// Blocks around a node block, as bits in the order of `grid::around`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Touching(u32);

impl Touching {
    /// Whether it is none.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl Iterator for Touching {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let q = self.0.trailing_zeros();
        self.0 &= self.0.wrapping_sub(1);
        (q < u32::BITS).then_some(q as usize)
    }
}

/// The sums of a block's nodes: what all blocks around add to them, in the order of `grid::around`.
pub struct SumPartials<'a> {
    /// The summands.
    pub from: Around<'a>,
    /// Whose they are.
    pub touching: Touching,
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
        let Self { from, touching, combine, sums } = self;
        match (combine, from.shape.is_full(), from.width) {
            (Combine::Sum, true, 1) => {
                add::<S>(&Around { shape: &BlockShape::FULL, width: 1, ..from }, touching, sums);
            }
            (Combine::Sum, ..) => add::<S>(&from, touching, sums),
            _ => merge(&from, touching, combine, sums),
        }
    }
}

/// Sums up all summands.
#[inline(always)]
fn add<S: Simd>(from: &Around<'_>, touching: Touching, sums: &mut [Wide]) {
    sums.fill(Wide::default());
    let mut ahead = touching;
    (&mut ahead).take(AHEAD).for_each(|q| from.announce(q));
    for q in touching {
        if let Some(q) = ahead.next() {
            from.announce(q);
        }
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
fn merge(from: &Around<'_>, touching: Touching, combine: Combine, sums: &mut [Wide]) {
    reduction::clear(combine, sums);
    for q in touching {
        let Some((partial, pencils)) = from.partial(q) else { continue };
        for (own, there) in pencils {
            let (own, there) = (lines(own, from.width), lines(there, from.width));
            reduction::merge(combine, &mut sums[own], &partial[there]);
        }
    }
}
