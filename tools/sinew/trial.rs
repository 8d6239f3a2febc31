//! A few steps of a scene, to tell what the others will take.
use super::fail::Failure;
use scene::Scene;
use simd::Isa;
use sinew::simulation::Simulation;
use std::time::{Duration, Instant};

/// Steps that are tried: at least so many, and for as long.
const TRIAL: (u64, Duration) = (5, Duration::from_secs(1));

/// What was tried.
pub struct Trial {
    /// Number of particles, and their bytes.
    pub particles: (usize, usize),
    /// Number of nodes in active blocks, and their bytes.
    pub nodes: (usize, usize),
    /// Threads that worked.
    pub threads: usize,
    /// Steps after which the run ended, or the trial.
    pub steps: u64,
    /// How fast it goes; none, if the run ended before that was known.
    pub pace: Option<Pace>,
}

/// How fast a run goes.
pub struct Pace {
    /// Simulated time of a step [s].
    pub step: f64,
    /// Ticks of a step.
    pub ticks: f64,
    /// Time on the clock that a step takes [s].
    pub seconds: f64,
    /// Steps of the whole run, if they stay as they are.
    pub all: f64,
    /// Particles moved a second.
    pub updates_per_s: f64,
    /// Steps that were tried.
    pub tried: u64,
}

impl Pace {
    /// Time on the clock of the whole run [s].
    pub fn wall(&self) -> f64 {
        self.all * self.seconds
    }
}

impl Trial {
    /// Takes steps of a scene from its beginning.
    ///
    /// # Errors
    /// If they fail.
    pub fn of(scene: Scene, isa: Isa) -> Result<Self, Failure> {
        let (until, most) = (scene.run.until, scene.run.steps);
        let mut simulation = Simulation::new(scene, isa)?;
        simulation.step()?;
        let (particle_bytes, node_bytes) = simulation.bytes();
        let particles = (simulation.warehouse.particle_count(), particle_bytes);
        let nodes = (simulation.warehouse.node_count(), node_bytes);
        let (start, ticks, first, updates) = state(&simulation);
        let began = Instant::now();
        while simulation.steps() < first + TRIAL.0 || began.elapsed() < TRIAL.1 {
            if !simulation.step()? {
                break;
            }
        }
        let spent = began.elapsed().as_secs_f64();
        let (time, last_tick, steps, updated) = state(&simulation);
        // steps as they are, with all ticks that each takes
        let tried = (steps - first) as f64;
        let step = (time - start) / tried;
        let by_time = (until / step).ceil();
        let pace = (steps > first).then(|| Pace {
            step,
            ticks: (last_tick - ticks) as f64 / tried,
            seconds: spent / tried,
            all: most.map_or(by_time, |most| by_time.min(most as f64)),
            updates_per_s: (updated - updates) as f64 / spent,
            tried: steps - first,
        });
        Ok(Self { particles, nodes, threads: simulation.threads(), steps, pace })
    }
}

/// Time, ticks, steps, and particles moved.
fn state(simulation: &Simulation) -> (f64, u64, u64, u64) {
    (simulation.clock().time, simulation.ticks(), simulation.steps(), simulation.updates())
}
