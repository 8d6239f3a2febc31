//! What can go wrong in a run, with particle, patch, task, time and a remedy.
use engine::data::rates::Clock;
use engine::data::warehouse::Warehouse;
use engine::exec::ranks::NetworkError;
use engine::exec::traveler::Traveler;
use engine::graph::error::GraphError;
use engine::schema::Label;
use grid::Level;
use scene::Scene;
use simd::Wide;
use tasks::fault::{INVERTED, MEETS};
use tasks::rigid::state::{RigidState, RigidTrial};
use tasks::{labels, recipes};

/// Why a run could not begin or had to stop.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A fault in a recipe.
    #[error("the task graph is inconsistent: {0}. This is an error in Sinew, please report it")]
    Graph(#[from] GraphError),
    /// Patches that do not fit the level.
    #[error("{0}")]
    Patches(String),
    /// Ranks that cannot go on together.
    #[error("{0}")]
    Network(#[from] NetworkError),
    /// A checkpoint that cannot be read, or does not fit.
    #[error("{0}")]
    Checkpoint(#[from] crate::output::Error),
    /// A loop that did not end.
    #[error(
        "in step {step} a loop until {until} did not end after {rounds} rounds. This is an error in Sinew, please report it"
    )]
    Rounds {
        /// The label that would end it.
        until: &'static str,
        /// Rounds taken.
        rounds: u64,
        /// The step.
        step: u64,
    },
    /// Somebody wants the run to end in the middle of a step.
    #[error("stopped in the middle of step {step}")]
    Stopped {
        /// The step.
        step: u64,
    },
    /// The pool of threads did not start.
    #[error("threads did not start: {0}; try fewer with --threads")]
    Pool(#[from] rayon::ThreadPoolBuildError),
    /// Bodies of one material with different particles per cell.
    #[error(
        "bodies of material {material} have different particles per cell: give each resolution a material of its own"
    )]
    Resolution {
        /// The material.
        material: String,
    },
    /// Two drives of one particle.
    #[error("the drives {} and {} both hold the particle at {position:?} m: let their regions not overlap; one drive may have a table of its motion", names[0], names[1])]
    TwoDrives {
        /// Their names.
        names: [String; 2],
        /// Where the particle is [m].
        position: [f64; 3],
    },
    /// Two forces on one particle.
    #[error("the forces {} and {} both act on the particle at {position:?} m: let their regions, or sides, not overlap", names[0], names[1])]
    TwoForces {
        /// Their names.
        names: [String; 2],
        /// Where the particle is [m].
        position: [f64; 3],
    },
    /// More particles than the machine of a rank can hold.
    #[error(
        "the particles do not fit into memory: rank {rank} has {particles} particles, which take {:.1} GB with their nodes; with all of the \
         {ranks} ranks on its machine that is {:.1} GB, and there are {available:.1} GB. Use larger cells (--set domain.cell=...) or fewer \
         particles a cell, or run it on more machines", gigabytes[0], gigabytes[1]
    )]
    Memory {
        /// The rank.
        rank: usize,
        /// Ranks on its machine, itself included.
        ranks: usize,
        /// Its particles.
        particles: u64,
        /// What they take, and those of all ranks on the machine [GB].
        gigabytes: [f64; 2],
        /// Memory that new work can take there [GB].
        available: f64,
    },
    /// A particle's state is not admissible.
    #[error(
        "{what} of particle {identity} of {material} at ({}) mm, patch {patch}, task {task}, t = {time:.6e} s, step {step}. {remedy}",
        millimeters(position)
    )]
    Particle {
        /// What is wrong, with its value.
        what: String,
        /// The particle.
        identity: u64,
        /// Its material.
        material: String,
        /// Where it is [m].
        position: [f64; 3],
        /// Its patch.
        patch: usize,
        /// The task that found it.
        task: &'static str,
        /// When [s].
        time: f64,
        /// The step.
        step: u64,
        /// What to do.
        remedy: &'static str,
    },
    /// A free rigid body reached the end of the domain.
    #[error(
        "the free rigid body {body} leaves the domain at ({}) mm, t = {time:.6e} s, and its particles are not taken out or put back alone. \
         Enlarge the domain, or end the run before",
        millimeters(position)
    )]
    Escaped {
        /// The body.
        body: String,
        /// Where a particle of it left [m].
        position: [f64; 3],
        /// When [s].
        time: f64,
    },
    /// The motion of a free rigid body was not found.
    #[error(
        "how the free rigid body {body} moves was not found in {rounds} rounds, t = {time:.6e} s, step {step}: its mass, {mass:.3e} kg, may be too \
         small against that of the matter which it rubs. Give it a larger density, less friction, or a bond; or lower run.cfl"
    )]
    Unfound {
        /// The body.
        body: String,
        /// Its mass [kg].
        mass: f64,
        /// Rounds taken.
        rounds: u64,
        /// When [s].
        time: f64,
        /// The step.
        step: u64,
    },
    /// A free rigid body that got into something rigid.
    #[error(
        "the free rigid body {body} meets {other} at ({}) mm, t = {time:.6e} s, step {step}: contact between rigid things is not modelled. Make one of them deformable, keep them apart, or end the run before",
        millimeters(position)
    )]
    Meets {
        /// The body.
        body: String,
        /// Whom it meets.
        other: String,
        /// Where [m].
        position: [f64; 3],
        /// When [s].
        time: f64,
        /// The step.
        step: u64,
    },
    /// A particle left the domain although the scene forbids it.
    #[error(
        "particle {identity} of {material} left the domain at ({}) mm from patch {patch}, task Relocate, t = {time:.6e} s ({others} more in this step). Enlarge the domain, or set run.leaving = \"delete\"",
        millimeters(position)
    )]
    Left {
        /// The particle.
        identity: u64,
        /// Its material.
        material: String,
        /// Where it went [m].
        position: [f64; 3],
        /// The patch that it left.
        patch: usize,
        /// When [s].
        time: f64,
        /// How many others left in the same step.
        others: usize,
    },
    /// The stable step is too small to go on.
    #[error(
        "the time step collapsed to {step:.3e} s at t = {time:.6e} s, step {number}: a signal of {speed:.3e} m/s in {material}. See where it comes from with more frames; lower run.cfl, add run.viscosity, or allow smaller steps with run.smallest-step"
    )]
    Collapsed {
        /// The step [s].
        step: f64,
        /// When [s].
        time: f64,
        /// Steps taken.
        number: u64,
        /// c + |v| [m/s]
        speed: f64,
        /// The material that limits the step.
        material: String,
    },
}

fn millimeters(x: &[f64; 3]) -> String {
    x.map(|x| format!("{:.3}", 1e3 * x)).join(", ")
}

/// The fault that the last step reported, if any: the one with the smallest identity.
pub fn find(scene: &Scene, warehouse: &Warehouse, time: f64, step: u64) -> Option<RunError> {
    let faults =
        (0..scene.materials.len()).map(|m| (m, warehouse.shared.get::<Wide>(labels::Fault::ID, m).0));
    let (material, line) =
        faults.filter(|(_, line)| line[0].is_finite()).min_by(|a, b| a.1[0].total_cmp(&b.1[0]))?;
    let [identity, kind, value, x, y, z, ..] = line;
    if kind == MEETS {
        let other = recipes::obstacles(scene)
            .get(value as usize)
            .map_or_else(String::new, |(who, _)| who.name(scene));
        let body = scene.materials[material].name.clone();
        return Some(RunError::Meets { body, other, position: [x, y, z], time, step });
    }
    let (what, task, remedy) = if kind == INVERTED {
        let remedy = "The material is crushed or torn beyond what its law describes: lower run.cfl, refine, or give the \
                      material a policy (inversion = \"fail\" for tissue)";
        (format!("det F = {value:.3e}"), "Stress", remedy)
    } else {
        let remedy = "Lower run.cfl, or look at the last frames for what tears there";
        (format!("c + |v| = {value}"), "SignalSpeed", remedy)
    };
    let position = [x, y, z];
    let node = warehouse.level.base_node(position, warehouse.materials[material].half_size);
    let patch = warehouse.decomposition.owner(Level::block_of(node)).unwrap_or(0);
    let material = scene.materials[material].name.clone();
    Some(RunError::Particle {
        what,
        identity: identity as u64,
        material,
        position,
        patch,
        task,
        time,
        step,
        remedy,
    })
}

/// The error of a free rigid body that leaves with a particle.
pub fn escaped(scene: &Scene, particle: &Traveler, time: f64) -> RunError {
    RunError::Escaped {
        body: scene.materials[particle.material].name.clone(),
        position: particle.position,
        time,
    }
}

/// The error of a particle that left.
pub fn left(scene: &Scene, first: &Traveler, number: usize, time: f64) -> RunError {
    RunError::Left {
        identity: first.identity,
        material: scene.materials[first.material].name.clone(),
        position: first.position,
        patch: first.patch,
        time,
        others: number - 1,
    }
}

/// The error of a step that is too small.
pub fn collapsed(scene: &Scene, clock: &Clock, number: u64) -> RunError {
    let material = scene.materials.get(clock.limited_by as usize).map_or("no material", |m| m.name.as_str());
    RunError::Collapsed {
        step: clock.tick,
        time: clock.time,
        number,
        speed: clock.speed,
        material: material.to_owned(),
    }
}

/// The error of a free rigid body whose motion was not found.
pub fn unfound(scene: &Scene, warehouse: &Warehouse, rounds: u64, step: u64) -> RunError {
    let shared = &warehouse.shared;
    let body = |m: usize| shared.get::<RigidState>(labels::RigidMotion::ID, m);
    let lost =
        |m: usize| shared.get::<RigidTrial>(labels::RigidTrial::ID, m).found == 0.0 && body(m).free != 0.0;
    let first = (0..scene.materials.len()).find(|&m| lost(m)).unwrap_or(0);
    let time = shared.get::<Clock>(labels::Time::ID, 0).time;
    RunError::Unfound {
        body: scene.materials[first].name.clone(),
        mass: body(first).mass,
        rounds,
        time,
        step,
    }
}
