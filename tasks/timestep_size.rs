use crate::labels::{OwnStep, SignalSpeed, Time};
use engine::data::rates::{Clock, MaterialStep};
use engine::graph::task::{At, Body};
use simd::{Simd, Wide};

/// The tick, and the steps of the materials, each a whole number of ticks.
///
/// Alone, a material could take Δt = CFL h / max (c + |v|). A tick is the smallest of these; a step ends when all are
/// together again, at the latest after `most` ticks. With `most` = 1 all materials take the common step. A slow material
/// also heeds those that touch it, Δt ≤ CFL h / (c + |v| of the other), so that nothing crosses a cell of it unseen.
pub struct TimestepSize {
    /// CFL number.
    pub cfl: f64,
    /// Edge of a cell [m].
    pub cell: f64,
    /// Most ticks in a step.
    pub most: f64,
    /// For each material, those that it touches.
    pub touches: Vec<Vec<usize>>,
    /// Which materials are rigid: they take every tick.
    pub rigid: Vec<bool>,
}

engine::task! { Once task TimestepSize {
    requires old { speed: SignalSpeed }
    modifies { time: Time, step: OwnStep }
}}

impl Body for TimestepSize {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        self.decide(&mut io.time[0], &mut io.step, &io.speed);
    }
}

impl TimestepSize {
    /// The tick that begins, and the steps that begin with it, from max (c + |v|), max c and max |v| of each material.
    pub fn decide(&self, clock: &mut Clock, steps: &mut [MaterialStep], speeds: &[[Wide; 3]]) {
        if clock.number >= clock.last {
            self.begin(clock, speeds);
        }
        for (m, step) in steps.iter_mut().enumerate().filter(|(_, step)| step.last <= clock.number) {
            let left = clock.last - clock.number;
            let alone = self.alone(speeds, m);
            // a hair more, so that rounding does not cost a tick
            let ticks = if self.rigid[m] { 1.0 } else { (alone / clock.tick * (1.0 + 1e-9)).floor() };
            let ticks = (left / (left / ticks.clamp(1.0, left)).ceil()).ceil();
            *step = MaterialStep {
                time: clock.time,
                size: ticks * clock.tick,
                first: clock.number,
                last: clock.number + ticks,
                unused: step.unused,
            };
        }
    }

    /// A new step, and the size of its ticks.
    fn begin(&self, clock: &mut Clock, speeds: &[[Wide; 3]]) {
        let of = |m: usize, kind: usize| largest(&speeds[m][kind]);
        let all = 0..speeds.len();
        let (fastest, speed) =
            all.clone().map(|m| (m, of(m, 0))).max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0));
        let tick = self.cfl * self.cell / speed;
        let deformable = all.filter(|&m| !self.rigid[m]).map(|m| (m, self.alone(speeds, m)));
        let (slowest, longest) = deformable.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((fastest, tick));

        let left = clock.until - clock.time;
        let ticks = (longest.min(left) / tick).ceil().clamp(1.0, self.most);
        let stable = if self.most > 1.0 { longest.min(ticks * tick) } else { tick };
        let limited_by = if ticks > 1.0 { slowest } else { fastest };
        let whole;
        (whole, clock.limited_by) = if stable < left { (stable, limited_by as f64) } else { (left, -1.0) };
        clock.end = if stable < left { clock.time + whole } else { clock.until };
        clock.tick = whole / ticks;
        clock.last = clock.number + ticks;
        clock.speed = speed;
    }

    /// The longest step that a material could take [s].
    fn alone(&self, speeds: &[[Wide; 3]], material: usize) -> f64 {
        let [signal, sound, _] = speeds[material].each_ref().map(largest);
        let others = self.touches[material].iter().map(|&other| sound + largest(&speeds[other][2]));
        self.cfl * self.cell / others.fold(signal, f64::max)
    }
}

fn largest(line: &Wide) -> f64 {
    line.0.iter().copied().fold(0.0, f64::max)
}
