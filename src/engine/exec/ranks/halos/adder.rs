//! Particle blocks that add to nodes of another rank.
use super::message::{Header, width};
use crate::data::nodes::NOWHERE;
use crate::data::particles::ParticleBlock;
use crate::data::warehouse::{ParticlePatch, Warehouse};
use crate::exec::halo::{back, lines, overlap, pencils};
use crate::exec::stage::Context;
use crate::graph::exchange::Exchange;
use simd::Wide;
use std::ops::Range;

/// A particle block that adds to nodes of another rank.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Adder {
    pub material: usize,
    /// Patch and position.
    pub place: (usize, usize),
    /// The node blocks that it adds to, one bit for each of the 27 around it.
    pub towards: u32,
}

/// The blocks of some patches that have node blocks of some patches around them, patch by patch and material by material.
pub fn adders(warehouse: &Warehouse, from: impl Fn(usize) -> bool, to: impl Fn(usize) -> bool) -> Vec<Adder> {
    let mut adders = Vec::new();
    for (patch, homes) in warehouse.particles.iter().enumerate().filter(|(patch, _)| from(*patch)) {
        for (material, home) in homes.iter().enumerate() {
            for (at, block) in home.blocks.iter().enumerate() {
                let theirs = |q: &usize| block.around[*q] != NOWHERE && to(block.around[*q].0 as usize);
                let towards = (0..27).filter(theirs).fold(0, |bits, q| bits | 1 << q);
                if towards != 0 {
                    adders.push(Adder { material, place: (patch, at), towards });
                }
            }
        }
    }
    adders
}

impl Adder {
    pub fn block<'a>(&self, particles: &'a [Vec<ParticlePatch>]) -> &'a ParticleBlock {
        &particles[self.place.0][self.material].blocks[self.place.1]
    }

    pub fn towards(&self) -> impl Iterator<Item = usize> + use<> {
        let bits = self.towards;
        (0..27).filter(move |q| bits >> q & 1 == 1)
    }

    /// Lines of a message, at most: no node is in two blocks.
    pub fn most(&self, exchange: &Exchange, context: &Context<'_>) -> usize {
        let nodes = context.shape.node_count() * self.towards.count_ones() as usize;
        1 + width(exchange, context, self.material) * context.shape.buffer_len().min(nodes)
    }

    /// Lines that follow the first one.
    pub fn lines(&self, exchange: &Exchange, context: &Context<'_>, header: &Header) -> usize {
        let nodes = |q| overlap(context.shape, back(q), &header.touched).map_or(0, |(nodes, _)| nodes.len());
        let there = exchange.labels.iter().enumerate().filter(|(at, _)| header.has(*at));
        let width = there.map(|(_, label)| label.width()).sum::<usize>();
        width * context.fields.of(self.material).len() * self.towards().map(nodes).sum::<usize>()
    }

    /// Lines of the block in a message.
    pub fn size(
        &self,
        exchange: &Exchange,
        context: &Context<'_>,
        particles: &[Vec<ParticlePatch>],
    ) -> usize {
        1 + self.lines(
            exchange,
            context,
            &Header::of(self.block(particles), self.material, exchange, context),
        )
    }

    /// Runs `each(place of the label, lines of its buffers, width)` on all pencils that the block adds to, of the labels
    /// that `header` has.
    pub fn pencils(
        &self,
        exchange: &Exchange,
        context: &Context<'_>,
        header: &Header,
        mut each: impl FnMut(usize, Range<usize>),
    ) {
        for (_, &label) in exchange.labels.iter().enumerate().filter(|(at, _)| header.has(*at)) {
            let Some(place) = context.node_layout.partial_place(label) else { continue };
            let length = context.node_layout.buffer * label.width();
            for field in 0..context.fields.of(self.material).len() {
                for q in self.towards() {
                    for (_, there) in pencils(context.shape, back(q), &header.touched) {
                        let there = lines(there, label.width());
                        each(place, field * length + there.start..field * length + there.end);
                    }
                }
            }
        }
    }

    /// Fills the block's part of a message.
    pub fn pack(
        &self,
        exchange: &Exchange,
        context: &Context<'_>,
        particles: &[Vec<ParticlePatch>],
        message: &mut [Wide],
    ) {
        let block = self.block(particles);
        let header = Header::of(block, self.material, exchange, context);
        message[0] = header.write();
        let mut at = 1;
        self.pencils(exchange, context, &header, |place, lines| {
            let count = lines.len();
            message[at..at + count].copy_from_slice(&block.partials[place][lines]);
            at += count;
        });
    }

    /// Puts the block's part of a message in its place.
    pub fn unpack(
        &self,
        exchange: &Exchange,
        context: &Context<'_>,
        block: &mut ParticleBlock,
        header: &Header,
        message: &[Wide],
    ) {
        block.touched = header.touched;
        let fields = context.fields.of(self.material).len();
        for (at, &label) in exchange.labels.iter().enumerate() {
            let Some(place) = context.node_layout.partial_place(label) else { continue };
            let partial = &mut block.partials[place];
            match header.has(at) {
                true if partial.is_empty() => {
                    *partial = context.buffers.take(context.node_layout.buffer * label.width() * fields);
                }
                true => {}
                false => context.buffers.put_back(std::mem::take(partial)),
            }
        }
        let mut at = 0;
        self.pencils(exchange, context, header, |place, lines| {
            let count = lines.len();
            block.partials[place][lines].copy_from_slice(&message[at..at + count]);
            at += count;
        });
    }
}
