//! What a worker of a run is busy with: events, which a [`Recorder`](super::recorder::Recorder) takes down.
use crate::graph::phase::Stage;

/// What a worker was busy with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// The tasks of a stage, on some blocks.
    Task,
    /// Packing, sending and waiting for node data of other ranks.
    HaloWait,
    /// Bringing together the parts of a reduction.
    ReduceWait,
    /// Finding particles that move to other blocks and ranks, and sending those.
    Relocate,
    /// Putting particles into their new blocks, and blocks into order.
    Arrange,
    /// Writing results.
    Output,
    /// Nothing, while other workers of the rank were at work.
    Idle,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 7] = [
        Kind::Task,
        Kind::HaloWait,
        Kind::ReduceWait,
        Kind::Relocate,
        Kind::Arrange,
        Kind::Output,
        Kind::Idle,
    ];

    /// Its name in traces.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Task => "task",
            Kind::HaloWait => "halo wait",
            Kind::ReduceWait => "reduce wait",
            Kind::Relocate => "relocate",
            Kind::Arrange => "arrange",
            Kind::Output => "output",
            Kind::Idle => "idle",
        }
    }
}

/// Gaps that are not worth an event [ticks]: some microseconds.
pub(super) const JOINED: u64 = 5_000;

/// Stands for all, for none, or for the end of a tick.
pub const NONE: u32 = u32::MAX;

/// Stands for particles that come from other ranks, among messages.
pub const TRAVELERS: u32 = NONE - 1;

/// A piece of a worker's time. Events of one worker do not overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Event {
    /// What it was busy with.
    pub kind: Kind,
    /// Number of the graph in its program.
    pub graph: u32,
    /// Tasks and idleness: the first line of the stage in the recipe, or [`NONE`]. Waits: the phase that needs it, [`NONE`] at the end of a tick.
    pub place: u32,
    /// Index of the material, or [`NONE`].
    pub material: u32,
    /// The patch, or [`NONE`].
    pub patch: u32,
    /// The first layer of blocks of the slab, or [`NONE`]: the rim.
    pub slab: u32,
    /// Number of the exchange, [`TRAVELERS`] or [`NONE`].
    pub message: u32,
    /// Messages sent.
    pub messages: u32,
    /// Bytes sent.
    pub bytes: u64,
    /// Number of the step.
    pub step: u64,
    /// When it began, since the recorder did: in a recorder in ticks, else [ns].
    pub start: u64,
    /// How long it took: in a recorder in ticks, else [ns].
    pub duration: u64,
}

impl Event {
    fn new(kind: Kind, place: u32) -> Self {
        let [material, patch, slab, message] = [NONE; 4];
        let (graph, messages, bytes, step, start, duration) = (0, 0, 0, 0, 0, 0);
        Self { kind, graph, place, material, patch, slab, message, messages, bytes, step, start, duration }
    }

    /// The tasks of a stage.
    pub fn stage(stage: &Stage) -> Self {
        let first = stage.entries.first().map_or(NONE, |&entry| entry as u32);
        Self { material: stage.material.map_or(NONE, |m| m as u32), ..Self::new(Kind::Task, first) }
    }

    /// The halos before a phase.
    pub fn halo(phase: usize) -> Self {
        Self::new(Kind::HaloWait, phase as u32)
    }

    /// The reductions before a phase, or at the end of a tick.
    pub fn reduction(phase: Option<usize>) -> Self {
        Self::new(Kind::ReduceWait, phase.map_or(NONE, |phase| phase as u32))
    }

    /// Waiting for particles that come from other ranks.
    pub fn travelers() -> Self {
        Self { message: TRAVELERS, ..Self::reduction(None) }
    }

    /// Waiting until the other workers of the rank have done a stage.
    pub fn idle(stage: &Stage) -> Self {
        Self { kind: Kind::Idle, ..Self::stage(stage) }
    }

    /// Relocation, output, or idleness of no stage in particular.
    pub fn other(kind: Kind) -> Self {
        Self::new(kind, NONE)
    }

    /// The same, on one patch.
    pub fn on_patch(self, patch: usize) -> Self {
        Self { patch: patch as u32, ..self }
    }

    /// The same, on the slab that begins with some layer of blocks, counted from the level's first.
    pub fn on_slab(self, layer: usize) -> Self {
        Self { slab: layer as u32, ..self }
    }

    /// The same, for an exchange.
    pub fn of_exchange(self, number: usize) -> Self {
        Self { message: number as u32, ..self }
    }

    /// The same, with what was sent.
    pub fn sent(self, messages: usize, bytes: usize) -> Self {
        Self { messages: messages as u32, bytes: bytes as u64, ..self }
    }

    /// Whether `next` is more of the same, begun as soon as this ended.
    pub(super) fn goes_on_with(&self, next: &Event, start: u64) -> bool {
        let what = |e: &Event| (e.kind, e.graph, e.place, e.material, e.patch, e.slab, e.message);
        what(self) == what(next) && start.saturating_sub(self.start + self.duration) < JOINED
    }

    /// As numbers, to be sent to another rank.
    pub fn to_words(self) -> [u64; Event::WORDS] {
        let two = |a: u32, b: u32| u64::from(a) << 32 | u64::from(b);
        [
            two(self.kind as u32, self.place),
            two(self.material, self.patch),
            two(self.slab, self.message),
            two(self.graph, self.messages),
            self.bytes,
            self.step,
            self.start,
            self.duration,
        ]
    }

    /// From numbers of [`Event::to_words`]; `None` for others.
    pub fn from_words(words: &[u64]) -> Option<Self> {
        let &[a, b, c, d, bytes, step, start, duration] = words else { return None };
        let two = |word: u64| ((word >> 32) as u32, word as u32);
        let ((kind, place), (material, patch), (slab, message)) = (two(a), two(b), two(c));
        let (kind, (graph, messages)) = (*Kind::ALL.get(kind as usize)?, two(d));
        Some(Self {
            kind,
            graph,
            place,
            material,
            patch,
            slab,
            message,
            messages,
            bytes,
            step,
            start,
            duration,
        })
    }

    /// Numbers of an event.
    pub const WORDS: usize = 8;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_survive_the_way_to_another_rank() {
        let event = Event::halo(3).of_exchange(1).on_patch(7).on_slab(2).sent(5, 1 << 40);
        let event = Event { step: 9, start: 1 << 50, duration: 17, ..event };
        assert_eq!(Event::from_words(&event.to_words()), Some(event));
        let kinds = Kind::ALL.map(Event::other);
        assert!(kinds.iter().all(|event| Event::from_words(&event.to_words()) == Some(*event)));
        assert_eq!(Event::from_words(&[9 << 32, 0, 0, 0, 0, 0, 0, 0]), None, "there is no such kind");
        assert_eq!(Event::from_words(&[0; 3]), None);
    }
}
