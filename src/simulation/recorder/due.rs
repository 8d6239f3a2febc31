//! When a frame or a checkpoint is due.
use crate::input::scene::{Checkpoint, Scene};
use std::time::Instant;

/// A hair early rather than a step late.
const HAIR: f64 = 1e-12;

/// How many whole intervals have passed.
pub fn passed(time: f64, every: f64) -> usize {
    (time / every * (1.0 + HAIR)).floor() as usize
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

/// Whether frame `number`, counted from 0, is due at a time.
pub fn frame(time: f64, number: usize, scene: &Scene) -> bool {
    time >= number as f64 * frame_interval(scene) * (1.0 - HAIR)
}

/// When checkpoints are due.
#[derive(Debug)]
pub struct Checkpoints {
    last: Instant,
    /// Intervals of simulated time that had passed at the last step.
    passed: usize,
    /// Whether this run has written one.
    any: bool,
}

impl Checkpoints {
    /// From a time on.
    pub fn begin(time: f64, wanted: &Checkpoint) -> Self {
        let passed = wanted.time.map_or(0, |every| passed(time, every));
        Self { last: Instant::now(), passed, any: false }
    }

    /// Whether one is due after a step: the same on all ranks.
    pub fn by_step(&mut self, steps: u64, time: f64, finished: bool, wanted: &Checkpoint) -> bool {
        let passed = wanted.time.map_or(0, |every| passed(time, every));
        let by_time = std::mem::replace(&mut self.passed, passed) < passed;
        let by_steps = wanted.steps.is_some_and(|every| steps.is_multiple_of(every));
        let at_end = finished && (self.any || wanted.steps.is_some() || wanted.time.is_some());
        by_time || by_steps || at_end
    }

    /// Whether one is due by this rank's clock.
    pub fn by_clock(&self, wanted: &Checkpoint) -> bool {
        wanted.wall > 0.0 && self.last.elapsed().as_secs_f64() >= wanted.wall
    }

    /// After one is written.
    pub fn written(&mut self) {
        (self.last, self.any) = (Instant::now(), true);
    }
}
