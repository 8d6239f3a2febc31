//! Runs a bench: ceilings, steps with and without a meter, a counted step.
use super::ceilings::{Ceiling, last_cache};
use super::report::{FLOP_AN_UPDATE, Machine, Report, Rest, Sorting, State, Timing};
use super::rows::{Findings, Metered};
use crate::simulation::{RunError, Simulation, failures};
use engine::data::warehouse::Warehouse;
use engine::exec::meter::{Calibration, Tally, What};
use simd::{Isa, LANES};
use std::time::Instant;

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Steps of a repetition.
    pub steps: usize,
    /// Repetitions.
    pub repeat: usize,
    /// All threads.
    pub threads: usize,
}

/// Why a bench ended early.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The simulation failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The run was over before everything was measured.
    #[error(
        "the run ended at {time_ms:.4} ms, before {needed} steps were measured: begin earlier (--at), measure fewer \
         steps (--steps, --repeat), or let the scene run longer (--set run.until=...)"
    )]
    Ended {
        /// When [ms].
        time_ms: f64,
        /// Steps that a bench takes.
        needed: usize,
    },
    /// Nothing to divide by.
    #[error("a bench takes at least one step, one repetition, one thread and one particle")]
    Nothing,
}

/// Measures steps of `simulation` from where it is; they move it on. Repetitions with and without meter, on one and
/// on all threads, take turns, so that all see the same states and the same neighbors on the machine. `progress` hears what is measured next.
///
/// # Errors
/// A failed run, or one that ends too early.
pub fn bench(
    simulation: &mut Simulation,
    plan: &Plan,
    progress: &mut dyn FnMut(&str),
) -> Result<Report, BenchError> {
    let particles = simulation.warehouse.particle_count();
    if plan.steps.min(plan.repeat).min(plan.threads).min(particles) == 0 {
        return Err(BenchError::Nothing);
    }
    let (isa, state) = (simulation.isa(), state(simulation)?);
    // a bench that would take more steps than there are numbers ends with the run
    let needed = plan.steps.saturating_add(1).saturating_mul(plan.repeat).saturating_mul(4).saturating_add(1);
    let mut bench = Bench { simulation, plan, isa, needed };
    progress("ceilings");
    let ceilings = [1, plan.threads].map(|threads| Ceiling::measure(threads, isa));
    progress("steps on one thread and on all");
    let calibration = Calibration::measure();
    let [mut one, mut all] = bench.steps()?;
    progress("order of summation");
    let order = super::order::order(bench.simulation);
    progress("counted step");
    let counted = bench.counted()?;
    let findings = Findings {
        simulation: bench.simulation,
        calibration: &calibration,
        one: &one.metered,
        all: &all.metered,
        counted: &counted,
        ceiling: &ceilings[0],
    };
    let sweeps = findings.sweeps();
    let mut report = Report {
        machine: machine(isa),
        one_core: ceilings[0],
        all_cores: ceilings[1],
        state,
        one_thread: one.timing(&ceilings[0]),
        all_threads: all.timing(&ceilings[1]),
        sweeps,
        order: Some(order),
        ..Report::default()
    };
    report.speedup = report.all_threads.best_updates_per_s / report.one_thread.best_updates_per_s;
    complete(&mut report, &calibration, [&one.metered, &all.metered]);
    Ok(report)
}

struct Bench<'a> {
    simulation: &'a mut Simulation,
    plan: &'a Plan,
    isa: Isa,
    needed: usize,
}

impl Bench<'_> {
    fn step(&mut self) -> Result<(), BenchError> {
        if self.simulation.step()? {
            return Ok(());
        }
        Err(BenchError::Ended { time_ms: 1e3 * self.simulation.clock().time, needed: self.needed })
    }

    /// Seconds of one repetition, and its particle updates. One step more warms the scratch up.
    fn repetition(&mut self, threads: usize, metered: bool) -> Result<(f64, u64), BenchError> {
        self.simulation.go_on_with(threads, self.isa)?;
        self.step()?;
        self.simulation.set_meter(metered);
        let (began, before) = (Instant::now(), self.simulation.updates());
        for _ in 0..self.plan.steps {
            self.step()?;
        }
        Ok((began.elapsed().as_secs_f64(), self.simulation.updates() - before))
    }

    /// Whole steps and metered ones, on one thread and on all, in turns.
    fn steps(&mut self) -> Result<[Steps; 2], BenchError> {
        let mut steps = [1, self.plan.threads].map(Steps::new);
        for _ in 0..self.plan.repeat {
            for own in &mut steps {
                let (seconds, updates) = self.repetition(own.threads, false)?;
                own.rates.push(updates as f64 / seconds);
                let wall_ns = 1e9 * self.repetition(own.threads, true)?.0;
                if own.metered.steps == 0 || wall_ns < own.metered.wall_ns {
                    let (tally, steps) = (self.simulation.take_meter(), self.plan.steps);
                    own.metered = Metered { tally, steps, threads: own.threads, wall_ns };
                }
            }
        }
        Ok(steps)
    }

    /// One step on vectors that count.
    fn counted(&mut self) -> Result<Tally, BenchError> {
        self.simulation.go_on_with(self.plan.threads, Isa::COUNTING)?;
        self.simulation.set_meter(true);
        self.step()?;
        let tally = self.simulation.take_meter();
        self.simulation.go_on_with(self.plan.threads, self.isa)?;
        Ok(tally)
    }
}

/// What steps on some threads take.
struct Steps {
    threads: usize,
    /// Particle updates of each repetition [1/s].
    rates: Vec<f64>,
    /// The quickest metered repetition.
    metered: Metered,
}

impl Steps {
    fn new(threads: usize) -> Self {
        Self { threads, rates: Vec::new(), metered: Metered::default() }
    }

    fn timing(&mut self, ceiling: &Ceiling) -> Timing {
        self.rates.sort_by(f64::total_cmp);
        let best = self.rates.last().copied().unwrap_or_default();
        let median = self.rates.get(self.rates.len() / 2).copied().unwrap_or_default();
        Timing {
            threads: self.threads,
            best_updates_per_s: best,
            median_updates_per_s: median,
            best_update_ns: 1e9 / best,
            fma_share: best * FLOP_AN_UPDATE / (1e9 * ceiling.fma_gflop_per_s),
        }
    }
}

/// Sorting, and what is left.
fn complete(report: &mut Report, calibration: &Calibration, [one, all]: [&Metered; 2]) {
    let particles = report.state.particles as f64;
    let of_all = |metered: &Metered, what| metered.ns(calibration, what) / particles;
    let whole = |metered: &Metered| metered.step_ns(calibration) / particles;
    let (relocation_ns, activation_ns) = (of_all(one, What::Relocation), of_all(one, What::Activation));
    let share = (relocation_ns + activation_ns) / whole(one);
    report.sorting = Sorting { relocation_ns, activation_ns, share };
    let sum = |ns: fn(&super::report::Row) -> f64| {
        report.sweeps.iter().map(|s| ns(&s.total) * s.particles as f64 / particles).sum::<f64>()
    };
    let left = whole(one) - sum(|row| row.one_thread_ns) - relocation_ns - activation_ns;
    let left_all = whole(all)
        - sum(|row| row.all_threads_ns)
        - of_all(all, What::Relocation)
        - of_all(all, What::Activation);
    report.rest = Rest { one_thread_ns: left, all_threads_ns: left_all, share: left / whole(one) };
    report.meter = one.wall_ns / one.steps as f64 / particles / report.one_thread.best_update_ns;
}

fn machine(isa: Isa) -> Machine {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    Machine {
        processor: model.map_or("unknown", |(_, name)| name.trim()).to_owned(),
        isa: isa.name().to_owned(),
        last_cache_bytes: last_cache().unwrap_or(0),
    }
}

fn state(simulation: &mut Simulation) -> Result<State, BenchError> {
    let report = simulation.report().map_err(RunError::from)?;
    let failed: u64 = failures::STATES.iter().map(|state| failures::total(&report, state)).sum();
    let warehouse: &Warehouse = &simulation.warehouse;
    let particles = warehouse.particle_count();
    let (particle_bytes, node_bytes) = simulation.bytes();
    let near: usize = warehouse.blocks().filter(|(_, block)| block.near).map(|(_, block)| block.count).sum();
    let tiles: usize = warehouse.blocks().map(|(_, block)| block.tiles()).sum();
    Ok(State {
        scene: simulation.scene.name.clone(),
        time_ms: 1e3 * simulation.clock().time,
        steps_before: simulation.steps(),
        particles,
        failed: failed as f64 / particles as f64,
        near: near as f64 / particles as f64,
        lanes: particles as f64 / (LANES * tiles).max(1) as f64,
        blocks: warehouse.blocks().count(),
        patches: warehouse.decomposition.patches.len(),
        data_mb: (particle_bytes + node_bytes) as f64 / 1e6,
    })
}
