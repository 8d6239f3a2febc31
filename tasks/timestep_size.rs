use crate::labels::{OwnStep, SignalSpeed, Time};
use engine::data::rates::{Clock, MaterialStep};
use engine::graph::task::{At, Body};
use physics::motion::Motion;
use physics::table::Table;
use simd::{Simd, Wide};

engine::task! {
    /// Decides the tick, and the steps of the materials, each a whole number of ticks.
    ///
    /// Alone, a material could take Δt = CFL h / max (c + |v|). A tick is the smallest of these; a step ends when all are
    /// together again, at the latest after `most` ticks. With `most` = 1 all materials take the common step. A slow material
    /// also heeds those that touch it, Δt ≤ CFL h / (c + |v| of the other), so that nothing crosses a cell of it unseen.
    ///
    /// All heed what will move within the step: tools, walls and drives by their largest speed until its end, and turns of at most a
    /// tenth of a radian; gravity and forces on rigid bodies, with v + |g| Δt for v.
    pub struct TimestepSize {
        /// CFL number.
        pub cfl: f64,
        /// Edge of a cell [m].
        pub cell: f64,
        /// Most ticks in a step.
        pub most: f64,
        /// For each material, those that it touches.
        pub touches: Vec<Vec<usize>>,
        /// What moves as prescribed, whatever matter does.
        pub movers: Vec<Mover>,
        /// g [m/s²] in time.
        pub gravity: Table,
        /// The materials on which it acts.
        pub falls: Vec<bool>,
        /// What else accelerates each material [m/s²] in time.
        pub pushes: Vec<Table>,
        /// Which materials are rigid: they take every tick.
        pub rigid: Vec<bool>,
    }

    Once task {
        requires old { speed: SignalSpeed }
        modifies { time: Time, step: OwnStep }
    }
}

/// Something whose motion is known beforehand.
#[derive(Clone, Debug)]
pub struct Mover {
    /// How it moves.
    pub motion: Motion,
    /// How far its points are from its center [m].
    pub radius: f64,
    /// The materials that it meets.
    pub meets: Vec<usize>,
}

/// The most that anything turns in a step [rad].
const TURN: f64 = 0.1;
/// Halvings in the search for a step before something moves suddenly.
const SEARCH: usize = 40;

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
            let alone = self.alone(speeds, m, clock.time);
            // a hair more, so that rounding does not cost a tick
            let ticks = if self.rigid[m] { 1.0 } else { (alone / clock.tick * (1.0 + 1e-9)).floor() };
            let ticks = (left / (left / ticks.min(left).max(1.0)).ceil()).ceil();
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
        let all = 0..speeds.len();
        let own = |m: usize| self.longest(m, largest(&speeds[m][0]), largest(&speeds[m][1]), clock.time);
        let (fastest, tick) =
            all.clone().map(|m| (m, own(m))).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::INFINITY));
        let deformable = all.filter(|&m| !self.rigid[m]).map(|m| (m, self.alone(speeds, m, clock.time)));
        let (slowest, longest) = deformable.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((fastest, tick));

        let left = clock.until - clock.time;
        let ticks = (longest.min(left) / tick).ceil().min(self.most).max(1.0);
        let stable = if self.most > 1.0 { longest.min(ticks * tick) } else { tick };
        let limited_by = if ticks > 1.0 { slowest } else { fastest };
        let whole;
        (whole, clock.limited_by) = if stable < left { (stable, limited_by as f64) } else { (left, -1.0) };
        clock.end = if stable < left { clock.time + whole } else { clock.until };
        clock.tick = whole / ticks;
        clock.last = clock.number + ticks;
        clock.speed = self.cfl * self.cell / tick;
    }

    /// The longest step that a material could take [s], which heeds those that touch it.
    fn alone(&self, speeds: &[[Wide; 3]], material: usize, time: f64) -> f64 {
        let [signal, sound, _] = speeds[material].each_ref().map(largest);
        let others = self.touches[material].iter().map(|&other| sound + largest(&speeds[other][2]));
        self.longest(material, others.fold(signal, f64::max), sound, time)
    }

    /// The longest step [s] of a material with this signal speed and speed of sound: the largest that what moves within it allows.
    fn longest(&self, material: usize, signal: f64, sound: f64, time: f64) -> f64 {
        let allowed = |step: f64| self.allowed(material, signal, sound, [time, time + step]);
        let most = (self.cfl * self.cell / signal).min(1e30);
        // what a longer step allows, a shorter one does, too
        let mut short = allowed(most);
        let mut long = allowed(short).min(most);
        for _ in 0..SEARCH {
            if short >= (1.0 - 1e-3) * long {
                break;
            }
            let middle = 0.5 * (short + long);
            if middle <= allowed(middle) { short = middle } else { long = middle }
        }
        short
    }

    /// The longest step [s] that is allowed by what moves from one time to another.
    fn allowed(&self, material: usize, signal: f64, sound: f64, [time, until]: [f64; 2]) -> f64 {
        let (way, mut speed, mut turning) = (self.cfl * self.cell, signal, 0.0f64);
        for mover in self.movers.iter().filter(|mover| mover.meets.contains(&material)) {
            speed = speed.max(sound + mover.motion.fastest(time, until, mover.radius));
            turning = turning.max(mover.motion.fastest_turn(time, until));
        }
        let size = |g: [f64; 3]| g.iter().map(|g| g * g).sum::<f64>().sqrt();
        let most = |table: &Table| table.within(time, until).map(|(_, g)| size(g)).fold(0.0, f64::max);
        let g = if self.falls[material] { most(&self.gravity) } else { 0.0 } + most(&self.pushes[material]);
        let fallen = 2.0 * way / (speed + (speed * speed + 4.0 * g * way).sqrt());
        fallen.min(TURN / turning)
    }
}

fn largest(line: &Wide) -> f64 {
    line.0.iter().copied().fold(0.0, f64::max)
}
