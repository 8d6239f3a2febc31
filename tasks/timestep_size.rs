use crate::data::labels::{SignalSpeed, Time};
use crate::graph::task::{At, Body};
use crate::simd::Simd;

/// Δt = CFL h / max (c + |v|), and no step beyond the end of the run.
pub struct TimestepSize {
    /// CFL number.
    pub cfl: f64,
    /// Edge of a cell [m].
    pub cell: f64,
}

crate::task! { Once task TimestepSize {
    requires old { speed: SignalSpeed }
    modifies { time: Time }
}}

impl Body for TimestepSize {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let fastest = |line: &crate::simd::Wide| line.0.iter().copied().fold(0.0, f64::max);
        let speeds = io.speed.iter().map(fastest).enumerate();
        let (material, speed) = speeds.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
        let clock = &mut io.time[0];
        let left = clock.until - clock.time;
        let stable = self.cfl * self.cell / speed;
        (clock.step, clock.limited_by) = if stable < left { (stable, material as f64) } else { (left, -1.0) };
        clock.speed = speed;
    }
}
