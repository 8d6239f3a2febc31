//! Tools: rigid bodies that are a shape with a signed distance, and where the matter at a node meets them.
use crate::node::Site;
use crate::rigid::state::RigidState;
use engine::data::rates::Clock;
use physics::contact::surface::SurfaceTable;
use physics::contact::{AnyContactLaw, ContactLaw, Pair, dot};
use physics::motion::Course;
use physics::solid::Solid;

/// Something rigid that pushes matter.
#[derive(Clone, Debug)]
pub struct Tool {
    /// Its shape at time 0.
    pub shape: Solid,
    /// What moves it.
    pub pose: Pose,
    /// The tile of `Reactions` of who holds it.
    pub tile: usize,
    /// Whom it meets.
    pub meets: Vec<Meeting>,
}

/// What says where a tool is.
#[derive(Clone, Debug)]
pub enum Pose {
    /// A rigid material.
    Body(usize),
    /// A course in time, without a turn.
    Course(Course),
}

/// A material that a tool meets.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// Which one.
    pub material: usize,
    /// How.
    pub law: AnyContactLaw,
    /// Contact acts only while the gap is below this many cells; a bond holds whatever is at nodes within the tool, or
    /// half a cell before it.
    pub gap: f64,
    /// The tile of `Reactions` of the contact, and the sign of what the matter gets there.
    pub tile: Option<(usize, f64)>,
}

/// Nodes that a tool holds lie at most so many cells before its surface: there is always a layer of nodes that near.
const BOND: f64 = 0.5;

/// Where a tool is now.
pub struct Placed {
    /// And how it moves.
    pub state: RigidState,
}

impl Placed {
    /// Where a point of the body is now that was at `x` [m] at time 0.
    pub fn from_reference(&self, x: [f64; 3]) -> [f64; 3] {
        let s = &self.state;
        let r: [f64; 3] = std::array::from_fn(|a| x[a] - s.origin[a]);
        std::array::from_fn(|a| s.center[a] + (0..3).map(|b| s.rotation[3 * a + b] * r[b]).sum::<f64>())
    }

    /// Distance of a point, and the normal there.
    pub fn distance(&self, shape: &Solid, x: [f64; 3]) -> (f64, [f64; 3]) {
        let s = &self.state;
        let r: [f64; 3] = std::array::from_fn(|a| x[a] - s.center[a]);
        let back = |a: usize| (0..3).map(|b| s.rotation[3 * b + a] * r[b]).sum::<f64>();
        let (distance, n) = shape.distance(std::array::from_fn(|a| s.origin[a] + back(a)));
        (distance, std::array::from_fn(|a| (0..3).map(|b| s.rotation[3 * a + b] * n[b]).sum()))
    }
}

impl Tool {
    /// Where it is in the tick that begins at a time [s].
    pub fn place(&self, time: f64, tick: f64, bodies: &[RigidState]) -> Placed {
        match &self.pose {
            Pose::Body(material) => Placed { state: bodies[*material] },
            Pose::Course(course) => Placed { state: moved(course, time, tick) },
        }
    }

    /// Whether it may come within `reach` [m] of a point in a tick, as a bound.
    pub fn is_beside(&self, clock: &Clock, bodies: &[RigidState], x: [f64; 3], reach: f64) -> bool {
        let (distance, _) = self.place(clock.time, clock.tick, bodies).distance(&self.shape, x);
        distance.abs() < reach
    }

    /// The rigid material that it is, if it is one.
    pub fn body(&self) -> Option<usize> {
        match self.pose {
            Pose::Body(material) => Some(material),
            Pose::Course(_) => None,
        }
    }

    /// Whether it meets a material.
    pub fn meets(&self, material: usize) -> bool {
        self.meets.iter().any(|meeting| meeting.material == material)
    }
}

/// A body that only moves along: its state at the beginning of a tick, with the mean velocity of the tick.
fn moved(course: &Course, time: f64, tick: f64) -> RigidState {
    let mut state: RigidState = bytemuck::Zeroable::zeroed();
    state.center = course.way(0.0, time);
    // the very first time is asked for before there is a tick
    let rate = if tick > 0.0 { 1.0 / tick } else { 0.0 };
    state.velocity = course.way(time, time + tick).map(|way| rate * way);
    (0..3).for_each(|a| state.rotation[4 * a] = 1.0);
    state
}

impl Meeting {
    /// The normal of a tool where the matter at a node at `x` [m] touches it. The tool is asked where the matter is, and not where the
    /// node is: so a thin plate has two sides. With n = ∇φ(Y) its surface lies at φ(Y) + (x_I − Y)·n before the node; the gap to that of
    /// the matter decides.
    pub fn touch(
        &self,
        (shape, placed): (&Solid, &Placed),
        site: &Site,
        x: [f64; 3],
        (surface, h): (&SurfaceTable, f64),
    ) -> Option<[f64; 3]> {
        let y = site.center();
        let (depth, normal) = placed.distance(shape, y);
        let from: [f64; 3] = std::array::from_fn(|a| x[a] - y[a]);
        let before = (depth + dot(from, normal)) / h;
        let gap = before + surface.surface(-dot(from, normal) / h);
        let bonded = self.law.bond().is_some();
        let touches = if bonded { before <= BOND } else { before <= 1.0 && gap <= self.gap };
        touches.then_some(normal)
    }

    /// What the law sees of matter that moves with a velocity relative to the tool.
    pub fn pair(&self, site: &Site, normal: [f64; 3], relative: [f64; 3]) -> Pair {
        let (reduced_mass, traction) = (site.mass(), site.traction());
        Pair { relative, reduced_mass, normal: normal.map(|n| -n), traction }
    }
}
