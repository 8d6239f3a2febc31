//! When a frame or a checkpoint is due.
use crate::output::checkpoint::Recorded;
use scene::shown::Probe;
use scene::{Checkpoint, Period, Scene};
use std::time::Instant;

/// A hair early rather than a step late.
const HAIR: f64 = 1e-12;

/// How many whole intervals have passed.
pub fn passed(time: f64, every: f64) -> usize {
    (time / every * (1.0 + HAIR)).floor() as usize
}

/// Number of the interval that ends after a time.
pub fn after(time: f64, every: f64) -> usize {
    passed(time, every).saturating_add(1)
}

/// Simulated time between two frames [s].
pub fn frame_interval(scene: &Scene) -> f64 {
    scene.run.until / scene.output.frames.max(1) as f64
}

/// The same, of a scene as it is written in a checkpoint.
pub fn stored_frame_interval(resolved: &str) -> Option<f64> {
    let scene: toml::Table = resolved.parse().ok()?;
    let until = scene.get("run")?.get("until")?.as_float()?;
    let frames = scene.get("output")?.get("frames")?.as_integer()?;
    Some(until / frames.max(1) as f64)
}

/// Steps between two rows of the history, of a scene as it is written in a checkpoint.
pub fn stored_history_every(resolved: &str) -> Option<u64> {
    let scene: toml::Table = resolved.parse().ok()?;
    scene.get("output")?.get("history-every")?.as_integer()?.try_into().ok()
}

/// Frames that a restart goes on after, if the last row and the last frame are `dropped`.
pub fn frames_kept(recorded: &Recorded, dropped: [bool; 2]) -> u64 {
    recorded.frames.saturating_sub(dropped[1].into())
}

/// Whether frame `number` of the whole run, counted from 0, is due at a time.
fn frame(time: f64, number: usize, scene: &Scene) -> bool {
    time >= number as f64 * frame_interval(scene) * (1.0 - HAIR)
}

/// What is due after a step.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Due {
    /// A row of the history with all columns.
    pub row: bool,
    /// Probes, by number, of which a row is due without the other columns.
    pub probes: Vec<usize>,
    /// A frame of the whole run.
    pub frame: bool,
    /// A frame of a period.
    pub extra: bool,
}

impl Due {
    /// After step `steps`, at a time [s], with the step before at another one; `number` is that of the next frame of the whole run.
    pub fn after(steps: u64, [before, time]: [f64; 2], number: usize, scene: &Scene) -> Self {
        let output = &scene.output;
        let here = |period: &&Period| (period.from..period.to).contains(&time);
        let every = output.periods.iter().rev().filter(here).find_map(|period| period.history_every);
        let row = steps.is_multiple_of(every.unwrap_or(output.history_every).max(1));
        let own = |probe: &Probe| {
            probe.interval.is_some_and(|every| begun([before, time], every, |time| passed(time, every)))
        };
        let probes = scene.probes.iter().enumerate().filter(|(_, probe)| !row && own(probe));
        let frames = output.frames > 0;
        Self {
            row,
            probes: probes.map(|(number, _)| number).collect(),
            frame: frames && frame(time, number, scene),
            extra: frames && output.periods.iter().any(|period| starts(period, [before, time])),
        }
    }
}

/// Whether an interval has begun between two times: of those that are shorter than a step, and may be too many to count, one has.
fn begun([before, time]: [f64; 2], every: f64, count: impl Fn(f64) -> usize) -> bool {
    time - before >= every || count(time) > count(before)
}

/// Whether a period has a frame after a step between two times.
fn starts(period: &Period, [before, time]: [f64; 2]) -> bool {
    let inside = period.from <= before && time < period.to;
    match period.frames_every {
        Some(every) if inside => begun([before, time], every, |time| begins(period, time)),
        _ => begins(period, time) > begins(period, before),
    }
}

/// How many intervals between frames of a period have begun.
fn begins(period: &Period, time: f64) -> usize {
    match period.frames_every {
        Some(every) if time >= period.from * (1.0 - HAIR) => {
            passed(time.min(period.to) - period.from, every).saturating_add(1)
        }
        _ => 0,
    }
}

/// When checkpoints are due.
#[derive(Debug)]
pub struct Checkpoints {
    last: Instant,
    /// Intervals of simulated time that had passed at the last step.
    passed: usize,
    /// Seconds that the last one took.
    pub took: Option<f64>,
}

impl Checkpoints {
    /// From a time on.
    pub fn begin(time: f64, wanted: &Checkpoint) -> Self {
        let passed = wanted.time.map_or(0, |every| passed(time, every));
        Self { last: Instant::now(), passed, took: None }
    }

    /// Whether one is due after a step: the same on all ranks.
    pub fn by_step(&mut self, steps: u64, time: f64, finished: bool, wanted: &Checkpoint) -> bool {
        let passed = wanted.time.map_or(0, |every| passed(time, every));
        let by_time = std::mem::replace(&mut self.passed, passed) < passed;
        let by_steps = wanted.steps.is_some_and(|every| steps.is_multiple_of(every));
        by_time || by_steps || (finished && wanted.at_end)
    }

    /// Whether one is due by this rank's clock.
    pub fn by_clock(&self, wanted: &Checkpoint) -> bool {
        wanted.wall > 0.0 && self.last.elapsed().as_secs_f64() >= wanted.wall
    }

    /// After one that took so many seconds is written.
    pub fn written(&mut self, took: f64) {
        (self.last, self.took) = (Instant::now(), Some(took));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEVER: Checkpoint = Checkpoint { steps: None, time: None, wall: 0.0, kept: 2, at_end: true };

    /// The steps of 0.3 s after which one is due; the 20th is the last.
    fn due(wanted: &Checkpoint) -> Vec<u64> {
        let mut checkpoints = Checkpoints::begin(0.0, wanted);
        (1..=20).filter(|&step| checkpoints.by_step(step, 0.3 * step as f64, step == 20, wanted)).collect()
    }

    #[test]
    fn checkpoints_are_due_by_steps_by_time_and_at_the_end() {
        assert_eq!(due(&NEVER), [20]);
        assert!(due(&Checkpoint { at_end: false, ..NEVER }).is_empty());
        assert_eq!(due(&Checkpoint { at_end: false, steps: Some(8), ..NEVER }), [8, 16]);
        assert_eq!(due(&Checkpoint { steps: Some(8), ..NEVER }), [8, 16, 20]);
        // 1.5 s are passed with step 5, not with step 6
        assert_eq!(due(&Checkpoint { time: Some(1.5), ..NEVER }), [5, 10, 15, 20]);
        assert_eq!(due(&Checkpoint { time: Some(0.1), ..NEVER }).len(), 20);
        assert_eq!(due(&Checkpoint { time: Some(100.0), ..NEVER }), [20]);
    }

    #[test]
    fn intervals_end_where_numbers_do() {
        assert_eq!([after(0.0, 0.5), after(0.9, 0.5), after(1.0, 0.5)], [1, 2, 3]);
        assert_eq!(after(1.0, f64::MIN_POSITIVE), usize::MAX);
        assert_eq!(after(1.0, 0.0), usize::MAX);
    }

    #[test]
    fn intervals_shorter_than_a_step_begin_with_every_step() {
        let due = |every: f64| begun([1e-3, 2e-3], every, |time| passed(time, every));
        assert!(due(1e-3) && due(1e-20) && due(1e-300) && due(f64::MIN_POSITIVE));
        assert!(!due(3e-3));
        let period = Period { from: 0.0, to: 1.5e-3, frames_every: Some(1e-300), history_every: None };
        assert!(starts(&period, [0.0, 1e-3]) && !starts(&period, [2e-3, 3e-3]));
    }

    #[test]
    fn the_clock_counts_from_the_last_one() {
        let wanted = Checkpoint { wall: 1e-9, ..NEVER };
        let mut checkpoints = Checkpoints::begin(0.0, &wanted);
        assert!(!checkpoints.by_clock(&NEVER));
        std::thread::sleep(std::time::Duration::from_millis(1));
        assert!(checkpoints.by_clock(&wanted));
        checkpoints.written(0.5);
        assert_eq!(checkpoints.took, Some(0.5));
        assert!(!checkpoints.by_clock(&Checkpoint { wall: 3600.0, ..NEVER }));
    }
}
