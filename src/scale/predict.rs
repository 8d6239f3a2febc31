//! A discrete-event simulation of ticks on many ranks: the schedule of `exec::step`, `exec::border` and `exec::relocate`
//! with costs in place of work.
//!
//! A rank lists its blocks, brings the particles of its rim to the nodes, packs and sends the sums, and works on its
//! interior. Between two slabs of a phase it looks whether the sums of all neighbors are here; then it does the nodes of
//! its rim and sends their motion. At the end of the interior it waits for what is missing, takes the motion of its rim
//! back to the particles, sends travelers to all neighbors, waits for theirs, and reduces with all ranks by recursive
//! doubling: once the labels of the tick, and once whether the run shall stop. Events are the moments at which a rank
//! sends; they are handled in the order of time, so that messages share wires as they would.
use super::load::{Edge, Load, Ranks};
use super::model::{Cluster, Costs};
use super::reduce::{Act, Inbox, Rounds};
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

/// What a rank sends next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Send {
    #[default]
    Sums,
    Motion,
    Travelers,
    Round,
}

/// Messages that a rank waits for on one channel: of this tick and the next, which neighbors may have begun.
#[derive(Clone, Copy, Debug, Default)]
struct Wait {
    missing: u32,
    latest: Moment,
}

const SUMS: usize = 0;
const MOTION: usize = 1;
const TRAVELERS: usize = 2;

#[derive(Clone, Debug, Default)]
struct State {
    now: Moment,
    next: Send,
    /// Whether it waits for the messages of this channel.
    stuck: Option<usize>,
    /// `[tick % 2][channel]`.
    waits: [[Wait; 3]; 2],
    /// How many messages come in a tick, and their bytes.
    comes: [u32; 3],
    brings: [f32; 2],
    tick: usize,
    rounds: Rounds,
    /// When the interior began, how long it takes, and between two looks at the messages [s].
    inner: (f64, f64, f64),
    /// Sums of [`Shares`] [s].
    spent: [f64; 5],
    /// Factor of the time of tasks in this tick.
    slow: f64,
}

/// Indices of [`State::spent`].
const COMPUTE: usize = 0;
const ENGINE: usize = 1;
const HALO: usize = 2;
const TRAVEL: usize = 3;
const REDUCTION: usize = 4;

struct Simulation<'a, R: ?Sized> {
    ranks: &'a R,
    setup: &'a Setup,
    states: Vec<State>,
    wires: Wires,
    inbox: Inbox,
    queue: BinaryHeap<Reverse<(u64, u32)>>,
    edges: Vec<Edge>,
    /// When the last rank ended the first tick, and all of them.
    ends: [Moment; 2],
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

    /// Seconds of tasks on some blocks, as a rank's workers share them: the last of them ends half a block after the mean,
    /// for each slab.
    fn tasks(&self, rank: usize, ns: f64, blocks: f64, slabs: f64) -> f64 {
        let (costs, workers) = (&self.setup.costs, self.setup.threads as f64);
        if ns <= 0.0 {
            return 0.0;
        }
        let alone = ns * costs.contention * self.states[rank].slow;
        let uneven = match self.setup.threads {
            1 => 0.0,
            _ => slabs * (costs.fork + 0.5 * alone / blocks.max(1.0) * (workers - 1.0) / workers),
        };
        1e-9 * (alone / workers + uneven).min(alone + slabs * costs.fork)
    }

    /// A tick begins: everything up to the sums.
    fn begin(&mut self, rank: usize) {
        let load = self.ranks.load(rank);
        let state = &mut self.states[rank];
        state.slow = 1.0 + self.setup.cluster.noise * exponential(rank as u64, state.tick as u64);
        let give = self.tasks(rank, load.rim[0], load.blocks[0], 1.0);
        self.spend(rank, ENGINE, Cause::Engine, 1e-9 * load.lists);
        self.spend(rank, COMPUTE, Cause::Compute, give);
        self.ranks.edges(rank, &mut self.edges);
        let bytes: f32 = self.edges.iter().map(|edge| edge.sums).sum();
        self.handle(rank, HALO, bytes);
        self.post(rank, Send::Sums);
    }

    /// A rank is busy.
    fn spend(&mut self, rank: usize, part: usize, cause: Cause, seconds: f64) {
        let state = &mut self.states[rank];
        state.now = state.now.after(seconds, cause);
        state.spent[part] += seconds;
    }

    /// A rank packs or unpacks.
    fn handle(&mut self, rank: usize, part: usize, bytes: f32) {
        self.spend(rank, part, Cause::Handling, 1e-9 * self.setup.costs.pack * f64::from(bytes));
    }

    /// A rank waits for a moment.
    fn wait(&mut self, rank: usize, part: usize, until: Moment) {
        let state = &mut self.states[rank];
        state.spent[part] += (until.time - state.now.time).max(0.0);
        state.now = state.now.or_later(until);
    }

    fn post(&mut self, rank: usize, next: Send) {
        let state = &mut self.states[rank];
        state.next = next;
        // times are not negative: their bits are in their order
        self.queue.push(Reverse((state.now.time.to_bits(), rank as u32)));
    }

    /// A rank sends what it has, and goes on as far as it can.
    fn send(&mut self, rank: usize) {
        match self.states[rank].next {
            Send::Sums => {
                self.batch(rank, SUMS, HALO);
                let load = self.ranks.load(rank);
                let blocks = load.blocks[1];
                let phases = load.inner.map(|ns| self.tasks(rank, ns, blocks, load.slabs));
                let (whole, looks) = (phases.iter().sum::<f64>(), phases.len() as f64 * load.slabs);
                self.states[rank].inner = (self.states[rank].now.time, whole, whole / looks);
                self.go_on(rank, SUMS);
            }
            Send::Motion => {
                self.batch(rank, MOTION, HALO);
                let (began, whole, _) = self.states[rank].inner;
                // the rest of the interior: `inner.0` moved with everything that came in between
                let rest = (began + whole - self.states[rank].now.time).max(0.0);
                self.spend(rank, COMPUTE, Cause::Compute, rest);
                self.go_on(rank, MOTION);
            }
            Send::Travelers => {
                self.batch(rank, TRAVELERS, TRAVEL);
                self.go_on(rank, TRAVELERS);
            }
            Send::Round => self.round(rank),
        }
    }

    /// One message to each neighbor that gets one.
    fn batch(&mut self, rank: usize, channel: usize, part: usize) {
        let mut edges = std::mem::take(&mut self.edges);
        self.ranks.edges(rank, &mut edges);
        for edge in &edges {
            let bytes = f64::from([edge.sums, edge.motion, LINE][channel]);
            if bytes > 0.0 {
                self.spend(rank, part, Cause::Handling, self.setup.cluster.overhead);
                let (to, state) = (edge.to as usize, &self.states[rank]);
                let (tick, sent) = (state.tick, state.now);
                let arrival = self.wires.arrival(rank, to, bytes, sent);
                let wait = &mut self.states[to].waits[tick % 2][channel];
                wait.missing -= 1;
                wait.latest = wait.latest.or_later(arrival);
                if wait.missing == 0 && self.states[to].stuck == Some(channel) && self.states[to].tick == tick
                {
                    self.states[to].stuck = None;
                    self.go_on(to, channel);
                }
            }
        }
        self.edges = edges;
    }

    /// Goes on after the messages of a channel, if they are known to come; else waits for that.
    fn go_on(&mut self, rank: usize, channel: usize) {
        let state = &mut self.states[rank];
        let wait = &mut state.waits[state.tick % 2][channel];
        if wait.missing > 0 {
            state.stuck = Some(channel);
            return;
        }
        let here = wait.latest;
        *wait = Wait { missing: state.comes[channel], latest: Moment::default() };
        let load = self.ranks.load(rank);
        match channel {
            SUMS => self.rim_nodes(rank, &load, here),
            MOTION => self.take(rank, &load, here),
            _ => {
                self.wait(rank, TRAVEL, here);
                let messages = f64::from(self.states[rank].comes[TRAVELERS]);
                self.spend(rank, TRAVEL, Cause::Handling, messages * self.setup.cluster.overhead);
                self.states[rank].rounds = Rounds::begin(rank, self.states.len());
                self.round(rank);
            }
        }
    }

    /// The sums are here: the nodes of the rim, at the next look between two slabs.
    fn rim_nodes(&mut self, rank: usize, load: &Load, here: Moment) {
        let (began, whole, look) = self.states[rank].inner;
        let passed = (here.time - began).max(0.0);
        let until = if passed >= whole || look <= 0.0 { whole } else { (passed / look).ceil() * look };
        let until = if passed <= 0.0 { 0.0 } else { until.min(whole) };
        self.spend(rank, COMPUTE, Cause::Compute, until);
        self.wait(rank, HALO, here);
        let before = self.states[rank].now.time;
        let brought = self.states[rank].brings[SUMS];
        let messages = f64::from(self.states[rank].comes[SUMS]);
        self.spend(rank, HALO, Cause::Handling, messages * self.setup.cluster.overhead);
        self.handle(rank, HALO, brought);
        let nodes = self.tasks(rank, load.rim[1], load.blocks[0], 1.0);
        self.spend(rank, COMPUTE, Cause::Compute, nodes);
        self.ranks.edges(rank, &mut self.edges);
        let mut bytes = 0.0;
        let mut sends = 0.0;
        for edge in self.edges.iter().filter(|edge| edge.motion > 0.0) {
            (bytes, sends) = (bytes + edge.motion, sends + 1.0);
        }
        self.handle(rank, HALO, bytes);
        let state = &mut self.states[rank];
        // what is left of the interior begins after this and after the messages have left
        let busy = state.now.time - before + sends * self.setup.cluster.overhead;
        state.inner = if passed >= whole { (began, 0.0, 0.0) } else { (began + busy, whole, look) };
        self.post(rank, Send::Motion);
    }

    /// The motion is here: the particles of the rim, and who leaves.
    fn take(&mut self, rank: usize, load: &Load, here: Moment) {
        self.wait(rank, HALO, here);
        let brought = self.states[rank].brings[MOTION];
        let messages = f64::from(self.states[rank].comes[MOTION]);
        self.spend(rank, HALO, Cause::Handling, messages * self.setup.cluster.overhead);
        self.handle(rank, HALO, brought);
        let take = self.tasks(rank, load.rim[2], load.blocks[0], 1.0);
        self.spend(rank, COMPUTE, Cause::Compute, take);
        self.spend(rank, ENGINE, Cause::Engine, 1e-9 * load.relocate);
        self.post(rank, Send::Travelers);
    }

    /// Goes on with the reductions: until something has to leave, or is not known yet.
    fn round(&mut self, rank: usize) {
        let ranks = self.states.len();
        if std::mem::take(&mut self.states[rank].rounds.sending) {
            self.send_round(rank);
        }
        loop {
            let state = &self.states[rank];
            match state.rounds.act(rank, ranks) {
                Act::End => return self.end(rank),
                Act::Send(_) => {
                    self.states[rank].rounds.sending = true;
                    return self.post(rank, Send::Round);
                }
                Act::Receive => {
                    let (place, tick) = (state.rounds.place(), state.tick);
                    let Some(arrival) = self.inbox.take(rank, tick, place) else {
                        self.states[rank].rounds.stuck = true;
                        return;
                    };
                    let bytes = self.bytes(rank);
                    self.wait(rank, REDUCTION, arrival);
                    let seconds = self.setup.cluster.overhead + 1e-9 * self.setup.costs.merge * bytes;
                    self.spend(rank, REDUCTION, Cause::Handling, seconds);
                    self.states[rank].rounds.step(rank, ranks);
                }
            }
        }
    }

    /// Bytes of the reduction that a rank is in.
    fn bytes(&self, rank: usize) -> f64 {
        if self.states[rank].rounds.second { f64::from(LINE) } else { self.setup.reduced }
    }

    fn send_round(&mut self, rank: usize) {
        let (rounds, ranks) = (self.states[rank].rounds, self.states.len());
        let (Act::Send(to), place) = (rounds.act(rank, ranks), rounds.place()) else { return };
        self.spend(rank, REDUCTION, Cause::Handling, self.setup.cluster.overhead);
        let (tick, sent, bytes) = (self.states[rank].tick, self.states[rank].now, self.bytes(rank));
        let arrival = self.wires.arrival(rank, to, bytes, sent);
        self.inbox.put(to, tick, place, arrival);
        self.states[rank].rounds.step(rank, ranks);
        let other = &mut self.states[to];
        if other.rounds.stuck && other.tick == tick && other.rounds.place() == place {
            other.rounds.stuck = false;
            self.round(to);
        }
    }

    fn end(&mut self, rank: usize) {
        let state = &mut self.states[rank];
        let end = usize::from(state.tick > 0);
        self.ends[end] = self.ends[end].or_later(state.now);
        state.tick += 1;
        if state.tick == 1 && self.setup.ticks > 1 {
            state.spent = [0.0; 5];
        }
        if state.tick < self.setup.ticks {
            self.begin(rank);
        }
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

/// Bytes of a message that says little: travelers are few, and their number is a line.
const LINE: f32 = 64.0;

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

/// A number of mean 1, exponentially distributed, the same for the same rank and tick (SplitMix64).
fn exponential(rank: u64, tick: u64) -> f64 {
    let mut z = (rank << 20 ^ tick).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    let unit = (((z ^ z >> 31) >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    -unit.ln()
}
