use crate::labels::{StepOver, Time};
use engine::graph::task::{At, Body};
use simd::{Simd, Wide};

engine::task! {
    /// Ends the tick: t ← t + Δt; and says whether all materials are together again, so that the step is over too.
    pub struct AdvanceClock;

    Once task {
        computes { over: StepOver }
        modifies { time: Time }
    }
}

impl Body for AdvanceClock {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let clock = &mut io.time[0];
        clock.number += 1.0;
        clock.time = if clock.number < clock.last { clock.time + clock.tick } else { clock.end };
        io.over[0] = Wide([f64::from(u8::from(clock.number >= clock.last)); 8]);
    }
}
