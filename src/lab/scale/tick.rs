//! What happens in a tick of the model, event by event: see [`super::predict`].
use super::load::{Load, Ranks};
use super::predict::Simulation;
use super::reduce::{Act, Rounds};
use super::wires::{Cause, Moment};
use std::cmp::Reverse;

/// What a rank sends next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Send {
    #[default]
    Sums,
    Motion,
    Travelers,
    Round,
}

/// Messages that a rank waits for on one channel: of this tick and the next, which neighbors may have begun.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wait {
    pub missing: u32,
    pub latest: Moment,
}

pub const SUMS: usize = 0;
pub const MOTION: usize = 1;
pub const TRAVELERS: usize = 2;

#[derive(Clone, Debug, Default)]
pub struct State {
    pub now: Moment,
    pub next: Send,
    /// Whether it waits for the messages of this channel.
    pub stuck: Option<usize>,
    /// `[tick % 2][channel]`.
    pub waits: [[Wait; 3]; 2],
    /// How many messages come in a tick, and their bytes.
    pub comes: [u32; 3],
    pub brings: [f32; 2],
    pub tick: usize,
    pub rounds: Rounds,
    /// When the interior began, how long it takes, and between two looks at the messages [s].
    pub inner: (f64, f64, f64),
    /// Sums of [`Shares`] [s].
    pub spent: [f64; 5],
    /// Factor of the time of tasks in this tick.
    pub slow: f64,
}

/// Indices of [`State::spent`].
pub const COMPUTE: usize = 0;
pub const ENGINE: usize = 1;
pub const HALO: usize = 2;
pub const TRAVEL: usize = 3;
pub const REDUCTION: usize = 4;

/// Bytes of a message that says little: travelers are few, and their number is a line.
pub const LINE: f32 = 64.0;

impl<R: Ranks + ?Sized> Simulation<'_, R> {
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
    pub(super) fn begin(&mut self, rank: usize) {
        let load = self.ranks.load(rank);
        let state = &mut self.states[rank];
        state.slow = 1.0 + self.setup.cluster.noise * exponential(rank as u64, state.tick as u64);
        let give = self.tasks(rank, load.rim[0], load.blocks[0], 1.0);
        self.spend(rank, ENGINE, Cause::Engine, 1e-9 * load.lists);
        self.spend(rank, COMPUTE, Cause::Compute, give);
        self.ranks.edges(rank, &mut self.edges);
        let bytes: f32 = self.edges.iter().map(|edge| edge.sums).sum();
        let bytes = self.shared(bytes);
        self.handle(rank, HALO, bytes);
        self.post(rank, Send::Sums);
    }

    /// A rank is busy.
    fn spend(&mut self, rank: usize, part: usize, cause: Cause, seconds: f64) {
        let state = &mut self.states[rank];
        state.now = state.now.after(seconds, cause);
        state.spent[part] += seconds;
    }

    /// A worker's part of sums, which all of them pack and unpack.
    fn shared(&self, bytes: f32) -> f32 {
        bytes / self.setup.threads as f32
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
    pub(super) fn send(&mut self, rank: usize) {
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
        let brought = self.shared(brought);
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
}

/// A number of mean 1, exponentially distributed, the same for the same rank and tick (SplitMix64).
fn exponential(rank: u64, tick: u64) -> f64 {
    let mut z = (rank << 20 ^ tick).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    let unit = (((z ^ z >> 31) >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    -unit.ln()
}
