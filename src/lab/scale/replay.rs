//! A discrete-event simulation of steps on many ranks: the engine's order of a tick with costs in place of work.
//!
//! Each rank goes through the [`Order`] of its ticks. What it does takes the time that the costs say; it waits where the
//! order has it take something that has not arrived. Reductions go through [`collective::act`]. After the ticks of a step
//! all ranks agree whether to go on. Events are the moments at which a rank sends, or looks whether a message is here while
//! others may still send it; they are handled in the order of time, so that messages share wires as they would.
use super::load::{Coming, Message, Ranks, coming};
use super::mail::{Mail, Topic};
use super::model::Setup;
use super::order::{Order, Place};
use super::wires::{Cause, Moment, Wires};
use engine::exec::order::Op;
use engine::exec::ranks::collective::{self, Act};
use engine::graph::exchange::Way;
use engine::graph::traffic::LINE;
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::ops::ControlFlow::{self, Break, Continue};

/// Indices of [`Replay::spent`].
pub const COMPUTE: usize = 0;
pub const ENGINE: usize = 1;
pub const HALO: usize = 2;
pub const TRAVEL: usize = 3;
pub const REDUCTION: usize = 4;

/// What a rank is in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Doing {
    /// Looks what is next.
    #[default]
    Next,
    /// Has messages of an exchange to send; `None`: travelers.
    Sends(Option<usize>),
    /// Needs those of others.
    Receives(Option<usize>),
    /// A reduction, by number of the act.
    Reduces(usize),
    /// All steps are done.
    Nothing,
}

#[derive(Clone, Debug, Default)]
struct State {
    now: Moment,
    doing: Doing,
    place: Place,
    /// Steps that are done, ticks of the present one, ticks and reductions of all.
    step: usize,
    tick: usize,
    ticks: u32,
    reductions: u32,
    /// Bytes of the present one, and whether it ends a step.
    reduction: (f64, bool),
    /// Messages that it waits for, and how many.
    waits: Option<(Topic, u32)>,
    /// Whether all that others send before now has been sent.
    settled: bool,
    /// Factor of the time of tasks in this tick.
    slow: f64,
    /// Sums by part of a step [s].
    spent: [f64; 5],
}

/// Nobody knows yet whether a message will be here.
struct Unsettled;

/// A simulation between two events.
pub struct Replay<'a, R: ?Sized, W> {
    ranks: &'a R,
    setup: &'a Setup<'a>,
    /// Hears what ranks do.
    each: W,
    states: Vec<State>,
    /// By number of slabs.
    orders: BTreeMap<usize, Order>,
    /// By kind of tick and exchange, the last one for travelers, and rank.
    coming: Vec<Vec<Vec<Coming>>>,
    wires: Wires,
    mail: Mail,
    /// Time, whether the rank only looks, and the rank.
    queue: BinaryHeap<Reverse<(u64, bool, u32)>>,
    /// Ranks for which the last message that they wait for has been sent.
    ready: Vec<usize>,
    messages: Vec<Message>,
    /// When the last rank ended the first step, and all of them.
    ends: [Moment; 2],
}

impl<'a, R: Ranks + ?Sized, W: FnMut(usize, Op)> Replay<'a, R, W> {
    /// All ranks at the beginning.
    pub fn new(ranks: &'a R, setup: &'a Setup<'a>, each: W) -> Self {
        let count = ranks.count();
        let kinds = 0..setup.step.kinds.len();
        let slabs = kinds.clone().flat_map(|kind| (0..count).map(move |rank| ranks.load(rank, kind).slabs));
        let exchanges = setup.step.graph.exchanges.len();
        let mut orders = BTreeMap::new();
        for slabs in slabs {
            orders.entry(slabs).or_insert_with(|| Order::new(setup.step.graph, slabs, count == 1));
        }
        Self {
            ranks,
            setup,
            each,
            states: vec![State::default(); count],
            orders,
            coming: kinds.map(|kind| coming(ranks, exchanges, kind)).collect(),
            wires: Wires::new(&setup.cluster, count),
            mail: Mail::new(count),
            queue: BinaryHeap::with_capacity(count),
            ready: Vec::new(),
            messages: Vec::new(),
            ends: [Moment::default(); 2],
        }
    }

    /// Simulates all steps.
    pub fn run(&mut self) {
        for rank in 0..self.states.len() {
            self.begin(rank);
            self.go(rank);
        }
        while let Some(Reverse((_, _, rank))) = self.queue.pop() {
            self.event(rank as usize);
            while let Some(rank) = self.ready.pop() {
                self.go(rank);
            }
        }
    }

    /// When the last rank ended the first step, and all of them.
    pub fn ends(&self) -> [Moment; 2] {
        self.ends
    }

    /// Time of all ranks by part of a step [s].
    pub fn spent(&self) -> [f64; 5] {
        let all = |part| self.states.iter().map(|state| state.spent[part]).sum();
        [COMPUTE, ENGINE, HALO, TRAVEL, REDUCTION].map(all)
    }

    fn kind(&self, rank: usize) -> usize {
        self.setup.step.ticks[self.states[rank].tick]
    }

    /// A rank is busy.
    fn spend(&mut self, rank: usize, part: usize, cause: Cause, seconds: f64) {
        let state = &mut self.states[rank];
        state.now = state.now.after(seconds, cause);
        state.spent[part] += seconds;
    }

    /// A rank waits for a moment.
    fn wait(&mut self, rank: usize, part: usize, until: Moment) {
        let state = &mut self.states[rank];
        state.spent[part] += (until.time - state.now.time).max(0.0);
        state.now = state.now.or_later(until);
    }

    /// A rank sends, or looks, when everything before has happened.
    fn post(&mut self, rank: usize, looks: bool) {
        // times are not negative: their bits are in their order
        self.queue.push(Reverse((self.states[rank].now.time.to_bits(), looks, rank as u32)));
    }

    /// A tick begins.
    fn begin(&mut self, rank: usize) {
        let lists = self.ranks.load(rank, self.kind(rank)).lists;
        let state = &mut self.states[rank];
        state.slow = self.setup.cluster.slowness(rank as u64, state.ticks.into());
        (state.place, state.doing) = (Place::default(), Doing::Next);
        self.spend(rank, ENGINE, Cause::Engine, 1e-9 * lists);
    }

    /// What a rank has posted happens.
    fn event(&mut self, rank: usize) {
        match self.states[rank].doing {
            Doing::Sends(exchange) => self.send(rank, exchange),
            Doing::Reduces(act) => self.send_part(rank, act),
            _ => self.states[rank].settled = true,
        }
        self.go(rank);
    }

    /// A rank goes on until it has to send, or to wait for what is not known yet.
    fn go(&mut self, rank: usize) {
        while self.advance(rank).is_continue() {}
    }

    fn advance(&mut self, rank: usize) -> ControlFlow<()> {
        match self.states[rank].doing {
            Doing::Next => self.next(rank),
            Doing::Receives(exchange) => self.take(rank, exchange),
            Doing::Reduces(act) => self.reduce(rank, act),
            Doing::Sends(_) => {
                self.post(rank, false);
                Break(())
            }
            Doing::Nothing => Break(()),
        }
    }

    /// A rank turns to something else.
    fn turn_to(&mut self, rank: usize, doing: Doing) -> ControlFlow<()> {
        self.states[rank].doing = doing;
        Continue(())
    }

    /// The next thing in the order.
    fn next(&mut self, rank: usize) -> ControlFlow<()> {
        let kind = self.kind(rank);
        let slabs = self.ranks.load(rank, kind).slabs;
        let State { ticks, now, settled, mut place, .. } = self.states[rank];
        let here = |exchange: usize| {
            let topic = Topic::Exchange(ticks, Some(exchange as u32));
            match self.mail.all(rank, topic, self.coming[kind][exchange][rank].messages) {
                Some(arrival) => Ok(arrival.time <= now.time),
                None if settled => Ok(false),
                None => Err(Unsettled),
            }
        };
        let Ok(op) = place.next(&self.orders[&slabs], here) else {
            self.post(rank, true);
            return Break(());
        };
        (self.states[rank].place, self.states[rank].settled) = (place, false);
        let Some(op) = op else { return self.end_tick(rank) };
        (self.each)(rank, op);
        self.perform(rank, kind, op)
    }

    fn perform(&mut self, rank: usize, kind: usize, op: Op) -> ControlFlow<()> {
        let tick = &self.setup.step.kinds[kind];
        match op {
            Op::Once(phase) => {
                let ns = self.ranks.load(rank, kind).work[phase][1];
                self.spend(rank, COMPUTE, Cause::Compute, 1e-9 * ns);
                Continue(())
            }
            Op::Work(phase, part) => {
                let load = self.ranks.load(rank, kind);
                let seconds = load.seconds(self.setup, phase, part, self.states[rank].slow);
                self.spend(rank, COMPUTE, Cause::Compute, seconds);
                Continue(())
            }
            Op::Send(exchange) => {
                self.ranks.sends(rank, kind, Some(exchange), &mut self.messages);
                let bytes = self.messages.iter().map(|message| message.bytes).sum();
                self.handle(rank, exchange, bytes);
                self.turn_to(rank, Doing::Sends(Some(exchange)))
            }
            Op::Expect(_) => Continue(()),
            Op::Unpack(exchange) => self.turn_to(rank, Doing::Receives(Some(exchange))),
            Op::SendTravelers => {
                let ns = self.ranks.load(rank, kind).relocate;
                self.spend(rank, ENGINE, Cause::Engine, 1e-9 * ns);
                self.turn_to(rank, Doing::Sends(None))
            }
            Op::ReceiveTravelers => self.turn_to(rank, Doing::Receives(None)),
            Op::Reduce(phase) => self.begin_reduction(rank, tick.reduced[phase], false),
            Op::ReduceAtEnd => {
                let bytes = tick.reduced.last().copied().unwrap_or_default();
                self.begin_reduction(rank, bytes, false)
            }
        }
    }

    /// A rank packs or unpacks: partial sums by all workers.
    fn handle(&mut self, rank: usize, exchange: usize, bytes: f32) {
        let workers = match self.setup.step.graph.exchanges[exchange].way {
            Way::Partials => self.setup.threads as f64,
            Way::Values => 1.0,
        };
        let seconds = 1e-9 * self.setup.costs.pack * f64::from(bytes) / workers;
        self.spend(rank, HALO, Cause::Handling, seconds);
    }

    /// One message to each rank that gets one.
    fn send(&mut self, rank: usize, exchange: Option<usize>) {
        let mut messages = std::mem::take(&mut self.messages);
        self.ranks.sends(rank, self.kind(rank), exchange, &mut messages);
        let topic = Topic::Exchange(self.states[rank].ticks, exchange.map(|number| number as u32));
        for &message in &messages {
            self.dispatch(rank, topic, message, part_of(exchange));
        }
        self.messages = messages;
        self.states[rank].doing = Doing::Next;
    }

    /// A rank sends its part of a reduction.
    fn send_part(&mut self, rank: usize, act: usize) {
        if let Some(Act::Send(to)) = collective::act(rank, self.states.len(), act) {
            let (bytes, _) = self.states[rank].reduction;
            let topic = Topic::Reduction(self.states[rank].reductions, rank as u32);
            self.dispatch(rank, topic, Message { to: to as u32, bytes: bytes as f32 }, REDUCTION);
        }
        self.states[rank].doing = Doing::Reduces(act + 1);
    }

    fn dispatch(&mut self, rank: usize, topic: Topic, message: Message, part: usize) {
        self.spend(rank, part, Cause::Handling, self.setup.cluster.overhead);
        let to = message.to as usize;
        let arrival = self.wires.arrival(rank, to, message.bytes.into(), self.states[rank].now);
        self.mail.put(to, topic, arrival);
        let waits = self.states[to].waits.filter(|(what, _)| *what == topic);
        if waits.is_some_and(|(_, count)| self.mail.all(to, topic, count).is_some()) {
            self.states[to].waits = None;
            self.ready.push(to);
        }
    }

    /// Takes messages when the last of them is here; if that is not known yet, the rank waits for it to be sent.
    fn receive(&mut self, rank: usize, topic: Topic, count: u32, part: usize) -> ControlFlow<()> {
        let Some(arrival) = self.mail.take(rank, topic, count) else {
            self.states[rank].waits = Some((topic, count));
            return Break(());
        };
        self.wait(rank, part, arrival);
        self.spend(rank, part, Cause::Handling, f64::from(count) * self.setup.cluster.overhead);
        Continue(())
    }

    /// Takes what comes in an exchange.
    fn take(&mut self, rank: usize, exchange: Option<usize>) -> ControlFlow<()> {
        let of_kind = &self.coming[self.kind(rank)];
        let Coming { messages, bytes } = of_kind[exchange.unwrap_or(of_kind.len() - 1)][rank];
        let topic = Topic::Exchange(self.states[rank].ticks, exchange.map(|number| number as u32));
        self.receive(rank, topic, messages, part_of(exchange))?;
        if let Some(exchange) = exchange {
            self.handle(rank, exchange, bytes);
        }
        self.turn_to(rank, Doing::Next)
    }

    fn begin_reduction(&mut self, rank: usize, bytes: f64, ends_step: bool) -> ControlFlow<()> {
        self.states[rank].reduction = (bytes, ends_step);
        self.turn_to(rank, Doing::Reduces(0))
    }

    /// One act of a reduction.
    fn reduce(&mut self, rank: usize, act: usize) -> ControlFlow<()> {
        let (bytes, ends_step) = self.states[rank].reduction;
        let (from, merge) = match collective::act(rank, self.states.len(), act) {
            None => {
                self.states[rank].reductions += 1;
                return if ends_step { self.end_step(rank) } else { self.turn_to(rank, Doing::Next) };
            }
            Some(Act::Send(_)) => {
                self.post(rank, false);
                return Break(());
            }
            Some(Act::Merge(from)) => (from, self.setup.costs.merge),
            Some(Act::Receive(from)) => (from, 0.0),
        };
        let topic = Topic::Reduction(self.states[rank].reductions, from as u32);
        self.receive(rank, topic, 1, REDUCTION)?;
        self.spend(rank, REDUCTION, Cause::Handling, 1e-9 * merge * bytes);
        self.turn_to(rank, Doing::Reduces(act + 1))
    }

    fn end_tick(&mut self, rank: usize) -> ControlFlow<()> {
        let state = &mut self.states[rank];
        (state.tick, state.ticks) = (state.tick + 1, state.ticks + 1);
        if state.tick < self.setup.step.ticks.len() {
            self.begin(rank);
            return Continue(());
        }
        self.begin_reduction(rank, LINE as f64, true)
    }

    fn end_step(&mut self, rank: usize) -> ControlFlow<()> {
        let state = &mut self.states[rank];
        let end = usize::from(state.step > 0);
        self.ends[end] = self.ends[end].or_later(state.now);
        (state.step, state.tick) = (state.step + 1, 0);
        if state.step == 1 && self.setup.steps > 1 {
            state.spent = [0.0; 5];
        }
        if state.step < self.setup.steps {
            self.begin(rank);
            return Continue(());
        }
        state.doing = Doing::Nothing;
        Break(())
    }
}

/// The part of a step that an exchange belongs to.
fn part_of(exchange: Option<usize>) -> usize {
    if exchange.is_some() { HALO } else { TRAVEL }
}
