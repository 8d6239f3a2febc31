//! The order of a tick as a value: what a rank works on, packs, sends, expects, unpacks and reduces, and what may come before
//! what. [`Engine`](super::Engine) executes it; a model of a machine may replay it with a clock.
use super::wave;
use crate::graph::build::TaskGraph;
use crate::graph::task::Domain;
use std::ops::Range;

/// One thing that a rank does. Phases and exchanges are those of the graph, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Op {
    /// Brings the parts of all ranks of the labels together that a phase reads.
    Reduce(usize),
    /// Runs a phase that has no place.
    Once(usize),
    /// Runs a phase on some blocks.
    Work(usize, Part),
    /// Packs what an exchange sends, and sends it.
    Send(usize),
    /// Makes room for what an exchange brings.
    Expect(usize),
    /// Waits for what an exchange brings, and puts it in its place.
    Unpack(usize),
    /// Sends particles that changed their rank.
    SendTravelers,
    /// Receives those that come here.
    ReceiveTravelers,
    /// Brings the parts of all ranks together of labels that nobody has read yet.
    ReduceAtEnd,
}

/// Which blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Those of a slab.
    Slab(usize),
    /// Those of a slab that need nothing of other ranks.
    Interior(usize),
    /// Those that do, or that others need.
    Rim,
}

/// A piece of a tick.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Segment {
    /// One thing.
    One(Op),
    /// Phases over blocks that follow one another: see [`Wave`].
    Wave(Range<usize>),
}

/// The pieces of a tick, up to its end.
pub fn segments(graph: &TaskGraph) -> impl Iterator<Item = Segment> + '_ {
    graph.waves.iter().flat_map(|wave| {
        let first = &graph.phases[wave.start];
        let reduce = (!first.reductions.is_empty()).then_some(Segment::One(Op::Reduce(wave.start)));
        let once = first.stages.first().is_some_and(|stage| stage.domain == Domain::Once);
        let work = if once { Segment::One(Op::Once(wave.start)) } else { Segment::Wave(wave.clone()) };
        reduce.into_iter().chain([work])
    })
}

/// The end of a tick that moves particles.
pub const END: [Op; 3] = [Op::SendTravelers, Op::ReceiveTravelers, Op::ReduceAtEnd];

/// What follows the last piece of a tick.
pub fn end(graph: &TaskGraph) -> &'static [Op] {
    if graph.moves_particles() { &END } else { &[Op::ReduceAtEnd] }
}

/// What happens in a wave.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wave {
    /// At first: the rim of the first phase, and what it sends.
    first: Vec<Op>,
    /// Then the interior, phase by phase and slab by slab.
    interior: Vec<Op>,
    /// In between, as soon as messages are here: the rim of phases over nodes.
    between: Vec<Op>,
    /// At last: the rim of particles, which read nodes of the interior too.
    last: Vec<Op>,
}

impl Wave {
    /// The wave of some phases of a graph, in so many slabs; on one rank, or on several.
    pub fn fill(&mut self, graph: &TaskGraph, phases: Range<usize>, slabs: usize, alone: bool) {
        for list in [&mut self.first, &mut self.interior, &mut self.between, &mut self.last] {
            list.clear();
        }
        let part = |slab| if alone { Part::Slab(slab) } else { Part::Interior(slab) };
        let order = wave::order(phases.len(), slabs);
        self.interior.extend(order.map(|(phase, slab)| Op::Work(phases.start + phase, part(slab))));
        if alone {
            return;
        }
        let opening = |e: &usize| graph.exchanges[*e].from.is_none();
        for phase in phases.clone() {
            let receives = &graph.phases[phase].receives;
            self.first.extend(receives.iter().copied().filter(opening).map(Op::Send));
        }
        self.first.extend(graph.phases[phases.start].receives.iter().map(|&e| Op::Expect(e)));
        for phase in phases.clone() {
            let list = match phase {
                phase if phase == phases.start => &mut self.first,
                phase if graph.phases[phase].is_over_nodes() => &mut self.between,
                _ => &mut self.last,
            };
            list.extend(graph.phases[phase].receives.iter().map(|&e| Op::Unpack(e)));
            list.push(Op::Work(phase, Part::Rim));
            list.extend(graph.phases[phase].sends.iter().map(|&e| Op::Send(e)));
            if phase + 1 < phases.end {
                list.extend(graph.phases[phase + 1].receives.iter().map(|&e| Op::Expect(e)));
            }
        }
    }

    /// Everything that the wave does, in an order that is possible.
    pub fn ops(&self) -> impl Iterator<Item = Op> + '_ {
        [&self.first, &self.between, &self.interior, &self.last].into_iter().flatten().copied()
    }
}

/// How far a rank is in a wave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cursor {
    first: usize,
    interior: usize,
    between: usize,
    last: usize,
}

impl Cursor {
    /// What to do next; `None` at the end. `here` says whether all that an exchange brings has arrived: while there is other
    /// work, nobody waits for it.
    ///
    /// # Errors
    /// Those of `here`.
    pub fn next<E>(
        &mut self,
        wave: &Wave,
        mut here: impl FnMut(usize) -> Result<bool, E>,
    ) -> Result<Option<Op>, E> {
        let take = |at: &mut usize, list: &[Op]| list.get(*at).copied().inspect(|_| *at += 1);
        if let Some(op) = take(&mut self.first, &wave.first) {
            return Ok(Some(op));
        }
        let idle = self.interior == wave.interior.len();
        if let Some(&op) = wave.between.get(self.between) {
            let possible = match op {
                Op::Unpack(exchange) if !idle => here(exchange)?,
                _ => true,
            };
            if possible {
                self.between += 1;
                return Ok(Some(op));
            }
        }
        Ok(take(&mut self.interior, &wave.interior).or_else(|| take(&mut self.last, &wave.last)))
    }
}
