use crate::labels::{ContactWork, NodeMotion, NodeSums, Reactions, RigidMotion, Time, ToolSums};
use crate::node::{Motion, Sums, Surface};
use crate::reactions::Reaction;
use crate::rigid::state::RigidState;
use engine::data::rates::Clock;
use engine::data::schedule::FieldTime;
use engine::graph::task::{At, Body};
use grid::{Lattice, NODES};
use physics::contact::surface::SurfaceTable;
use physics::contact::{AnyContactLaw, ContactLaw, Pair, dot};
use physics::motion::Course;
use physics::solid::Solid;
use simd::Simd;

/// Contact with tools: bodies that are nothing but a shape and a motion, and moving faces. At a node the tool is asked where the matter
/// is, Y = Σ S m x / m, and not where the node is: so a thin plate has two sides. With n = ∇φ(Y) the surface lies at
/// φ(Y) + (x_I − Y)·n before the node; the gap to that of the matter decides, and the law takes u = v_I − V(x_I).
pub struct Tools {
    /// The tools, in the order of the scene.
    pub tools: Vec<Tool>,
    /// Where nodes are.
    pub lattice: Lattice,
    /// Mass below which a node carries nothing [kg].
    pub least_mass: f64,
    /// Where surfaces lie, for each material.
    pub surfaces: Vec<SurfaceTable>,
}

/// Something that pushes matter, whatever the matter does.
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

engine::task! { Nodes task Tools {
    requires new { time: Time, sums: NodeSums }
    requires now { bodies: RigidMotion, surfaces: ToolSums }
    computes { reactions: Reactions, work: ContactWork }
    modifies { motion: NodeMotion }
}}

/// Where a tool is now.
struct Placed {
    state: RigidState,
}

impl Placed {
    /// Distance of a point, and the normal there.
    fn distance(&self, shape: &Solid, x: [f64; 3]) -> (f64, [f64; 3]) {
        let s = &self.state;
        let r: [f64; 3] = std::array::from_fn(|a| x[a] - s.center[a]);
        let back = |a: usize| (0..3).map(|b| s.rotation[3 * b + a] * r[b]).sum::<f64>();
        let (distance, n) = shape.distance(std::array::from_fn(|a| s.origin[a] + back(a)));
        (distance, std::array::from_fn(|a| (0..3).map(|b| s.rotation[3 * a + b] * n[b]).sum()))
    }
}

impl Body for Tools {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let clock = &io.time[0];
        for tool in &self.tools {
            let placed = tool.place(clock.time, clock.tick, &io.bodies);
            for meeting in &tool.meets {
                let fields = at.fields.iter().enumerate().filter(|(_, f)| f.material == meeting.material);
                for (slot, field) in fields {
                    let lines = NODES * slot..NODES * (slot + 1);
                    let nodes = Nodes {
                        sums: &io.sums[lines.clone()],
                        surfaces: &io.surfaces[lines.clone()],
                        motions: &mut io.motion[lines],
                    };
                    let given = self.meet(at, field, (tool, &placed, meeting), nodes);
                    given.by_holder.store(&mut io.reactions[tool.tile]);
                    if let Some((tile, sign)) = meeting.tile {
                        given.by_holder.without_work().times(sign).store(&mut io.reactions[tile]);
                    }
                    io.work[0][0].add(given.friction);
                    io.work[0][1].add(given.impact);
                }
            }
        }
    }
}

impl Tool {
    /// Where it is in the tick that begins at a time [s].
    fn place(&self, time: f64, tick: f64, bodies: &[RigidState]) -> Placed {
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

/// The nodes of one field.
struct Nodes<'a> {
    sums: &'a [Sums],
    surfaces: &'a [Surface],
    motions: &'a mut [Motion],
}

/// What a tool gives to some nodes.
#[derive(Default)]
struct Given {
    by_holder: Reaction,
    friction: f64,
    impact: f64,
}

impl Tools {
    /// Exchanges impulses at all nodes of a field.
    #[inline(never)]
    fn meet(
        &self,
        at: &At<'_>,
        field: &FieldTime,
        (tool, placed, meeting): (&Tool, &Placed, &Meeting),
        nodes: Nodes<'_>,
    ) -> Given {
        let mut given = Given::default();
        let h = self.lattice.cell;
        for (n, motion) in nodes.motions.iter_mut().enumerate() {
            let (sum, surface) = (&nodes.sums[n], &nodes.surfaces[n]);
            let m = sum.mass();
            if m <= self.least_mass || surface.mass() <= 0.0 {
                continue;
            }
            let (x, v) = (self.lattice.position(at.node_of(n)), motion.velocity());
            // the center of mass goes on with the node while the particles wait
            let y: [f64; 3] =
                std::array::from_fn(|a| surface.moment(a) / surface.mass() + field.elapsed * v[a]);
            let (depth, normal) = placed.distance(&tool.shape, y);
            let from: [f64; 3] = std::array::from_fn(|a| x[a] - y[a]);
            let before = (depth + dot(from, normal)) / h;
            let bonded = meeting.law.bond().is_some();
            let gap = before + self.surfaces[meeting.material].surface(-dot(from, normal) / h);
            let touches = if bonded { before <= BOND } else { before <= 1.0 && gap <= meeting.gap };
            if !touches {
                continue;
            }
            let moving = placed.state.velocity_at(x);
            let outward: [f64; 3] = std::array::from_fn(|a| surface.outward(a));
            let area = dot(outward, outward).sqrt();
            let traction = if area > 0.0 { dot(sum.force(), normal) / area } else { 0.0 };
            let pair = Pair {
                relative: std::array::from_fn(|a| v[a] - moving[a]),
                reduced_mass: m,
                normal: normal.map(|n| -n),
                traction,
            };
            let exchange = meeting.law.exchange(&pair);
            let impulse = std::array::from_fn(|a| exchange.normal[a] + exchange.friction[a]);
            motion.add(impulse.map(|p| p / m));
            given.by_holder.add(x, impulse, moving);
            let slip: [f64; 3] = std::array::from_fn(|a| motion.mean()[a] - moving[a]);
            given.friction -= dot(exchange.friction, slip);
            given.impact -= dot(exchange.normal, slip);
        }
        given
    }
}
