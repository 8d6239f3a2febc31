//! What a bench finds, as numbers that can be kept and compared.
//!
//! The end of a name is its unit, and tells [`super::compare`](super::compare()) how it scales with the machine: `_ns` are
//! times, `_per_s` are rates, the rest does not depend on it.
use super::ceilings::Ceiling;
use serde::{Deserialize, Serialize};

/// Everything a bench finds.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Where it ran.
    pub machine: Machine,
    /// What one core can do.
    pub one_core: Ceiling,
    /// What all cores can do at once.
    pub all_cores: Ceiling,
    /// What was stepped.
    pub state: State,
    /// Steps as they are, without a meter, on one thread.
    pub one_thread: Timing,
    /// The same on all threads.
    pub all_threads: Timing,
    /// Rate on all threads over the rate on one.
    pub speedup: f64,
    /// Metered steps on one thread: time with the meter over time without.
    pub meter: f64,
    /// The sweeps of a step, in its order.
    pub sweeps: Vec<Sweep>,
    /// Particles moved to other blocks.
    pub sorting: Sorting,
    /// What is neither a sweep nor sorting: reductions, checks, accounts, and threads that wait. For each particle of all
    /// materials, in core time.
    pub rest: Rest,
    /// Cost of summing node contributions in a fixed order, if it was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order: Option<Order>,
}

/// Where a bench ran.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's name, if the system tells.
    pub processor: String,
    /// Instruction set of the tasks.
    pub isa: String,
    /// Bytes of the last cache, 0: unknown.
    pub last_cache_bytes: usize,
}

/// What was stepped.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Name of the scene.
    pub scene: String,
    /// Simulated time at which the bench began [ms].
    pub time_ms: f64,
    /// Steps taken before.
    pub steps_before: u64,
    /// Particles of all materials.
    pub particles: usize,
    /// Particles that failed, over particles.
    pub failed: f64,
    /// Particles in blocks near another material, over particles.
    pub near: f64,
    /// Lanes that hold a particle, over lanes of tiles in use.
    pub lanes: f64,
    /// Occupied blocks of all materials.
    pub blocks: usize,
    /// Patches.
    pub patches: usize,
    /// Particle columns, partial sums and node lines [MB].
    pub data_mb: f64,
}

/// Whole steps on some threads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timing {
    /// Threads.
    pub threads: usize,
    /// Particle updates of the best repetition [1/s].
    pub best_updates_per_s: f64,
    /// Of the median repetition [1/s].
    pub median_updates_per_s: f64,
    /// Time on the clock for each particle update, in the best repetition [ns].
    pub best_update_ns: f64,
    /// Of the ceiling of multiply-adds of as many cores, with [`FLOP_AN_UPDATE`]: to compare scenes, codes and machines by the same count.
    #[serde(default)]
    pub fma_share: f64,
}

/// What an update of a particle counts in shares of the ceiling: about what it takes in double precision with 27 nodes: weights and sums of
/// nodes 760, velocities and gradients 810, F and the stress of tissue that fails 400. What tasks really do is in their rows.
pub const FLOP_AN_UPDATE: f64 = 2000.0;

/// A fused stage of one material, or the node stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sweep {
    /// `P2G`, `G2P` or `nodes`, and the material.
    pub name: String,
    /// Particles that share its cost: of the material, or all.
    pub particles: usize,
    /// The sum of its rows.
    pub total: Row,
    /// Its tasks, and, in parentheses, what the engine does for it.
    pub rows: Vec<Row>,
}

/// The cost of something, for each update of one of the sweep's particles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Task, or, in parentheses, work of the engine.
    pub name: String,
    /// Core time on one thread [ns].
    pub one_thread_ns: f64,
    /// Core time on all threads [ns].
    pub all_threads_ns: f64,
    /// Of the whole metered step on one thread.
    pub share: f64,
    /// Updates on one thread [1/s].
    pub updates_per_s: f64,
    /// Vector operations.
    pub vectors: Vectors,
    /// Floating-point operations in vectors, idle lanes as well; a fused multiply-add is two. Scalar code is not counted.
    pub flop: f64,
    /// Floating-point operations on one thread [GFLOP/s].
    pub gflop_per_s: f64,
    /// Of the ceiling of multiply-adds of one core.
    pub fma_share: f64,
    /// Vector multiply-adds, additions and multiplications over the ceiling: an addition takes the place of a
    /// multiply-add.
    pub slot_share: f64,
    /// Bytes that memory moves, by the declarations.
    pub bytes: f64,
    /// Bytes on one thread [GB/s].
    pub gb_per_s: f64,
    /// Of the copy's traffic on one core.
    pub copy_share: f64,
}

/// Vector operations for each particle: eight particles share one where lanes are particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vectors {
    /// Multiply-adds.
    pub fused: f64,
    /// Additions, subtractions, multiplications.
    pub simple: f64,
    /// Divisions and roots.
    pub slow: f64,
    /// Selections, comparisons, shuffles.
    pub other: f64,
    /// Lines loaded.
    pub loads: f64,
    /// Lines stored.
    pub stores: f64,
}

/// Particles moved to other blocks, for each particle of all materials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sorting {
    /// Finding and moving particles, on one thread [ns].
    pub relocation_ns: f64,
    /// Rebuilding the lists of blocks and neighbors, where blocks became occupied [ns].
    pub activation_ns: f64,
    /// Of the whole metered step on one thread.
    pub share: f64,
}

/// What is left of a metered step, for each particle of all materials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Rest {
    /// On one thread [ns].
    pub one_thread_ns: f64,
    /// On all threads, their waiting included [ns].
    pub all_threads_ns: f64,
    /// Of the whole metered step on one thread.
    pub share: f64,
}

/// Summing in a fixed order against summing in any, for each particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Order {
    /// In the fixed order [ns].
    pub fixed_ns: f64,
    /// In any order [ns].
    pub free_ns: f64,
}
