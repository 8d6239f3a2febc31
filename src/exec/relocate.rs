//! Moves particles that drifted out of reach of their block to the block, the patch and the rank where they are now.
use super::ranks::occupied::Beside;
use super::ranks::reduction::{self, Counters};
use super::ranks::{Channel, Network, NetworkError, collective, pack, unpack};
use super::trace::{Event, Kind, Recorder};
use super::traveler::{Left, Traveler};
use crate::data::extent::{MARGIN, bounds};
use crate::data::labels::LabelId;
use crate::data::particles::{Layout, ParticleBlock};
use crate::data::reduction::clear;
use crate::data::warehouse::{MaterialData, Warehouse};
use crate::grid::{BLOCK, BlockIndex, Level};
use crate::physics::shape::{BASES, BELOW};
use crate::simd::Wide;
use std::borrow::Cow;

/// How particles come to other ranks.
pub struct Way<'a> {
    /// The ranks.
    pub network: &'a mut dyn Network,
    /// Those in sight.
    pub beside: &'a [Beside],
    /// What is reduced over all ranks on the way.
    pub labels: &'a [LabelId],
    /// Whether particles outside the level are put back.
    pub reflect: bool,
    /// What is done when.
    pub trace: &'a Recorder,
}

/// Particles that are about to move: they stay in their blocks until [`Relocation::carry_out`].
#[derive(Debug, Default)]
pub struct Relocation {
    /// Patch, material and position of blocks, and who leaves them.
    leaving: Vec<([usize; 3], Vec<usize>)>,
    arriving: Vec<Traveler>,
    left: Vec<Left>,
    /// Travelers to ranks out of sight.
    far: Vec<u64>,
    /// Whether a block somewhere becomes occupied.
    news: bool,
    /// Particles here, of the materials that moved.
    pub particles: u64,
    /// Particles that came back into the level, on all ranks.
    pub reflected: u64,
}

/// Indices of [`Counters`].
const NEWS: usize = 0;
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
    /// Looks only at blocks whose extent (label `BlockExtent`) says that somebody left. Whether a particle moves
    /// depends on the particle alone, and arrivals are ordered by where they come from: no decomposition shows.
    ///
    /// # Errors
    /// If a rank is gone, or a particle was lost on the way.
    pub fn prepare(
        warehouse: &mut Warehouse,
        way: &mut Way<'_>,
        moved: impl Fn(usize) -> bool,
    ) -> Result<Self, NetworkError> {
        let began = way.trace.now();
        let mut labels = Cow::from(way.labels);
        if way.reflect && !labels.contains(&LabelId::BoundaryWork) {
            // nobody else uses it in this run
            clear(LabelId::BoundaryWork.reduce(), warehouse.shared.column_mut(LabelId::BoundaryWork));
            labels.to_mut().push(LabelId::BoundaryWork);
        }
        let (mut relocation, mut travelers, gone) = Self::depart(warehouse, &moved);
        for mut traveler in gone {
            let back = way.reflect && traveler.reflect(warehouse);
            relocation.reflected += u64::from(back);
            if back { travelers.push(traveler) } else { relocation.left.push(traveler.who) }
        }
        if way.network.size() == 1 {
            relocation.arriving = travelers;
            way.trace.record(0, began, Event::other(Kind::Relocate));
        } else {
            way.trace.record(0, began, Event::other(Kind::Relocate));
            let mut counters = relocation.travel(warehouse, way, travelers)?;
            let began = way.trace.now();
            reduction::reduce(way.network, &labels, moved, &mut warehouse.shared, &mut counters)?;
            way.trace.record(0, began, Event::reduction(None));
            relocation.conclude(warehouse, way.network, counters)?;
        }
        relocation.arriving.sort_by_key(|t| (t.who.material, t.from));
        relocation.left.sort_by_key(|left| left.identity);
        Ok(relocation)
    }

    /// Those that leave their blocks here for others, and for nowhere.
    fn depart(warehouse: &Warehouse, moved: &impl Fn(usize) -> bool) -> (Self, Vec<Traveler>, Vec<Traveler>) {
        let (mut relocation, mut travelers, mut lost) = (Self::default(), Vec::new(), Vec::new());
        let level = &warehouse.level;
        for patch in warehouse.partition.mine() {
            let homes = warehouse.particles[patch].iter().enumerate();
            for (material, home) in homes.filter(|(material, _)| moved(*material)) {
                let data = &warehouse.materials[material];
                relocation.particles += home.blocks.iter().map(|block| block.count as u64).sum::<u64>();
                for (at, block) in home.blocks.iter().enumerate() {
                    if somebody_left(level, data, block) {
                        let positions =
                            depart(level, data, (patch, material), block, &mut |traveler, gone| {
                                let homeless = || warehouse.home(material, traveler.who.position).is_err();
                                match gone || homeless() {
                                    true => lost.push(traveler),
                                    false => travelers.push(traveler),
                                }
                            });
                        if !positions.is_empty() {
                            relocation.leaving.push(([patch, material, at], positions));
                        }
                    }
                }
            }
        }
        (relocation, travelers, lost)
    }

    /// Sends travelers to their ranks, and takes in those that come here; returns what there is to count.
    fn travel(
        &mut self,
        warehouse: &Warehouse,
        way: &mut Way<'_>,
        travelers: Vec<Traveler>,
    ) -> Result<Counters, NetworkError> {
        let Way { network, beside, trace, .. } = way;
        let began = trace.now();
        let mut counters = Counters::default();
        let mut bags: Vec<Vec<u64>> = vec![Vec::new(); beside.len()];
        for traveler in travelers {
            let home = warehouse.home(traveler.who.material, traveler.who.position);
            let rank = home.map_or(network.rank(), |(_, patch)| warehouse.partition.rank_of(patch));
            if rank == network.rank() {
                self.arriving.push(traveler);
                continue;
            }
            counters[SENT] += 1;
            counters[SENT_WHO] = counters[SENT_WHO].wrapping_add(traveler.who.identity);
            let neighbor = beside.iter().position(|beside| beside.rank == rank);
            counters[FAR] += u64::from(neighbor.is_none());
            traveler.write(neighbor.map_or(&mut self.far, |neighbor| &mut bags[neighbor]));
        }
        let mut lines = 0;
        for (beside, bag) in beside.iter().zip(bags) {
            let message = pack(&bag);
            lines += message.len();
            network.send(beside.rank, Channel::Travelers, message);
        }
        let sent = Event::other(Kind::Relocate).sent(beside.len(), lines * size_of::<Wide>());
        trace.record(0, began, sent);
        let began = trace.now();
        let messages = beside.iter().map(|beside| network.receive(beside.rank, Channel::Travelers));
        let messages = messages.collect::<Result<Vec<_>, _>>()?;
        trace.record(0, began, Event::reduction(None));
        messages.iter().for_each(|message| self.welcome(warehouse, unpack(message), &mut counters));
        let known = |t: &Traveler| warehouse.is_occupied(t.who.material, t.who.position);
        counters[NEWS] = u64::from(!self.arriving.iter().all(known));
        counters[LEFT] = self.left.len() as u64;
        counters[REFLECTED] = self.reflected;
        Ok(counters)
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
                self.welcome(warehouse, &list, &mut found);
            }
            collective::sum(network, &mut found)?;
            (CAME..=CAME_WHO).for_each(|i| counters[i] = counters[i].wrapping_add(found[i]));
        }
        if counters[LEFT] > 0 {
            self.share_left(network)?;
        }
        self.reflected = counters[REFLECTED];
        self.news = counters[NEWS] > 0 || counters[FAR] > 0;
        if counters[SENT] != counters[CAME] || counters[SENT_WHO] != counters[CAME_WHO] {
            return Err(NetworkError::Particles { sent: counters[SENT], came: counters[CAME] });
        }
        Ok(())
    }

    /// Takes in those of a list that belong here.
    fn welcome(&mut self, warehouse: &Warehouse, mut words: &[u64], counters: &mut Counters) {
        while let Some(traveler) = Traveler::read(&mut words, &warehouse.materials) {
            let home = warehouse.home(traveler.who.material, traveler.who.position);
            if home.is_ok_and(|(_, patch)| warehouse.partition.is_mine(patch)) {
                counters[CAME] += 1;
                counters[CAME_WHO] = counters[CAME_WHO].wrapping_add(traveler.who.identity);
                self.arriving.push(traveler);
            }
        }
    }

    /// Tells all ranks who left the level.
    fn share_left(&mut self, network: &mut dyn Network) -> Result<(), NetworkError> {
        let mut words = Vec::new();
        self.left.iter().for_each(|left| left.write(&mut words));
        let lists = collective::share(network, &words)?;
        self.left =
            lists.iter().flat_map(|list| list.chunks_exact(Left::WORDS).filter_map(Left::read)).collect();
        Ok(())
    }

    /// Those outside the level, on any rank, by identity.
    pub fn left(&self) -> &[Left] {
        &self.left
    }

    /// Takes particles out of the blocks that they leave, and puts those that arrive in theirs.
    pub fn carry_out(self, warehouse: &mut Warehouse) {
        for ([patch, material, at], positions) in self.leaving {
            let block = &mut warehouse.particles[patch][material].blocks[at];
            let rest = warehouse.level.middle(block.index);
            block.remove(&warehouse.materials[material].layout, rest, &positions);
        }
        for Traveler { who, record, .. } in self.arriving {
            let inserted = warehouse.insert(who.material, who.position, &record);
            debug_assert!(inserted.is_ok(), "who is not in the level has left it");
        }
        warehouse.stale |= self.news;
    }
}

/// Whether the coordinate y (base node before rounding down) is out of reach of the block on some axis; particles
/// move a margin early.
fn out_of_reach(block: BlockIndex, axis: usize, y: f64) -> bool {
    let first = f64::from(BLOCK * block[axis] - BELOW);
    !(y >= first + MARGIN && y < first + f64::from(BASES) - MARGIN)
}

fn outside(level: &Level, data: &MaterialData, axis: usize, y: f64) -> bool {
    let half = data.half_size[axis];
    !(y >= -half && y <= level.cells[axis] as f64 - half)
}

fn somebody_left(level: &Level, data: &MaterialData, block: &ParticleBlock) -> bool {
    block.count > 0
        && (0..3).any(|axis| {
            let (least, most) = bounds(&block.extent, axis);
            [least, most].iter().any(|&y| {
                y.is_finite() && (out_of_reach(block.index, axis, y) || outside(level, data, axis, y))
            })
        })
}

/// Hands out who leaves a block, and whether they leave the level too; returns their positions in the block.
fn depart(
    level: &Level,
    data: &MaterialData,
    (patch, material): (usize, usize),
    block: &ParticleBlock,
    each: &mut impl FnMut(Traveler, bool),
) -> Vec<usize> {
    let layout: &Layout = &data.layout;
    let mut leaving = Vec::new();
    for particle in 0..block.count {
        let get = |label, component| block.get(layout, label, particle, component);
        let x: [f64; 3] = std::array::from_fn(|a| get(LabelId::Position, a));
        let y = level.base(x, data.half_size);
        let gone = (0..3).any(|a| outside(level, data, a, y[a])) || !level.contains(x);
        if !gone && !(0..3).any(|a| out_of_reach(block.index, a, y[a])) {
            continue;
        }
        leaving.push(particle);
        let who = Left {
            material,
            patch,
            identity: get(LabelId::Identity, 0).to_bits(),
            position: x,
            velocity: std::array::from_fn(|a| get(LabelId::Velocity, a)),
            mass: get(LabelId::Mass, 0),
        };
        let mut record = Vec::with_capacity(layout.total);
        block.read(layout, particle, &mut record);
        each(Traveler { from: (block.index, particle), who, record }, gone);
    }
    leaving
}
