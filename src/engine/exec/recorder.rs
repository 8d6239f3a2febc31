//! Records what the workers of a run do and when: sums for the table at the end of a run (see [`Spent`]), and event by event for the run's
//! `trace.json` (see `output::trace`), if that is wanted.
//!
//! Each worker has a list of its own, so that recording waits for nobody. The lists are as long as they will ever be from
//! the beginning; what comes after they are full is counted and left out. The sums cost a reading of a counter a block: 33 ns, of the 10 000 or
//! more that a stage takes on a full one.
use super::spent::Spent;
use super::trace::{Event, JOINED};
use simd::ticks;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// The events of one worker.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Track {
    /// In the order in which they ended.
    pub events: Vec<Event>,
    /// How many more did not fit.
    pub lost: u64,
}

/// What one worker has done.
#[derive(Debug, Default)]
struct Worker {
    track: Track,
    spent: Spent,
    /// When its last piece of work ended.
    end: u64,
    /// Waiting in the piece of work that goes on.
    waited: u64,
}

/// Events that a worker may record, if nobody says otherwise: 80 bytes each.
pub const BOUND: usize = 1 << 18;

/// Records what the workers of a rank do.
#[derive(Debug)]
pub struct Recorder {
    origin: (Instant, u64),
    step: AtomicU64,
    graph: AtomicU32,
    paused: AtomicBool,
    workers: Vec<Mutex<Worker>>,
    bound: usize,
}

impl Recorder {
    /// A recorder of sums, and of at most `bound` events for each of `workers` workers. The time counts from now: ranks that begin after a
    /// message to all have the same time to within the time of a message.
    pub fn new(workers: usize, bound: usize) -> Self {
        let track = || Track { events: Vec::with_capacity(bound), lost: 0 };
        let worker = || Mutex::new(Worker { track: track(), ..Worker::default() });
        Self {
            origin: (Instant::now(), ticks()),
            step: AtomicU64::new(0),
            graph: AtomicU32::new(0),
            paused: AtomicBool::new(false),
            workers: (0..workers).map(|_| worker()).collect(),
            bound,
        }
    }

    /// Sets the step that events belong to from now on.
    pub fn set_step(&self, step: u64) {
        self.step.store(step, Ordering::Relaxed);
    }

    /// Sets the graph of the program that events belong to from now on.
    pub fn set_graph(&self, number: usize) {
        self.graph.store(number as u32, Ordering::Relaxed);
    }

    /// Records nothing from now on, or goes on: graphs that are no part of a step have the same numbers.
    pub fn pause(&self, paused: bool) {
        self.paused.store(paused, Ordering::Relaxed);
    }

    /// The time now [ticks].
    #[inline]
    pub fn now(&self) -> u64 {
        ticks().saturating_sub(self.origin.1)
    }

    /// A worker has been busy with `event` since `start` (see [`Recorder::now`]).
    #[inline]
    pub fn record(&self, worker: usize, start: u64, event: Event) {
        self.add(worker, start, event, false);
    }

    /// As [`Recorder::record`], since the worker's last event if that ended later than `start`: work on blocks that come one after the
    /// other, of which the counter is read once each. Goes on with the last event if that was the same.
    #[inline]
    pub fn record_on(&self, worker: usize, start: u64, event: Event) {
        self.add(worker, start, event, true);
    }

    fn add(&self, worker: usize, start: u64, event: Event, joins: bool) {
        if self.paused.load(Ordering::Relaxed) {
            return;
        }
        let Some(worker) = self.workers.get(worker) else { return };
        let (mut worker, end) = (lock(worker), self.now());
        let start = if joins { start.max(worker.end) } else { start };
        let (step, graph) = (self.step.load(Ordering::Relaxed), self.graph.load(Ordering::Relaxed));
        let event = Event { step, graph, start, duration: end.saturating_sub(start), ..event };
        let waited = std::mem::take(&mut worker.waited);
        worker.spent.add(&event, waited);
        worker.end = end;
        if self.bound == 0 {
            return;
        }
        let Track { events, lost } = &mut worker.track;
        let room = events.len() < self.bound;
        match events.last_mut() {
            Some(last) if joins && last.goes_on_with(&event, start) => last.duration = end - last.start,
            _ if room => events.push(event),
            _ => *lost += 1,
        }
    }

    /// Of the piece of work that a worker is at, it has waited since `start` for other ranks.
    pub fn waited(&self, worker: usize, start: u64) {
        if self.paused.load(Ordering::Relaxed) {
            return;
        }
        if let Some(worker) = self.workers.get(worker) {
            lock(worker).waited += self.now().saturating_sub(start);
        }
    }

    /// All workers have waited since their last event, or since `start`, for one that was at work longer.
    pub fn record_idle(&self, start: u64, event: Event) {
        for (worker, its) in self.workers.iter().enumerate() {
            let last = lock(its).end;
            if self.now() > last.max(start) + JOINED {
                self.record(worker, last.max(start), event);
            }
        }
    }

    /// Nanoseconds a tick, as the time since the beginning says.
    fn ns_per_tick(&self) -> f64 {
        self.origin.0.elapsed().as_nanos() as f64 / self.now().max(1) as f64
    }

    /// What the workers have recorded, in nanoseconds; they go on with empty lists.
    pub fn take(&self) -> Vec<Track> {
        let ns_per_tick = self.ns_per_tick();
        let ns = |ticks: u64| (ticks as f64 * ns_per_tick) as u64;
        let take = |worker: &Mutex<Worker>| {
            let fresh = Track { events: Vec::with_capacity(self.bound), lost: 0 };
            let mut track = std::mem::replace(&mut lock(worker).track, fresh);
            for event in &mut track.events {
                // an end that is rounded by itself is never after the beginning of the next
                let end = ns(event.start + event.duration);
                event.start = ns(event.start);
                event.duration = end - event.start;
            }
            track
        };
        self.workers.iter().map(take).collect()
    }

    /// What the time of all workers went to so far, and nanoseconds a tick.
    pub fn spent(&self) -> (Spent, f64) {
        let mut all = Spent::default();
        self.workers.iter().for_each(|worker| all.merge(&lock(worker).spent));
        (all, self.ns_per_tick())
    }
}

/// A worker's record: nobody else takes it while the worker works.
fn lock(worker: &Mutex<Worker>) -> MutexGuard<'_, Worker> {
    worker.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::trace::Kind;

    #[test]
    fn a_full_list_counts_what_it_loses_and_allocates_nothing() {
        let recorder = Recorder::new(2, 3);
        let began = recorder.now();
        let info = allocation_counter::measure(|| {
            (0..5).for_each(|_| recorder.record(1, began, Event::other(Kind::Output)));
        });
        assert_eq!(info.count_total, 0);
        let tracks = recorder.take();
        assert_eq!(tracks.iter().map(|t| (t.events.len(), t.lost)).collect::<Vec<_>>(), [(0, 0), (3, 2)]);
        assert_eq!(recorder.take()[1].lost, 0);
        recorder.record(7, began, Event::other(Kind::Output)); // no such worker
    }

    #[test]
    fn waiting_within_a_piece_of_work_is_no_work() {
        let recorder = Recorder::new(1, 0);
        let (began, work) = (recorder.now(), Event { place: 3, ..Event::other(Kind::Task) });
        std::thread::sleep(std::time::Duration::from_millis(20));
        recorder.waited(0, began);
        recorder.record(0, began, work);
        recorder.pause(true);
        recorder.record(0, began, work);
        let (spent, ns_per_tick) = recorder.spent();
        let ms = |ticks: u64| ticks as f64 * ns_per_tick * 1e-6;
        assert!(
            ms(spent.waiting()) >= 19.9 && ms(spent.stage(0, 3)) < 0.1 * ms(spent.waiting()),
            "{spent:?}"
        );
        assert_eq!(recorder.take(), [Track::default()], "of sums alone no event is kept");
    }
}
