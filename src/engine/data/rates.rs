//! Clocks, and the steps that materials take.
use bytemuck::{Pod, Zeroable};

/// The present time and tick: the step of the fastest material, and a part of the steps of slower ones.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Clock {
    /// The time at the start of the tick [s].
    pub time: f64,
    /// Size of the tick [s].
    pub tick: f64,
    /// The time that no step passes: the end of the run [s].
    pub until: f64,
    /// Index of the material that limits the step, −1: the end of the run.
    pub limited_by: f64,
    /// The signal speed that limits it [m/s].
    pub speed: f64,
    /// Number of the tick, from the beginning of the run.
    pub number: f64,
    /// Number of the tick with which all materials are together again: the end of the step.
    pub last: f64,
    /// The time at that moment [s].
    pub end: f64,
}

/// The step of its own that a material is in.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct MaterialStep {
    /// The time at its start [s].
    pub time: f64,
    /// Δt [s]
    pub size: f64,
    /// Number of its first tick.
    pub first: f64,
    /// Number of the tick after its last one.
    pub last: f64,
    /// Makes a whole cache line.
    pub unused: [f64; 4],
}
