//! Moves particles that drifted out of reach of their block to the block, the patch and the rank where they are now.
use super::backend::Backend;
use super::moves::{Departure, Move};
use super::order::{END, Op};
use super::ranks::occupied::Neighbor;
use super::ranks::reduction::{self, Counters};
use super::ranks::{Channel, Network, NetworkError, collective, pack, unpack};
use super::recorder::Recorder;
use super::trace::{Event, Kind};
use super::traveler::Traveler;
use crate::data::shared::Shared;
use crate::data::spread::each_of;
use crate::data::warehouse::{MaterialData, Warehouse};
use crate::graph::build::TaskGraph;
use simd::{Isa, Wide};
use std::collections::BTreeMap;

/// What becomes of particles outside of the level: whether one is put back into it (at its position then), and what that
/// contributes to shared labels.
pub type Leaving<'a> = dyn FnMut(&mut Traveler, &[MaterialData], &mut Shared) -> bool + 'a;

/// How particles come to other ranks.
pub struct Transit<'a> {
    /// The ranks.
    pub network: &'a mut dyn Network,
    /// Those in sight.
    pub neighbors: &'a [Neighbor],
    /// What has run: labels that it leaves to its end are reduced over all ranks on the way.
    pub graph: &'a TaskGraph,
    /// What becomes of particles outside of the level.
    pub leaving: &'a mut Leaving<'a>,
    /// Whether this rank wants all of them to stop.
    pub stop: bool,
    /// What is done when.
    pub trace: &'a Recorder,
}

/// Particles that are about to move: they stay in their blocks until [`Relocation::carry_out`].
#[derive(Debug, Default)]
pub struct Relocation {
    /// Patch, material and position of blocks, and who leaves them.
    leaving: Vec<([usize; 3], Vec<usize>)>,
    arriving: Vec<Traveler>,
    left: Vec<Traveler>,
    /// Travelers to ranks out of sight.
    far: Vec<u64>,
    /// Whether a block somewhere becomes occupied; or is left by all, where nodes keep something around it.
    news: bool,
    /// Whether any rank wants all of them to stop.
    pub stopped: bool,
    /// Particles here, of the materials that moved.
    pub particles: u64,
    /// Particles that came back into the level, on all ranks.
    pub reflected: u64,
}

/// Indices of [`Counters`]. Ranks that have news are counted in units of one, those that want to stop in units of `STOP`.
const NEWS: usize = 0;
const STOP: u64 = 1 << 32;
const FAR: usize = 1;
const SENT: usize = 2;
const SENT_WHO: usize = 3;
const CAME: usize = 4;
const CAME_WHO: usize = 5;
const LEFT: usize = 6;
const REFLECTED: usize = 7;

impl Relocation {
    /// Finds the particles of the materials that `moved` and need to move, and brings those to the ranks where they belong;
    /// on the way, labels are reduced over all ranks.
    ///
    /// Looks only at blocks of which a worker has seen, in their extent, that somebody left. Whether a particle moves depends
    /// on the particle alone, and arrivals are ordered by where they come from: no decomposition shows.
    ///
    /// # Errors
    /// If a rank is gone, or a particle was lost on the way.
    pub fn prepare(
        warehouse: &mut Warehouse,
        (backend, isa): (&dyn Backend, Isa),
        way: &mut Transit<'_>,
        moved: impl Fn(usize) -> bool,
    ) -> Result<Self, NetworkError> {
        let began = way.trace.now();
        let (mut relocation, mut travelers, gone) = Self::depart(warehouse, (backend, isa), &moved);
        for mut traveler in gone {
            let Warehouse { materials, shared, .. } = &mut *warehouse;
            let back = (way.leaving)(&mut traveler, materials, shared)
                && warehouse.home(traveler.material, traveler.position).is_ok();
            relocation.reflected += u64::from(back);
            if back { travelers.push(traveler) } else { relocation.left.push(traveler) }
        }
        way.trace.record(0, began, Event::other(Kind::Relocate));
        if way.network.size() == 1 {
            relocation.arriving = travelers;
            relocation.stopped = way.stop;
        } else {
            let mut counters = Counters::default();
            counters[NEWS] = if way.stop { STOP } else { 0 };
            for op in END {
                match op {
                    Op::SendTravelers => {
                        relocation.send(warehouse, way, std::mem::take(&mut travelers), &mut counters);
                    }
                    Op::ReceiveTravelers => relocation.receive(warehouse, way, &mut counters)?,
                    _ => {
                        let began = way.trace.now();
                        let shared = &mut warehouse.shared;
                        let contributes = |label, material| way.graph.contributes(None, label, material);
                        reduction::reduce(
                            way.network,
                            &way.graph.at_end,
                            &moved,
                            contributes,
                            shared,
                            &mut counters,
                        )?;
                        way.trace.record(0, began, Event::reduction(None));
                    }
                }
            }
            relocation.conclude(warehouse, way.network, counters)?;
        }
        relocation.arriving.sort_by_key(|t| (t.material, t.from));
        relocation.left.sort_by_key(|left| left.identity);
        Ok(relocation)
    }

    /// Those that leave their blocks here for others, and for nowhere.
    fn depart(
        warehouse: &Warehouse,
        (backend, isa): (&dyn Backend, Isa),
        moved: &impl Fn(usize) -> bool,
    ) -> (Self, Vec<Traveler>, Vec<Traveler>) {
        let (mut relocation, mut left) = (Self::default(), Vec::new());
        // where materials wait, nodes catch up in other sums than those that go along
        let keeps = warehouse.nodes_keep();
        for patch in warehouse.partition.mine() {
            let homes = warehouse.particles[patch].iter().enumerate();
            for (material, home) in homes.filter(|(material, _)| moved(*material)) {
                relocation.particles += home.blocks.iter().map(|block| block.count as u64).sum::<u64>();
                let blocks = home.blocks.iter().enumerate();
                let blocks = blocks.filter(|(_, block)| block.leaving && block.count > 0);
                left.extend(blocks.map(|(at, block)| Departure::new([patch, material, at], block)));
            }
        }
        each_of(backend, &mut left, 1, |it| it.find(warehouse, isa));
        let (mut travelers, mut lost) = (Vec::new(), Vec::new());
        for Departure { place, block, positions, travelers: own, lost: gone } in left {
            relocation.news |= keeps && positions.len() == block.count;
            travelers.extend(own);
            lost.extend(gone);
            if !positions.is_empty() {
                relocation.leaving.push((place, positions));
            }
        }
        (relocation, travelers, lost)
    }

    /// Sends travelers to their ranks.
    fn send(
        &mut self,
        warehouse: &Warehouse,
        way: &mut Transit<'_>,
        travelers: Vec<Traveler>,
        counters: &mut Counters,
    ) {
        let Transit { network, neighbors, trace, .. } = way;
        let began = trace.now();
        let mut bags: Vec<Vec<u64>> = vec![Vec::new(); neighbors.len()];
        for traveler in travelers {
            let home = warehouse.home(traveler.material, traveler.position);
            let rank = home.map_or(network.rank(), |(_, patch)| warehouse.partition.rank_of(patch));
            if rank == network.rank() {
                self.arriving.push(traveler);
                continue;
            }
            counters[SENT] += 1;
            counters[SENT_WHO] = counters[SENT_WHO].wrapping_add(traveler.identity);
            let neighbor = neighbors.iter().position(|neighbor| neighbor.rank == rank);
            counters[FAR] += u64::from(neighbor.is_none());
            traveler.write(neighbor.map_or(&mut self.far, |neighbor| &mut bags[neighbor]));
        }
        let mut lines = 0;
        for (neighbor, bag) in neighbors.iter().zip(bags) {
            let message = pack(&bag);
            lines += message.len();
            network.send(neighbor.rank, Channel::Travelers, message);
        }
        let sent = Event::other(Kind::Relocate).sent(neighbors.len(), lines * size_of::<Wide>());
        trace.record(0, began, sent);
    }

    /// Takes in those that come here, and counts.
    fn receive(
        &mut self,
        warehouse: &Warehouse,
        way: &mut Transit<'_>,
        counters: &mut Counters,
    ) -> Result<(), NetworkError> {
        let Transit { network, neighbors, trace, .. } = way;
        let began = trace.now();
        let messages = neighbors.iter().map(|neighbor| network.receive(neighbor.rank, Channel::Travelers));
        let messages = messages.collect::<Result<Vec<_>, _>>()?;
        trace.record(0, began, Event::travelers());
        messages.iter().for_each(|message| self.take_in(warehouse, unpack(message), counters));
        let known = |t: &Traveler| warehouse.is_occupied(t.material, t.position);
        counters[NEWS] += u64::from(self.news || !self.arriving.iter().all(known));
        counters[LEFT] = self.left.len() as u64;
        counters[REFLECTED] = self.reflected;
        Ok(())
    }

    /// What follows from the sums over all ranks: those that fly over a whole rank, and who left the level.
    fn conclude(
        &mut self,
        warehouse: &Warehouse,
        network: &mut dyn Network,
        mut counters: Counters,
    ) -> Result<(), NetworkError> {
        if counters[FAR] > 0 {
            let mut found = Counters::default();
            for list in collective::share(network, &self.far)? {
                self.take_in(warehouse, &list, &mut found);
            }
            collective::sum(network, &mut found)?;
            (CAME..=CAME_WHO).for_each(|i| counters[i] = counters[i].wrapping_add(found[i]));
        }
        if counters[LEFT] > 0 {
            self.share_left(warehouse, network)?;
        }
        self.reflected = counters[REFLECTED];
        self.stopped = counters[NEWS] >= STOP;
        self.news = counters[NEWS] & (STOP - 1) > 0 || counters[FAR] > 0;
        if counters[SENT] != counters[CAME] || counters[SENT_WHO] != counters[CAME_WHO] {
            return Err(NetworkError::Particles { sent: counters[SENT], came: counters[CAME] });
        }
        Ok(())
    }

    /// Takes in those of a list that belong here.
    fn take_in(&mut self, warehouse: &Warehouse, mut words: &[u64], counters: &mut Counters) {
        while let Some(traveler) = Traveler::read(&mut words, &warehouse.materials) {
            let home = warehouse.home(traveler.material, traveler.position);
            if home.is_ok_and(|(_, patch)| warehouse.partition.is_mine(patch)) {
                counters[CAME] += 1;
                counters[CAME_WHO] = counters[CAME_WHO].wrapping_add(traveler.identity);
                self.arriving.push(traveler);
            }
        }
    }

    /// Tells all ranks who left the level.
    fn share_left(&mut self, warehouse: &Warehouse, network: &mut dyn Network) -> Result<(), NetworkError> {
        let mut words = Vec::new();
        self.left.iter().for_each(|left| left.write(&mut words));
        self.left.clear();
        for list in collective::share(network, &words)? {
            let mut words = &list[..];
            self.left.extend(std::iter::from_fn(|| Traveler::read(&mut words, &warehouse.materials)));
        }
        Ok(())
    }

    /// Those outside the level, on any rank, by identity.
    pub fn left(&self) -> &[Traveler] {
        &self.left
    }

    /// Takes particles out of the blocks that they leave, and puts those that arrive in theirs.
    pub fn carry_out(self, warehouse: &mut Warehouse, backend: &dyn Backend) {
        let places = self.arriving.iter().map(|t| warehouse.make_room(t.material, t.position));
        // who is not in the level has left it
        let arriving =
            places.collect::<Vec<_>>().into_iter().zip(&self.arriving).filter_map(|(place, traveler)| {
                debug_assert!(place.is_ok());
                Some((place.ok()?, traveler))
            });
        let mut changes: BTreeMap<[usize; 3], (&[usize], Vec<&Traveler>)> = BTreeMap::new();
        self.leaving.iter().for_each(|(place, positions)| changes.entry(*place).or_default().0 = positions);
        arriving.for_each(|(place, traveler)| changes.entry(place).or_default().1.push(traveler));
        let Warehouse { level, materials, particles, .. } = &mut *warehouse;
        let blocks = particles.iter_mut().enumerate().flat_map(|(patch, homes)| {
            homes.iter_mut().enumerate().flat_map(move |(material, home)| {
                home.blocks.iter_mut().enumerate().map(move |(at, block)| ([patch, material, at], block))
            })
        });
        let (mut changes, mut moves) = (changes.into_iter().peekable(), Vec::new());
        for (place, block) in blocks {
            let Some((_, (leaving, arriving))) = changes.next_if(|(wanted, _)| *wanted == place) else {
                continue;
            };
            moves.push(Move { level, data: &materials[place[1]], block, leaving, arriving });
        }
        each_of(backend, &mut moves, 1, Move::carry_out);
        warehouse.reactivate |= self.news;
    }
}
