//! What a rank's blocks add to nodes of other ranks, and the values of nodes that come back.
//!
//! Both sides derive the same lists from where occupied blocks are, so that messages carry numbers alone: for each particle
//! block a line that says which nodes it touches, then its partial sums there; for each node block the nodes that are read.
//! The receiver keeps them in blocks without particles, in the place of the sender's: node sums are then taken over all
//! blocks around in the same order on any number of ranks.
mod adder;
mod message;
mod read;

use super::occupied::Neighbor;
use super::{Channel, Network, NetworkError};
use crate::data::brief::Brief;
use crate::data::particles::ParticleBlock;
use crate::data::warehouse::{NodePatch, ParticlePatch, Warehouse};
use crate::exec::stage::Context;
use crate::exec::work::travels;
use crate::graph::exchange::{Exchange, Way};
use adder::{Adder, adders};
use message::{Header, Reader, columns, width};
use read::{NodesRead, read, rows};
use simd::Wide;

/// What passes between this rank and another.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Halo {
    rank: usize,
    /// Blocks here that add to nodes there, and the nodes there that they read.
    adders_here: Vec<Adder>,
    read_there: Vec<NodesRead>,
    /// Blocks there that add to nodes here, and the nodes here that they read.
    adders_there: Vec<Adder>,
    read_here: Vec<NodesRead>,
}

/// The neighbors of a rank.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Halos(Vec<Halo>);

/// The partial sums of a block on their way into a message.
pub struct Outgoing<'a> {
    adder: &'a Adder,
    exchange: &'a Exchange,
    context: &'a Context<'a>,
    particles: &'a [Vec<ParticlePatch>],
    piece: &'a mut [Wide],
}

impl Outgoing<'_> {
    /// Fills the block's piece of the message.
    pub fn pack(&mut self) {
        self.adder.pack(self.exchange, self.context, self.particles, self.piece);
    }
}

/// The partial sums of a block of another rank on their way from a message into its place here.
pub struct Incoming<'a> {
    adder: &'a Adder,
    exchange: &'a Exchange,
    context: &'a Context<'a>,
    block: &'a mut ParticleBlock,
    brief: &'a mut Brief,
    header: Header,
    piece: &'a [Wide],
}

impl Incoming<'_> {
    /// Fills the block.
    pub fn unpack(&mut self) {
        self.adder.unpack(self.exchange, self.context, self.block, &self.header, self.piece);
        *self.brief = Brief::of(self.block, self.context.shape);
    }
}

/// Where a message goes or comes from, and what it is about.
type To<'a, 'n> = (&'a mut (dyn Network + 'n), Channel);
type From<'a> = (usize, Channel, &'a [Wide]);

impl Halos {
    /// What passes between this rank and its neighbors, for the blocks that are active now.
    pub fn new(warehouse: &Warehouse, neighbors: &[Neighbor]) -> Self {
        let partition = &warehouse.partition;
        let halo = |neighbor: &Neighbor| {
            let rank = neighbor.rank;
            let (mine, theirs) = (|patch| partition.is_mine(patch), |patch| partition.rank_of(patch) == rank);
            let (adders_here, adders_there) =
                (adders(warehouse, mine, theirs), adders(warehouse, theirs, mine));
            let (read_there, read_here) = (read(warehouse, &adders_here), read(warehouse, &adders_there));
            Halo { rank, adders_here, read_there, adders_there, read_here }
        };
        let some = |it: &Halo| !it.adders_here.is_empty() || !it.adders_there.is_empty();
        Self(neighbors.iter().map(halo).filter(some).collect())
    }

    /// The ranks that send something in this tick, and how many lines at most.
    pub fn senders(
        &self,
        exchange: &Exchange,
        context: &Context<'_>,
    ) -> impl Iterator<Item = (usize, usize)> {
        let travels = |material| travels(exchange, context.schedule, material);
        let most = move |it: &Halo| -> usize {
            match exchange.way {
                Way::Partials => {
                    let adders = it.adders_there.iter().filter(|adder| travels(adder.material));
                    adders.map(|adder| adder.most(exchange, context)).sum()
                }
                Way::Values => {
                    let read = it.read_there.iter().filter(|read| travels(read.material));
                    read.map(|read| context.shape.node_count() * width(exchange, context, read.material))
                        .sum()
                }
            }
        };
        self.0.iter().map(move |it| (it.rank, most(it))).filter(|(_, most)| *most > 0)
    }

    /// Sends what the materials that begin a step have added to nodes of others, packed by all workers; returns messages
    /// and lines.
    pub fn send_partials(
        &self,
        (network, channel): To<'_, '_>,
        exchange: &Exchange,
        context: &Context<'_>,
        particles: &[Vec<ParticlePatch>],
        pack: impl Fn(&mut [Outgoing<'_>]),
    ) -> [usize; 2] {
        let mut sent = [0; 2];
        for halo in &self.0 {
            let begins = |adder: &&Adder| travels(exchange, context.schedule, adder.material);
            let adders = halo.adders_here.iter().filter(begins);
            let sizes: Vec<(&Adder, usize)> =
                adders.map(|adder| (adder, adder.size(exchange, context, particles))).collect();
            if sizes.is_empty() {
                continue;
            }
            let mut message = network.message(sizes.iter().map(|(_, lines)| lines).sum());
            let mut rest = &mut message[..];
            let piece = |(adder, lines)| {
                let (piece, after) = std::mem::take(&mut rest).split_at_mut(lines);
                rest = after;
                Outgoing { adder, exchange, context, particles, piece }
            };
            let mut pieces: Vec<Outgoing<'_>> = sizes.into_iter().map(piece).collect();
            pack(&mut pieces);
            sent = [sent[0] + 1, sent[1] + message.len()];
            network.send(halo.rank, channel, message);
        }
        sent
    }

    /// Puts the partial sums of another rank in their place, by all workers.
    ///
    /// # Errors
    /// A message of another length than the blocks say.
    pub fn unpack_partials(
        &self,
        (rank, channel, message): From<'_>,
        exchange: &Exchange,
        context: &Context<'_>,
        (particles, unpack): (&mut [Vec<ParticlePatch>], impl Fn(&mut [Incoming<'_>])),
    ) -> Result<(), NetworkError> {
        let mut reader = Reader { message, at: 0 };
        let halo = self.0.iter().find(|it| it.rank == rank);
        let adders = halo.map_or(&[][..], |it| &it.adders_there);
        let begins = |adder: &&Adder| travels(exchange, context.schedule, adder.material);
        let mut adders = adders.iter().filter(begins).peekable();
        let mut pieces = Vec::new();
        for (patch, homes) in particles.iter_mut().enumerate() {
            if adders.peek().is_none_or(|adder| adder.place.0 != patch) {
                continue;
            }
            for (material, home) in homes.iter_mut().enumerate() {
                for (at, (block, brief)) in home.blocks.iter_mut().zip(&mut home.briefs).enumerate() {
                    let this = |adder: &&Adder| (adder.place, adder.material) == ((patch, at), material);
                    if let Some(adder) = adders.next_if(this) {
                        let header = Header::read(reader.next(1));
                        let length = adder.lines(exchange, context, &header);
                        let piece = reader.next(length);
                        pieces.push(Incoming { adder, exchange, context, block, brief, header, piece });
                    }
                }
            }
        }
        reader.finish(rank, channel)?;
        unpack(&mut pieces);
        Ok(())
    }

    /// Sends the values of nodes that particles of others read, of the materials whose step ends; returns messages and
    /// lines.
    pub fn send_values(
        &self,
        (network, channel): To<'_, '_>,
        exchange: &Exchange,
        context: &Context<'_>,
        (particles, nodes): (&[Vec<ParticlePatch>], &[NodePatch]),
    ) -> [usize; 2] {
        let mut sent = [0; 2];
        for halo in &self.0 {
            let ends = |read: &&NodesRead| travels(exchange, context.schedule, read.material);
            let most = halo.read_here.iter().filter(ends);
            let most =
                most.map(|it| context.shape.node_count() * width(exchange, context, it.material)).sum();
            if most == 0 {
                continue;
            }
            let mut message = network.memory(most);
            for read in halo.read_here.iter().filter(ends) {
                let block = &nodes[read.place.0].blocks[read.place.1];
                let nodes = read.nodes(context.shape, &halo.adders_there, particles, exchange.whole);
                for (label, field) in columns(exchange, context, read.material) {
                    let values = block.lines(context.node_layout, label, field).unwrap_or_default();
                    rows(context.shape, &nodes, label.width())
                        .filter_map(|row| values.get(row))
                        .for_each(|row| message.extend_from_slice(row));
                }
            }
            sent = [sent[0] + 1, sent[1] + message.len()];
            network.send(halo.rank, channel, message);
        }
        sent
    }

    /// Puts the values of nodes of another rank in their place.
    ///
    /// # Errors
    /// A message of another length than the blocks say.
    pub fn unpack_values(
        &self,
        (rank, channel, message): From<'_>,
        exchange: &Exchange,
        context: &Context<'_>,
        (particles, nodes): (&[Vec<ParticlePatch>], &mut [NodePatch]),
    ) -> Result<(), NetworkError> {
        let mut reader = Reader { message, at: 0 };
        for halo in self.0.iter().filter(|it| it.rank == rank) {
            let ends = |read: &&NodesRead| travels(exchange, context.schedule, read.material);
            for read in halo.read_there.iter().filter(ends) {
                let touched = read.nodes(context.shape, &halo.adders_here, particles, exchange.whole);
                let block = &mut nodes[read.place.0].blocks[read.place.1];
                for (label, field) in columns(exchange, context, read.material) {
                    let values = block.lines_mut(context.node_layout, label, field).unwrap_or_default();
                    for row in rows(context.shape, &touched, label.width()) {
                        if let Some(into) = values.get_mut(row) {
                            into.copy_from_slice(reader.next(into.len()));
                        }
                    }
                }
            }
        }
        reader.finish(rank, channel)
    }
}
