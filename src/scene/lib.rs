//! What is simulated: a validated scene, everything in SI units, names resolved to indices, geometry ready to sample.
//! `sinew::input` makes it from TOML.
mod material;
pub mod sampling;
pub mod shown;

use geometry::Solid;
pub use material::{Behavior, Material, RigidMotion};
pub use physics::contact::Contact;
use physics::faces::AnyFaceCondition;
pub use physics::motion::{Course, Motion};
use physics::quantities::Shown;
pub use physics::solid as geometry;
pub use physics::table::Table;
pub use physics::viscosity::Viscosity;
use shown::Probe;
use std::collections::BTreeMap;

/// The most materials of a scene: frames name each by 16 bits.
pub const MOST_MATERIALS: usize = 1 << 16;

impl Scene {
    /// What a material fills at the start: the solids of all its bodies.
    pub fn shape(&self, material: usize) -> Solid {
        let mut solids: Vec<Solid> = self.bodies_of(material).map(|body| body.solid.clone()).collect();
        match solids.len() {
            1 => solids.remove(0),
            _ => Solid::Union(solids),
        }
    }

    /// Whether somebody wants to know where particles were at the start.
    pub fn shows_start(&self) -> bool {
        let frames = self.output.fields.iter().filter(|_| self.output.frames > 0);
        frames.chain(self.probes.iter().map(|probe| &probe.shown)).any(|shown| shown.from_start)
    }

    /// The materials that deform.
    pub fn deformable(&self) -> impl Iterator<Item = usize> {
        (0..self.materials.len()).filter(|&m| !self.materials[m].is_rigid())
    }

    /// Pairs of materials with bodies, ascending, of which one at least deforms.
    pub fn pairs(&self) -> Vec<[usize; 2]> {
        let used: Vec<usize> =
            (0..self.materials.len()).filter(|&m| self.bodies_of(m).next().is_some()).collect();
        let pairs = used.iter().enumerate().flat_map(|(i, &b)| used[..i].iter().map(move |&a| [a, b]));
        pairs.filter(|pair| !pair.iter().all(|&m| self.materials[m].is_rigid())).collect()
    }

    /// Whether two materials, ascending, have a contact.
    pub fn meet(&self, pair: &[usize; 2]) -> bool {
        self.contacts.iter().any(|contact| contact.between == *pair)
    }

    /// The bodies of a material.
    pub fn bodies_of(&self, material: usize) -> impl Iterator<Item = &Body> {
        self.bodies.iter().filter(move |body| body.material == material)
    }
}

/// What to simulate.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The name of the scene's folder, or the file's stem.
    pub name: String,
    /// One line for people.
    pub title: String,
    /// Where.
    pub domain: Domain,
    /// What things are made of; each has a velocity field of its own. Indices into this list name materials.
    pub materials: Vec<Material>,
    /// Pieces of matter.
    pub bodies: Vec<Body>,
    /// Which materials touch, and how. Pairs that are not listed pass through each other.
    pub contacts: Vec<Contact>,
    /// Conditions on the faces x−, x+, y−, y+, z−, z+ of the domain.
    pub faces: [AnyFaceCondition; 6],
    /// Regions of particles with a prescribed velocity.
    pub drives: Vec<Drive>,
    /// What acts on all matter.
    pub loads: Loads,
    /// What acts on surfaces and parts of bodies.
    pub forces: Vec<Force>,
    /// What to follow in time.
    pub probes: Vec<Probe>,
    /// Numerics.
    pub run: Run,
    /// What to write.
    pub output: Output,
    /// Scene lines that asked for things, by dotted key such as `run.viscosity` or `contact.0.friction`: 1-based.
    pub lines: BTreeMap<String, usize>,
    /// The resolved scene as TOML in SI units, defaults filled in, overrides applied (written beside the results).
    pub resolved: String,
}

/// How many patches the domain is cut into.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Patches {
    /// About so many, where the particles are.
    Total(usize),
    /// So many along x, y and z.
    Grid([usize; 3]),
}

/// A box of cubic cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Domain {
    /// Lower corner [m].
    pub lower: [f64; 3],
    /// Cells along each axis.
    pub cells: [usize; 3],
    /// Edge of a cell [m].
    pub cell: f64,
}

/// A piece of matter, filled with particles on the regular lattice of the cells.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name in messages.
    pub name: String,
    /// Index of its material.
    pub material: usize,
    /// Its shape.
    pub solid: Solid,
    /// Particles along each axis of a cell.
    pub particles_per_cell: [usize; 3],
    /// Initial velocity [m/s].
    pub velocity: [f64; 3],
    /// Initial angular velocity about its center of mass [rad/s].
    pub angular_velocity: [f64; 3],
    /// How far it is stretched at the start along x, y and z: its shape is what it fills then.
    pub stretch: [f64; 3],
    /// Direction of the fibers at the start.
    pub fibers: FiberField,
}

/// Direction of the fibers in the undeformed body, as a field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FiberField {
    /// The same unit vector everywhere.
    Uniform([f64; 3]),
    /// `start` at the plane `axis · x = from`, turned about `axis` by `angle` (right-handed, linear in between)
    /// at the plane `axis · x = to`.
    Turning {
        /// Unit vector at `from`, perpendicular to `axis`.
        start: [f64; 3],
        /// Unit vector through the thickness.
        axis: [f64; 3],
        /// Offset of the first plane [m].
        from: f64,
        /// Offset of the second plane [m].
        to: f64,
        /// Turn between the planes [rad].
        angle: f64,
    },
}

/// A region whose matter moves as prescribed.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Its name in files.
    pub name: String,
    /// Index of the material whose particles are driven.
    pub material: usize,
    /// Which of them.
    pub region: Region,
    /// How they move.
    pub motion: Motion,
    /// Along which axes: they are free along the others.
    pub components: [bool; 3],
    /// When they are released [s].
    pub until: f64,
}

/// A force on a part of a body or its surface.
#[derive(Clone, Debug)]
pub struct Force {
    /// Its name in files.
    pub name: String,
    /// Index of the material on which it acts.
    pub material: usize,
    /// On which of its particles.
    pub region: Region,
    /// What acts.
    pub kind: ForceKind,
    /// On which faces of particles on the surface: x−, x+, y−, y+, z−, z+ at the start.
    pub sides: [bool; 6],
}

/// What a force is.
#[derive(Clone, Debug, PartialEq)]
pub enum ForceKind {
    /// [N] in time, spread over all particles of the region.
    Total(Table),
    /// [Pa] in time, per area at the start, in a direction that stays.
    Traction(Table),
    /// [Pa] in time (along x), against the surface as it is then.
    Pressure(Table),
    /// [Pa] in time (along x), against the surface as it was at the start.
    DeadPressure(Table),
}

/// A part of a material's particles.
#[derive(Clone, Debug)]
pub enum Region {
    /// All.
    All,
    /// Those of a body: an index into the list of bodies.
    Body(usize),
    /// Those that lie in a solid at the start.
    Solid(Solid),
}

impl Region {
    /// Whether a particle of the body that lies at `x` [m] at the start is of it.
    pub fn contains(&self, body: usize, x: [f64; 3]) -> bool {
        match self {
            Region::All => true,
            Region::Body(of) => *of == body,
            Region::Solid(solid) => solid.contains(x),
        }
    }
}

/// What acts on all matter.
#[derive(Clone, Debug, PartialEq)]
pub struct Loads {
    /// Acceleration [m/s²] in time.
    pub gravity: Table,
    /// Mass-proportional damping a = −αv, α [1/s].
    pub damping: f64,
    /// Local damping: a share of what is out of balance.
    pub local_damping: f64,
}

impl Loads {
    /// Whether there are any.
    pub fn acts(&self) -> bool {
        self.act_on_all() || self.local_damping != 0.0
    }

    /// Whether gravity or damping by mass do.
    pub fn act_on_all(&self) -> bool {
        self.gravity.acts() || self.damping != 0.0
    }
}

/// Shape function family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeFunction {
    /// Trilinear hats.
    Linear,
    /// Uniform GIMP.
    Gimp,
}

/// Who takes which time steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rates {
    /// All materials take the step that the fastest one needs.
    Common,
    /// Each material takes steps of its own.
    PerMaterial {
        /// The most steps of the fastest material in one of the slowest.
        most: u32,
    },
}

/// What happens to a particle that leaves the domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaving {
    /// The run stops with an error.
    Error,
    /// It is taken out and counted.
    Delete,
    /// It is put back inside, with its velocity mirrored at the face, and counted.
    Reflect,
}

/// Numerics.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// End of the simulated time [s].
    pub until: f64,
    /// Most steps to take, if limited.
    pub steps: Option<u64>,
    /// CFL number.
    pub cfl: f64,
    /// Who takes which steps.
    pub rates: Rates,
    /// A step below this [s] ends the run with an error.
    pub smallest_step: f64,
    /// Shape functions.
    pub shape: ShapeFunction,
    /// Share of PIC in a step: 0: FLIP, 1: PIC.
    pub pic: f64,
    /// Rate of PIC [1/s].
    pub pic_rate: f64,
    /// Artificial viscosity, if any.
    pub viscosity: Option<Viscosity>,
    /// What happens to a particle that leaves the domain.
    pub leaving: Leaving,
    /// Steps between two attempts to balance the load of ranks (0: none).
    pub rebalance_every: u64,
    /// Patches along each axis; `None`: chosen from the number of threads.
    pub patches: Option<Patches>,
    /// Threads; `None`: all cores.
    pub threads: Option<usize>,
}

/// What to write.
#[derive(Clone, Debug, PartialEq)]
pub struct Output {
    /// Frames of `particles.vtkhdf` over the whole run, besides the first (0: none at all).
    pub frames: usize,
    /// What they show of each particle.
    pub fields: Vec<Shown>,
    /// A row of `history.csv` every so many steps.
    pub history_every: u64,
    /// When there is more to see, or less.
    pub periods: Vec<Period>,
    /// When to write checkpoints.
    pub checkpoint: Checkpoint,
    /// For the wound table, if the scene is a shot through a slab.
    pub wound: Option<Wound>,
}

impl Output {
    /// How many frames a run until a time [s] writes, if steps are short against the time between them; a million at most.
    pub fn frames_until(&self, until: f64) -> usize {
        if self.frames == 0 {
            return 0;
        }
        let all = |from: f64, to: f64, every: f64| {
            let count = (((to - from) / every * (1.0 + 1e-9)).floor() + 1.0).min(1e6) as usize;
            (0..count).map(move |n| from + n as f64 * every)
        };
        let periods = self.periods.iter().filter(|period| period.from < until);
        let own =
            periods.filter_map(|period| Some(all(period.from, period.to.min(until), period.frames_every?)));
        let mut times: Vec<f64> = all(0.0, until, until / self.frames as f64).chain(own.flatten()).collect();
        times.sort_by(f64::total_cmp);
        // one that is due twice is written once
        times.dedup_by(|a, b| *a - *b <= 1e-9 * until);
        times.len().min(1_000_000)
    }
}

/// A part of the simulated time in which output has intervals of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Period {
    /// From when on [s].
    pub from: f64,
    /// Until when [s].
    pub to: f64,
    /// Simulated time between frames [s], besides those of the whole run.
    pub frames_every: Option<f64>,
    /// Steps between rows of the history, instead of those of the whole run.
    pub history_every: Option<u64>,
}

/// When to write checkpoints: whenever one of these says so.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checkpoint {
    /// Every so many steps.
    pub steps: Option<u64>,
    /// Every so much simulated time [s].
    pub time: Option<f64>,
    /// Every so much time on the clock of the machine [s]; 0: never.
    pub wall: f64,
    /// At the end of a completed run, too.
    pub at_end: bool,
    /// How many to keep.
    pub kept: usize,
}

/// What `sinew wound` measures.
#[derive(Clone, Debug, PartialEq)]
pub struct Wound {
    /// Material of the slab.
    pub target: usize,
    /// Material of the projectile.
    pub projectile: usize,
    /// Axis of the shot: 0, 1, 2.
    pub axis: usize,
    /// +1 if the shot goes up the axis, −1 if down.
    pub direction: f64,
    /// Slab surface where it enters, and where it leaves [m].
    pub surfaces: [f64; 2],
    /// Point of entry in the two other axes, in ascending order of axes [m].
    pub center: [f64; 2],
}
