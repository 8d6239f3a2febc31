//! A discrete-event simulation of ticks on many ranks: the schedule of `exec::step`, `exec::border` and `exec::relocate`
//! with costs in place of work.
//!
//! A rank lists its blocks, brings the particles of its rim to the nodes, packs and sends the sums, and works on its
//! interior. Between two slabs of a phase it looks whether the sums of all neighbors are here; then it does the nodes of
//! its rim and sends their motion. At the end of the interior it waits for what is missing, takes the motion of its rim
//! back to the particles, sends travelers to all neighbors, waits for theirs, and reduces with all ranks by recursive
//! doubling: once the labels of the tick, and once whether the run shall stop. Events are the moments at which a rank
//! sends; they are handled in the order of time, so that messages share wires as they would.
use super::load::{Edge, Ranks};
use super::model::{Cluster, Costs};
use super::reduce::Inbox;
use super::tick::{COMPUTE, ENGINE, HALO, MOTION, REDUCTION, SUMS, State, TRAVEL, Wait};
use super::wires::{Cause, Moment, Wires};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// What is simulated, but for the ranks.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Costs of work.
    pub costs: Costs,
    /// The network.
    pub cluster: Cluster,
    /// Workers a rank.
    pub threads: usize,
    /// Bytes of the reduction of a tick.
    pub reduced: f64,
    /// Ticks; the first one, in which all begin together, is not counted if there are more.
    pub ticks: usize,
}

/// Where the time of a mean rank went, as shares of the step. They add up to one.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Shares {
    /// Tasks.
    pub compute: f64,
    /// Lists of blocks, locks, looking for who leaves.
    pub engine: f64,
    /// Packing, sending, unpacking and waiting for node data.
    pub halo: f64,
    /// Sending travelers and waiting for them: this is where ranks that have less to do wait.
    pub travel: f64,
    /// Reductions.
    pub reduction: f64,
}

/// What came out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// A step [s].
    pub step: f64,
    /// Shares of a mean rank.
    pub shares: Shares,
    /// What the critical path through all ticks went into, as shares by [`Cause`].
    pub path: [f64; Cause::COUNT],
    /// Work of the rank that has most, over the mean.
    pub imbalance: f64,
}

/// A simulation between two events.
pub(super) struct Simulation<'a, R: ?Sized> {
    pub(super) ranks: &'a R,
    pub(super) setup: &'a Setup,
    pub(super) states: Vec<State>,
    pub(super) wires: Wires,
    pub(super) inbox: Inbox,
    pub(super) queue: BinaryHeap<Reverse<(u64, u32)>>,
    pub(super) edges: Vec<Edge>,
    /// When the last rank ended the first tick, and all of them.
    pub(super) ends: [Moment; 2],
}

/// Simulates some ticks.
pub fn simulate<R: Ranks + ?Sized>(ranks: &R, setup: &Setup) -> Outcome {
    let mut simulation = Simulation::new(ranks, setup);
    (0..ranks.count()).for_each(|rank| simulation.begin(rank));
    while let Some(Reverse((_, rank))) = simulation.queue.pop() {
        simulation.send(rank as usize);
    }
    simulation.outcome()
}

impl<'a, R: Ranks + ?Sized> Simulation<'a, R> {
    fn new(ranks: &'a R, setup: &'a Setup) -> Self {
        let count = ranks.count();
        let mut states = vec![State::default(); count];
        let mut edges = Vec::new();
        for rank in 0..count {
            ranks.edges(rank, &mut edges);
            for edge in &edges {
                let to = &mut states[edge.to as usize];
                let comes = [edge.sums > 0.0, edge.motion > 0.0, true].map(u32::from);
                to.comes.iter_mut().zip(comes).for_each(|(count, more)| *count += more);
                to.brings[SUMS] += edge.sums;
                to.brings[MOTION] += edge.motion;
            }
        }
        for state in &mut states {
            let fresh: [Wait; 3] = state.comes.map(|missing| Wait { missing, latest: Moment::default() });
            state.waits = [fresh; 2];
        }
        let (wires, inbox) = (Wires::new(&setup.cluster, count), Inbox::new(count));
        let (queue, ends) = (BinaryHeap::with_capacity(count), [Moment::default(); 2]);
        Self { ranks, setup, states, wires, inbox, queue, edges, ends }
    }

    fn outcome(&self) -> Outcome {
        let [first, last] = self.ends;
        let (step, whole) = match self.setup.ticks {
            0 | 1 => (first.time, first),
            ticks => ((last.time - first.time) / (ticks - 1) as f64, last),
        };
        let spent = |part: usize| self.states.iter().map(|state| state.spent[part]).sum::<f64>();
        let all = (COMPUTE..=REDUCTION).map(spent).sum::<f64>().max(f64::MIN_POSITIVE);
        let [compute, engine, halo, travel, reduction] =
            [COMPUTE, ENGINE, HALO, TRAVEL, REDUCTION].map(|part| spent(part) / all);
        let path: f64 = whole.parts.iter().map(|&x| f64::from(x)).sum::<f64>().max(f64::MIN_POSITIVE);
        Outcome {
            step,
            shares: Shares { compute, engine, halo, travel, reduction },
            path: whole.parts.map(|x| f64::from(x) / path),
            imbalance: imbalance(self.ranks),
        }
    }
}

fn imbalance<R: Ranks + ?Sized>(ranks: &R) -> f64 {
    let work = |rank: usize| {
        let load = ranks.load(rank);
        load.rim.iter().chain(&load.inner).sum::<f64>()
    };
    let (mut sum, mut most) = (0.0, 0.0_f64);
    for rank in 0..ranks.count() {
        (sum, most) = (sum + work(rank), most.max(work(rank)));
    }
    if sum > 0.0 { most * ranks.count() as f64 / sum } else { 1.0 }
}
