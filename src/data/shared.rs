//! Values that are the same everywhere: the clock, the steps of materials, and the state of rigid bodies.
use bytemuck::{Pod, Zeroable};

/// Time and the present tick: the step of the fastest material, and a part of the steps of slower ones.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Clock {
    /// Time at the start of the tick [s].
    pub time: f64,
    /// Δt of the tick [s].
    pub step: f64,
    /// Time that no step passes: the end of the run [s].
    pub until: f64,
    /// Index of the material that limits the step, −1: the end of the run.
    pub limited_by: f64,
    /// The signal speed that limits it [m/s].
    pub speed: f64,
    /// Number of the tick, from the beginning of the run.
    pub number: f64,
    /// Number of the tick with which all materials are together again: the end of the step.
    pub last: f64,
    /// Time at that moment [s].
    pub end: f64,
}

/// The step of its own that a material is in.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct MaterialStep {
    /// Time at its start [s].
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

/// A rigid body: where it is and how it moves.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct RigidState {
    /// Mass [kg].
    pub mass: f64,
    /// Center of mass [m].
    pub center: [f64; 3],
    /// Velocity of the center of mass [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity [rad/s].
    pub angular: [f64; 3],
    /// Rotation R from the reference, row by row.
    pub rotation: [f64; 9],
    /// Inertia tensor in the reference orientation about the center [kg m²], row by row.
    pub inertia: [f64; 9],
    /// 1: moved by contact and loads, 0: motion prescribed.
    pub free: f64,
    /// Makes whole cache lines.
    pub unused: [f64; 3],
}

impl RigidState {
    /// Velocity of the body's point at `x` [m]: V + ω × (x − X_c).
    #[inline]
    pub fn velocity_at(&self, x: [f64; 3]) -> [f64; 3] {
        let r: [f64; 3] = std::array::from_fn(|a| x[a] - self.center[a]);
        let w = self.angular;
        let v = self.velocity;
        [v[0] + w[1] * r[2] - w[2] * r[1], v[1] + w[2] * r[0] - w[0] * r[2], v[2] + w[0] * r[1] - w[1] * r[0]]
    }
}
