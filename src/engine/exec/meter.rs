//! Where the time of a step goes: by recipe entry, and by what the engine does besides.
//!
//! Tasks are told apart by reading a counter between them. Sweeps are compiled with and without it: a run that is not
//! metered pays nothing.
use simd::counting::{self, Counts};
use simd::ticks;
use std::time::{Duration, Instant};

/// What the engine does in a stage besides its tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StagePart {
    /// Partial node sums of blocks set to zero.
    Zeroing,
    /// Motion of nodes copied into the region of a block.
    LoadRegion,
    /// Partial sums of the blocks around added up, in a fixed order.
    SumPartials,
    /// Columns and shared labels laid out for a block.
    Setup,
}

impl StagePart {
    /// All of them.
    pub const ALL: [StagePart; 4] =
        [StagePart::Zeroing, StagePart::LoadRegion, StagePart::SumPartials, StagePart::Setup];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            StagePart::Zeroing => "(zero partial sums)",
            StagePart::LoadRegion => "(load region)",
            StagePart::SumPartials => "(sum partials)",
            StagePart::Setup => "(set up)",
        }
    }
}

/// What is metered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A line of the recipe.
    Entry(usize),
    /// Work of the engine for the stage that begins with this line of the recipe.
    Part(usize, StagePart),
    /// Particles moved to other blocks, after the step.
    Relocation,
    /// Blocks and neighbors rebuilt, before the step.
    Activation,
}

impl What {
    fn slot(self) -> usize {
        const STRIDE: usize = 1 + StagePart::ALL.len();
        match self {
            What::Relocation => 0,
            What::Activation => 1,
            What::Entry(entry) => 2 + STRIDE * entry,
            What::Part(entry, part) => 3 + STRIDE * entry + part as usize,
        }
    }
}

/// What something took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Ticks of [`ticks`].
    pub ticks: u64,
    /// How often the counter was read for it.
    pub laps: u64,
    /// Vector operations, if they were counted.
    pub counts: Counts,
}

/// The costs of one worker, or of all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    costs: Vec<Cost>,
    /// Whether the tasks run on [`simd::Isa::COUNTING`].
    pub counting: bool,
}

impl Tally {
    /// What something took so far.
    pub fn cost(&self, what: What) -> Cost {
        self.costs.get(what.slot()).copied().unwrap_or_default()
    }

    /// The costs so far; from here on they count from zero.
    pub fn take(&mut self) -> Tally {
        Tally { costs: std::mem::take(&mut self.costs), counting: self.counting }
    }

    /// How often the counter was read.
    pub fn laps(&self) -> u64 {
        self.costs.iter().map(|cost| cost.laps).sum()
    }

    /// Adds the costs of another worker.
    pub fn merge(&mut self, other: &Tally) {
        self.counting |= other.counting;
        self.costs.resize(self.costs.len().max(other.costs.len()), Cost::default());
        for (cost, more) in self.costs.iter_mut().zip(&other.costs) {
            cost.ticks += more.ticks;
            cost.laps += more.laps;
            cost.counts += more.counts;
        }
    }

    #[inline(always)]
    fn add(&mut self, what: What, ticks: u64) {
        let slot = what.slot();
        if slot >= self.costs.len() {
            self.costs.resize(slot + 1, Cost::default());
        }
        let cost = &mut self.costs[slot];
        cost.ticks += ticks;
        cost.laps += 1;
        if self.counting {
            cost.counts += counting::take();
        }
    }
}

/// Reads the counter between pieces of work, unless it is `OFF`: then it is nothing.
pub struct Laps<const ON: bool> {
    tally: Tally,
    last: u64,
}

impl<const ON: bool> Laps<ON> {
    /// Begins; holds the worker's tally until [`Laps::end`].
    #[inline(always)]
    pub fn begin(tally: &mut Tally) -> Self {
        if !ON {
            return Self { tally: Tally::default(), last: 0 };
        }
        counting::take();
        Self { tally: std::mem::take(tally), last: ticks() }
    }

    /// Since the last lap, the worker has done `what`.
    #[inline(always)]
    pub fn lap(&mut self, what: What) {
        if ON {
            let now = ticks();
            self.tally.add(what, now - self.last);
            self.last = now;
        }
    }

    /// Gives the tally back.
    #[inline(always)]
    pub fn end(self, tally: &mut Tally) {
        if ON {
            *tally = self.tally;
        }
    }
}

/// What ticks are worth.
#[derive(Clone, Copy, Debug)]
pub struct Calibration {
    /// Nanoseconds a tick.
    pub ns_per_tick: f64,
    /// Ticks that an empty lap shows: what reading the counter costs.
    pub lap_ticks: f64,
}

impl Calibration {
    /// Compares the counter with the clock, for some hundredths of a second.
    pub fn measure() -> Self {
        let (began, first) = (Instant::now(), ticks());
        while began.elapsed() < Duration::from_millis(50) {
            std::hint::spin_loop();
        }
        let ns_per_tick = began.elapsed().as_nanos() as f64 / (ticks() - first) as f64;
        Self { ns_per_tick, lap_ticks: empty_lap() }
    }

    /// Nanoseconds that metering itself took.
    pub fn meter_ns(&self, tally: &Tally) -> f64 {
        tally.laps() as f64 * self.lap_ticks * self.ns_per_tick
    }

    /// Nanoseconds of a cost, without what metering it took.
    pub fn ns(&self, cost: Cost) -> f64 {
        (cost.ticks as f64 - cost.laps as f64 * self.lap_ticks).max(0.0) * self.ns_per_tick
    }
}

/// The best of several: interruptions only add.
fn empty_lap() -> f64 {
    const LAPS: u64 = 1000;
    let once = || {
        let mut tally = Tally::default();
        let mut laps = Laps::<true>::begin(&mut tally);
        (0..LAPS).for_each(|_| laps.lap(std::hint::black_box(What::Entry(0))));
        laps.end(&mut tally);
        tally.cost(What::Entry(0)).ticks
    };
    (0..20).map(|_| once()).min().unwrap_or(0) as f64 / LAPS as f64
}
