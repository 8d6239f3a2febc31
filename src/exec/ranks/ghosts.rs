//! What a rank's blocks give to nodes of other ranks, and the motion of nodes that comes back.
//!
//! Both sides derive the same lists from where occupied blocks are, so that messages carry numbers alone: for each particle
//! block a line that says which nodes it touches, then its partial sums there; for each node block the nodes that are read.
//! The receiver keeps them in blocks without particles, in the place of the sender's: node sums are then taken over all
//! blocks around in the same order on any number of ranks.
use super::occupied::Beside;
use super::{Channel, Network, NetworkError};
use crate::data::nodes::{NODES, NOWHERE};
use crate::data::particles::ParticleBlock;
use crate::data::schedule::Schedule;
use crate::data::warehouse::{NodePatch, ParticlePatch, Warehouse};
use crate::exec::Executor;
use crate::exec::buffers::Buffers;
use crate::exec::halo::{back, overlap, pencils};
use crate::grid::IndexBox;
use crate::physics::shape::BUFFER;
use crate::simd::Wide;
use std::ops::Range;

/// A particle block that gives to nodes of another rank.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Giver {
    material: usize,
    /// Patch and position.
    place: (usize, usize),
    /// The node blocks that it gives to, one bit for each of the 27 around it.
    towards: u32,
}

/// A node block that particles of another rank read.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Shown {
    material: usize,
    /// Patch and position.
    place: (usize, usize),
    /// Who reads: a [`Giver`], and where the node block is among those around it.
    readers: Vec<(usize, usize)>,
}

/// What passes between this rank and another.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Border {
    rank: usize,
    /// Blocks here that give to nodes there, and the nodes there that they read.
    give: Vec<Giver>,
    seen: Vec<Shown>,
    /// Blocks there that give to nodes here, and the nodes here that they read.
    take: Vec<Giver>,
    shown: Vec<Shown>,
}

/// The borders of a rank.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Ghosts {
    borders: Vec<Border>,
}

impl Ghosts {
    /// The borders with the ranks `beside`, for the blocks that are active now.
    pub fn new(warehouse: &Warehouse, beside: &[Beside]) -> Self {
        let partition = &warehouse.partition;
        let borders = beside.iter().map(|beside| {
            let rank = beside.rank;
            let give =
                givers(warehouse, |patch| partition.is_mine(patch), |node| partition.rank_of(node) == rank);
            let take =
                givers(warehouse, |patch| partition.rank_of(patch) == rank, |node| partition.is_mine(node));
            let (seen, shown) = (shown(warehouse, &give), shown(warehouse, &take));
            Border { rank, give, seen, take, shown }
        });
        Self {
            borders: borders.filter(|border| !border.give.is_empty() || !border.take.is_empty()).collect(),
        }
    }

    /// Sends what the materials that begin a step have given to nodes of others, packed by all workers; returns messages
    /// and lines.
    pub fn give<E: Executor>(
        &self,
        network: &mut dyn Network,
        schedule: &Schedule,
        particles: &[Vec<ParticlePatch>],
        executor: &E,
    ) -> [usize; 2] {
        let mut sent = [0; 2];
        for border in &self.borders {
            let givers = border.give.iter().filter(|giver| schedule.begins(giver.material));
            let sizes: Vec<(&Giver, usize)> = givers.map(|giver| (giver, giver.size(particles))).collect();
            if sizes.is_empty() {
                continue;
            }
            let mut message = network.message(sizes.iter().map(|(_, lines)| lines).sum());
            let mut rest = &mut message[..];
            let piece = |(giver, lines)| {
                let (piece, after) = std::mem::take(&mut rest).split_at_mut(lines);
                rest = after;
                (giver, piece)
            };
            let mut pieces: Vec<(&Giver, &mut [Wide])> = sizes.into_iter().map(piece).collect();
            executor.each(&mut pieces, |_, (giver, piece)| giver.pack(particles, piece));
            sent = [sent[0] + 1, sent[1] + message.len()];
            network.send(border.rank, Channel::Sums, message);
        }
        sent
    }

    /// The ranks that send sums in this tick, and how many lines at most.
    pub fn givers(&self, schedule: &Schedule) -> impl Iterator<Item = (usize, usize)> {
        let begins = |giver: &&Giver| schedule.begins(giver.material);
        let most = move |border: &Border| border.take.iter().filter(begins).map(Giver::most).sum();
        self.borders.iter().map(move |border| (border.rank, most(border))).filter(|(_, most)| *most > 0)
    }

    /// The ranks that send motion in this tick, and how many lines at most.
    pub fn showers(&self, schedule: &Schedule) -> impl Iterator<Item = (usize, usize)> {
        let ends = |shown: &&Shown| schedule.ends(shown.material);
        let most = move |border: &Border| NODES * border.seen.iter().filter(ends).count();
        self.borders.iter().map(move |border| (border.rank, most(border))).filter(|(_, most)| *most > 0)
    }

    /// Puts the sums of another rank in their place, by all workers.
    ///
    /// # Errors
    /// A message of another length than the blocks say.
    pub fn take<E: Executor>(
        &self,
        (rank, message): (usize, &[Wide]),
        schedule: &Schedule,
        particles: &mut [Vec<ParticlePatch>],
        (executor, buffers): (&E, &Buffers),
    ) -> Result<(), NetworkError> {
        let mut reader = Reader { message, at: 0 };
        let border = self.borders.iter().find(|border| border.rank == rank);
        let takers = border.map_or(&[][..], |border| &border.take);
        let mut takers = takers.iter().filter(|taker| schedule.begins(taker.material)).peekable();
        let mut pieces = Vec::new();
        for (patch, homes) in particles.iter_mut().enumerate() {
            if takers.peek().is_none_or(|taker| taker.place.0 != patch) {
                continue;
            }
            for (material, home) in homes.iter_mut().enumerate() {
                for (at, block) in home.blocks.iter_mut().enumerate() {
                    let this = |taker: &&Giver| (taker.place, taker.material) == ((patch, at), material);
                    if let Some(taker) = takers.next_if(this) {
                        let (touched, there) = read_header(reader.next(1));
                        let lines = taker.lines(&touched, there.into_iter().filter(|there| *there).count());
                        pieces.push((taker, block, (touched, there), reader.next(lines)));
                    }
                }
            }
        }
        reader.finish(rank, Channel::Sums)?;
        executor.each(&mut pieces, |_, (taker, block, header, lines)| {
            taker.unpack(block, *header, lines, buffers);
        });
        Ok(())
    }

    /// Sends the motion of nodes that particles of others read, of the materials whose step ends; returns messages
    /// and lines.
    pub fn show(
        &self,
        network: &mut dyn Network,
        schedule: &Schedule,
        particles: &[Vec<ParticlePatch>],
        nodes: &[NodePatch],
    ) -> [usize; 2] {
        let mut sent = [0; 2];
        for border in &self.borders {
            let ends = |shown: &&Shown| schedule.ends(shown.material);
            let count = border.shown.iter().filter(ends).count();
            if count > 0 {
                let mut message = network.memory(NODES * count);
                for shown in border.shown.iter().filter(ends) {
                    let (patch, at) = shown.place;
                    let Some(motion) = nodes[patch].blocks[at].motion_of(shown.material) else { continue };
                    let read = shown.read(&border.take, particles);
                    rows(&read).for_each(|row| message.extend_from_slice(&motion[row]));
                }
                sent = [sent[0] + 1, sent[1] + message.len()];
                network.send(border.rank, Channel::Motion, message);
            }
        }
        sent
    }

    /// Puts the motion of nodes of another rank in its place.
    ///
    /// # Errors
    /// A message of another length than the blocks say.
    pub fn see(
        &self,
        (rank, message): (usize, &[Wide]),
        schedule: &Schedule,
        particles: &[Vec<ParticlePatch>],
        nodes: &mut [NodePatch],
    ) -> Result<(), NetworkError> {
        let mut reader = Reader { message, at: 0 };
        for border in self.borders.iter().filter(|border| border.rank == rank) {
            for shown in border.seen.iter().filter(|shown| schedule.ends(shown.material)) {
                let (patch, at) = shown.place;
                let read = shown.read(&border.give, particles);
                let Some(motion) = nodes[patch].blocks[at].motion_of_mut(shown.material) else { continue };
                rows(&read).for_each(|row| motion[row.clone()].copy_from_slice(reader.next(row.len())));
            }
        }
        reader.finish(rank, Channel::Motion)
    }
}

/// The blocks of some patches that have node blocks of some patches around them, patch by patch and material by material.
fn givers(warehouse: &Warehouse, from: impl Fn(usize) -> bool, to: impl Fn(usize) -> bool) -> Vec<Giver> {
    let mut givers = Vec::new();
    for (patch, homes) in warehouse.particles.iter().enumerate().filter(|(patch, _)| from(*patch)) {
        for (material, home) in homes.iter().enumerate() {
            for (at, block) in home.blocks.iter().enumerate() {
                let theirs = |q: &usize| block.around[*q] != NOWHERE && to(block.around[*q].0 as usize);
                let towards = (0..27).filter(theirs).fold(0, |bits, q| bits | 1 << q);
                if towards != 0 {
                    givers.push(Giver { material, place: (patch, at), towards });
                }
            }
        }
    }
    givers
}

/// The node blocks that `givers` give to, and read in turn; in an order that both sides know.
fn shown(warehouse: &Warehouse, givers: &[Giver]) -> Vec<Shown> {
    let mut read: Vec<(usize, (u32, u32), usize, usize)> = Vec::new();
    for (reader, giver) in givers.iter().enumerate() {
        let block = giver.block(&warehouse.particles);
        read.extend(giver.towards().map(|q| (giver.material, block.around[q], reader, q)));
    }
    read.sort_unstable();
    let same_nodes = |a: &(usize, (u32, u32), _, _), b: &(usize, (u32, u32), _, _)| (a.0, a.1) == (b.0, b.1);
    let shown = read.chunk_by(same_nodes).map(|readers| Shown {
        material: readers[0].0,
        place: (readers[0].1.0 as usize, readers[0].1.1 as usize),
        readers: readers.iter().map(|&(_, _, reader, q)| (reader, q)).collect(),
    });
    shown.collect()
}

impl Giver {
    fn block<'a>(&self, particles: &'a [Vec<ParticlePatch>]) -> &'a ParticleBlock {
        &particles[self.place.0][self.material].blocks[self.place.1]
    }

    fn towards(&self) -> impl Iterator<Item = usize> + use<> {
        let bits = self.towards;
        (0..27).filter(move |q| bits >> q & 1 == 1)
    }

    /// Lines of a message, at most: no node is in two blocks.
    fn most(&self) -> usize {
        1 + 2 * BUFFER.min(NODES * self.towards.count_ones() as usize)
    }

    /// Lines that a block with `partials` buffers sends, besides the first.
    fn lines(&self, touched: &IndexBox, partials: usize) -> usize {
        let nodes = |q| overlap(back(q), touched).map_or(0, |(nodes, _)| nodes.len());
        partials * self.towards().map(nodes).sum::<usize>()
    }

    /// Lines of the block in a message.
    fn size(&self, particles: &[Vec<ParticlePatch>]) -> usize {
        let block = self.block(particles);
        let partials = block.partials.iter().filter(|partial| !partial.is_empty()).count();
        1 + self.lines(&block.touched, partials)
    }

    /// Fills the block's part of a message.
    fn pack(&self, particles: &[Vec<ParticlePatch>], message: &mut [Wide]) {
        let block = self.block(particles);
        message[0] = header(block);
        let mut at = 1;
        for partial in block.partials.iter().filter(|partial| !partial.is_empty()) {
            for q in self.towards() {
                pencils(back(q), &block.touched, |_, lines| {
                    let count = lines.len();
                    message[at..at + count].copy_from_slice(&partial[lines]);
                    at += count;
                });
            }
        }
    }

    /// Puts the block's part of a message in its place.
    fn unpack(
        &self,
        block: &mut ParticleBlock,
        (touched, there): (IndexBox, [bool; 2]),
        message: &[Wide],
        buffers: &Buffers,
    ) {
        block.touched = touched;
        let mut at = 0;
        for (partial, there) in block.partials.iter_mut().zip(there) {
            match there {
                true if partial.is_empty() => *partial = buffers.take(),
                true => {}
                false => buffers.put_back(std::mem::take(partial)),
            }
            for q in self.towards().filter(|_| there) {
                pencils(back(q), &touched, |_, lines| {
                    let count = lines.len();
                    partial[lines].copy_from_slice(&message[at..at + count]);
                    at += count;
                });
            }
        }
    }
}

impl Shown {
    /// The nodes that are read (0 to 3 on each axis).
    fn read(&self, readers: &[Giver], particles: &[Vec<ParticlePatch>]) -> IndexBox {
        let touched = self
            .readers
            .iter()
            .filter_map(|&(reader, q)| Some(overlap(back(q), &readers[reader].block(particles).touched)?.0));
        let nothing = IndexBox { lower: [0; 3], upper: [0; 3] };
        touched.reduce(|a, b| a.around(&b)).unwrap_or(nothing)
    }
}

/// The lines of some nodes of a block, row by row along z.
fn rows(nodes: &IndexBox) -> impl Iterator<Item = Range<usize>> + use<> {
    let IndexBox { lower: [x0, y0, z0], upper: [x1, y1, z1] } = *nodes;
    (x0..x1).flat_map(move |x| {
        (y0..y1).map(move |y| {
            let first = (x * 4 + y) * 4;
            (first + z0) as usize..(first + z1) as usize
        })
    })
}

/// Which nodes a block touches, and which of its buffers exist.
fn header(block: &ParticleBlock) -> Wide {
    let there = block.partials.each_ref().map(|partial| u8::from(!partial.is_empty()));
    let [x0, y0, z0] = block.touched.lower.map(f64::from);
    let [x1, y1, z1] = block.touched.upper.map(f64::from);
    Wide([x0, y0, z0, x1, y1, z1, there[0].into(), there[1].into()])
}

fn read_header(line: &[Wide]) -> (IndexBox, [bool; 2]) {
    let [x0, y0, z0, x1, y1, z1, first, second] = line.first().map_or([0.0; 8], |line| line.0);
    let corner = |x: [f64; 3]| x.map(|i| i as i32);
    (IndexBox { lower: corner([x0, y0, z0]), upper: corner([x1, y1, z1]) }, [first == 1.0, second == 1.0])
}

/// Reads a message; remembers how much should have been there.
struct Reader<'a> {
    message: &'a [Wide],
    at: usize,
}

/// What a reader gives where a message is too short: the error comes at its end.
static BLANK: [Wide; 2 * BUFFER] = [Wide([0.0; 8]); 2 * BUFFER];

impl<'a> Reader<'a> {
    fn next(&mut self, lines: usize) -> &'a [Wide] {
        let at = self.at;
        self.at += lines;
        self.message.get(at..at + lines).unwrap_or(&BLANK[..lines])
    }

    fn finish(&self, rank: usize, channel: Channel) -> Result<(), NetworkError> {
        let (lines, expected) = (self.message.len(), self.at);
        if lines == expected { Ok(()) } else { Err(NetworkError::Length { rank, channel, lines, expected }) }
    }
}
