//! `summary.json`: what a run did, in one page.
use super::create::write_whole;
use super::error::{Error, Result};
use super::plain;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// It reached the end that the scene or the command line asked for.
    Completed,
    /// It was stopped from outside; the last checkpoint is whole.
    Interrupted,
    /// An error ended it: see [`Summary::error`].
    #[default]
    Failed,
}

/// A run in numbers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How it ended.
    pub status: Status,
    /// Why it failed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Name of the scene.
    pub scene: String,
    /// Steps taken.
    pub steps: u64,
    /// Simulated time [s].
    pub time_s: f64,
    /// Seconds on the clock.
    pub wall_s: f64,
    /// Where the seconds since the last start went, with the most first.
    #[serde(default)]
    pub timing: Vec<Timing>,
    /// Particles at the end.
    pub particles: u64,
    /// Particle updates a second.
    pub updates_per_s: f64,
    /// Particle updates a second and core.
    pub updates_per_s_per_core: f64,
    /// MPI ranks.
    pub ranks: usize,
    /// Threads a rank.
    pub threads: usize,
    /// Patches along each axis.
    pub patches: [usize; 3],
    /// Instruction set that ran, for example `avx512`.
    pub isa: String,
    /// Of all particle state in the order of identities, hexadecimal: see [`hex`].
    pub state_hash: String,
    /// Mass of all particles [kg].
    pub mass_kg: f64,
    /// Linear momentum [kg m/s].
    pub momentum_kg_m_s: [f64; 3],
    /// Angular momentum about the origin [kg m²/s].
    pub angular_momentum_kg_m2_s: [f64; 3],
    /// Angular momentum about the origin that the transfer between particles and nodes has taken [kg m²/s].
    #[serde(default)]
    pub angular_momentum_lost_in_transfer_kg_m2_s: [f64; 3],
    /// Energy by part [J].
    pub energy_j: Energy,
    /// Failed particles over particles.
    pub failed_fraction: Failed,
    /// The first failure of each kind, if there was one: `matrix`, `fiber`.
    pub first_failure: BTreeMap<String, FirstFailure>,
    /// Particles that left the domain and were taken out.
    pub deleted_particles: u64,
    /// Particles whose volume turned negative and that the scene lets go on as failed.
    pub crushed_particles: u64,
    /// What each face, drive, force, tool and contact has given, by its name in `history.csv`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub reactions: BTreeMap<String, Reaction>,
    /// By name of the material.
    pub materials: BTreeMap<String, MaterialSummary>,
    /// What else there is to say.
    #[serde(flatten)]
    pub more: BTreeMap<String, serde_json::Value>,
}

/// What a part of the time went to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// The tasks of a stage, or what else it was.
    pub what: String,
    /// Of all time, from 0 to 1.
    pub share: f64,
    /// Seconds: the mean over ranks.
    pub mean_s: f64,
    /// The least of a rank [s].
    pub least_s: f64,
    /// The most of a rank [s].
    pub most_s: f64,
}

/// Energy by part [J].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Of motion.
    pub kinetic: f64,
    /// Stored elastically.
    pub strain: f64,
    /// Dissipated by yielding.
    pub plastic: f64,
    /// Released by failure.
    pub fracture: f64,
    /// Dissipated by contact friction.
    pub friction: f64,
    /// Lost where surfaces meet: at a node they do not bounce.
    pub impact: f64,
    /// Lost in the transfer between particles and nodes.
    pub transfer: f64,
    /// What internal forces do to velocities in half a step, by which these are behind positions: now, less that at the start.
    #[serde(default)]
    pub half_step: f64,
    /// Dissipated by artificial viscosity.
    pub viscosity: f64,
    /// Work of boundaries, drives and gravity on the matter.
    pub boundary_work: f64,
    /// What the balance does not explain: the error of the time step.
    pub residual: f64,
    /// Turned over: the most that there was, and Σ |work| of what acts from outside.
    #[serde(default)]
    pub turnover: f64,
}

/// What something has given to the matter, or the first of two materials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reaction {
    /// Impulse [N s].
    pub impulse_n_s: [f64; 3],
    /// Torque impulse about the origin [N m s].
    pub torque_impulse_n_m_s: [f64; 3],
    /// Work [J]; 0 for contacts, whose losses are in `energy_j`.
    pub work_j: f64,
}

/// Fractions of particles by kind of failure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Failed {
    /// Matrix only.
    pub matrix: f64,
    /// Fiber only.
    pub fiber: f64,
    /// Both.
    pub total: f64,
    /// Any.
    pub any: f64,
}

/// Where and when something happened first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FirstFailure {
    /// When [s].
    pub time_s: f64,
    /// Where [m].
    pub position_m: [f64; 3],
    /// Identity of the particle.
    pub particle: u64,
}

/// One material at the end.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MaterialSummary {
    /// Particles.
    pub particles: u64,
    /// Mass [kg].
    pub mass_kg: f64,
    /// Momentum over mass [m/s].
    pub mean_velocity_m_s: [f64; 3],
    /// Center of mass [m].
    pub center_of_mass_m: [f64; 3],
    /// Lower and upper corner of the box around its particles [m], if there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extent_m: Option<[[f64; 3]; 2]>,
    /// How far a rigid body has gone [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displacement_m: Option<[f64; 3]>,
    /// Angular velocity of a rigid body [rad/s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angular_velocity_rad_s: Option<[f64; 3]>,
    /// The largest of what its law keeps, such as `plastic_strain`, over its particles.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub largest: BTreeMap<String, f64>,
    /// Failed particles of this material over its particles, if its law knows failure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub failed_fraction: Option<Failed>,
    /// What else there is to say.
    #[serde(flatten)]
    pub more: BTreeMap<String, serde_json::Value>,
}

/// A hash as `summary.json` spells it: 16 hexadecimal digits.
pub fn hex(hash: u64) -> String {
    format!("{hash:016x}")
}

impl Summary {
    /// Writes the file. Whoever looks sees the old file or the new one, never half of one.
    /// Numbers that JSON cannot say (NaN, infinity) become null and do not read back: leave them out.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = serde_json::to_string_pretty(self).map_err(|error| wrong(path, &error))?;
        write_whole(path, (text + "\n").as_bytes())
    }

    /// Reads the file back.
    ///
    /// # Errors
    /// If it is missing, or not a summary.
    pub fn read(path: &Path) -> Result<Self> {
        serde_json::from_str(&plain::read(path)?).map_err(|error| wrong(path, &error))
    }
}

fn wrong(path: &Path, error: &serde_json::Error) -> Error {
    Error::Content { path: path.into(), problem: format!("not a summary of a run ({error})") }
}
