//! The state of a rigid body.
use bytemuck::{Pod, Zeroable};
use physics::contact::cross;

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
    /// Where the center is in the reference [m].
    pub origin: [f64; 3],
}

/// The motion of a free rigid body that is sought in a tick (see [`super::newton`]): V and ω.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct RigidTrial {
    /// Without contact.
    pub start: [f64; 6],
    /// As far as it is known.
    pub now: [f64; 6],
    /// How often it has been tried.
    pub rounds: f64,
    /// What loads would add along locked axes [m/s].
    pub held: [f64; 3],
    /// What its force gives in the tick [N s].
    pub push: [f64; 3],
    /// 1: found.
    pub found: f64,
    /// Makes whole cache lines.
    pub unused: [f64; 4],
}

impl RigidTrial {
    /// Velocity [m/s] at an arm r [m] from the center: V + ω × r.
    #[inline]
    pub fn velocity_at(&self, r: [f64; 3]) -> [f64; 3] {
        let [x, y, z, u, v, w] = self.now;
        let turn = cross([u, v, w], r);
        [x + turn[0], y + turn[1], z + turn[2]]
    }
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
