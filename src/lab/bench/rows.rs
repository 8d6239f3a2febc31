//! The table of sweeps and tasks, from metered steps, counted operations and declared bytes.
use super::ceilings::Ceiling;
use super::report::{Row, Sweep, Vectors};
use super::traffic::Traffic;
use crate::simulation::Simulation;
use engine::exec::meter::{Calibration, StagePart, Tally, What};
use engine::graph::build::TaskGraph;
use engine::graph::phase::Stage;
use engine::graph::task::Domain;
use simd::LANES;
use simd::counting::Counts;

/// Metered steps.
#[derive(Clone, Debug, Default)]
pub struct Metered {
    /// Costs, summed over workers.
    pub tally: Tally,
    /// Steps.
    pub steps: usize,
    /// Threads.
    pub threads: usize,
    /// Time on the clock [ns].
    pub wall_ns: f64,
}

impl Metered {
    /// Core time of one step, with waiting and without the meter [ns].
    pub fn step_ns(&self, calibration: &Calibration) -> f64 {
        (self.wall_ns * self.threads as f64 - calibration.meter_ns(&self.tally)) / self.steps as f64
    }

    /// Core time of `what` in one step [ns].
    pub fn ns(&self, calibration: &Calibration, what: What) -> f64 {
        calibration.ns(self.tally.cost(what)) / self.steps as f64
    }
}

/// What the rows are made of.
pub struct Findings<'a> {
    /// The state, for particles and bytes.
    pub simulation: &'a Simulation,
    /// Worth of a tick.
    pub calibration: &'a Calibration,
    /// Metered on one thread.
    pub one: &'a Metered,
    /// Metered on all threads.
    pub all: &'a Metered,
    /// One step on the counting instruction set.
    pub counted: &'a Tally,
    /// What one core can do.
    pub ceiling: &'a Ceiling,
}

impl Findings<'_> {
    /// All sweeps, in the order of the step.
    pub fn sweeps(&self) -> Vec<Sweep> {
        let graph = self.simulation.graph();
        let stages = graph.phases.iter().flat_map(|phase| &phase.stages);
        let mut sweeps: Vec<Sweep> = Vec::new();
        for stage in stages {
            let mut sweep = self.sweep(graph, stage);
            number(&mut sweep.name, sweeps.iter().map(|s| &*s.name));
            sweeps.push(sweep);
        }
        sweeps
    }

    fn sweep(&self, graph: &TaskGraph, stage: &Stage) -> Sweep {
        let blocks = self.simulation.warehouse.blocks();
        let particles =
            blocks.filter(|(m, _)| stage.material.is_none_or(|own| own == *m)).map(|(_, b)| b.count).sum();
        let traffic = Traffic::of(graph, &self.simulation.warehouse, stage);
        let mut rows: Vec<Row> = Vec::new();
        for what in contents(stage) {
            let mut name = match what {
                What::Entry(entry) => graph.recipe.entries[entry].task.declaration().name.to_owned(),
                What::Part(_, part) => part.name().to_owned(),
                _ => continue,
            };
            number(&mut name, rows.iter().map(|row| &*row.name));
            rows.push(self.row(name, what, particles, &traffic));
        }
        let mut total = Row::default();
        rows.iter().for_each(|row| add(&mut total, row));
        rate(&mut total, self.ceiling);
        Sweep { name: name(graph, stage), particles, total, rows }
    }

    fn row(&self, name: String, what: What, particles: usize, traffic: &Traffic) -> Row {
        let updates = particles.max(1) as f64;
        let ns = |metered: &Metered| metered.ns(self.calibration, what);
        let mut row = Row {
            name,
            one_thread_ns: ns(self.one) / updates,
            all_threads_ns: ns(self.all) / updates,
            share: ns(self.one) / self.one.step_ns(self.calibration),
            vectors: vectors(self.counted.cost(what).counts, updates),
            bytes: traffic.bytes(what) as f64 / updates,
            ..Row::default()
        };
        rate(&mut row, self.ceiling);
        row
    }
}

/// What a stage consists of: work of the engine, and tasks.
fn contents(stage: &Stage) -> Vec<What> {
    let has = |part: StagePart| match (part, stage.domain) {
        (_, Domain::Once) => false,
        (StagePart::Setup, _) => true,
        (StagePart::SumPartials, Domain::Nodes) => !stage.sums.is_empty(),
        (StagePart::Zeroing, Domain::Particles) => !stage.adds.is_empty(),
        (StagePart::LoadRegion, Domain::Particles) => !stage.reads.is_empty(),
        _ => false,
    };
    let parts =
        StagePart::ALL.into_iter().filter(|&part| has(part)).map(|part| What::Part(stage.entries[0], part));
    parts.chain(stage.entries.iter().map(|&entry| What::Entry(entry))).collect()
}

/// What a stage does, in a word: names that outlive changes of the recipe.
fn name(graph: &TaskGraph, stage: &Stage) -> String {
    let does = match stage.domain {
        Domain::Nodes => "nodes",
        Domain::Once => "once",
        _ if !stage.reads.is_empty() => "G2P",
        _ if !stage.adds.is_empty() => "P2G",
        _ => "particles",
    };
    stage.material.map_or(does.to_owned(), |m| format!("{does} {}", graph.recipe.materials[m]))
}

/// Makes `name` differ from those before it.
fn number<'a>(name: &mut String, before: impl Iterator<Item = &'a str>) {
    let same = before.filter(|other| other.split(" #").next() == Some(&**name)).count();
    if same > 0 {
        *name = format!("{name} #{}", same + 1);
    }
}

fn vectors(counts: Counts, updates: f64) -> Vectors {
    let each = |count: u64| count as f64 / updates;
    Vectors {
        fused: each(counts.fused),
        simple: each(counts.simple),
        slow: each(counts.slow),
        other: each(counts.other),
        loads: each(counts.loads),
        stores: each(counts.stores),
    }
}

fn add(total: &mut Row, row: &Row) {
    total.one_thread_ns += row.one_thread_ns;
    total.all_threads_ns += row.all_threads_ns;
    total.share += row.share;
    total.bytes += row.bytes;
    let (sum, more) = (&mut total.vectors, &row.vectors);
    sum.fused += more.fused;
    sum.simple += more.simple;
    sum.slow += more.slow;
    sum.other += more.other;
    sum.loads += more.loads;
    sum.stores += more.stores;
}

/// Rates and shares from time, operations and bytes.
fn rate(row: &mut Row, ceiling: &Ceiling) {
    let per_ns = |amount: f64| if row.one_thread_ns > 0.0 { amount / row.one_thread_ns } else { 0.0 };
    let v = &row.vectors;
    row.flop = LANES as f64 * (2.0 * v.fused + v.simple + v.slow);
    row.updates_per_s = per_ns(1e9);
    row.gflop_per_s = per_ns(row.flop);
    row.fma_share = row.gflop_per_s / ceiling.fma_gflop_per_s;
    row.slot_share = per_ns(2.0 * LANES as f64 * (v.fused + v.simple)) / ceiling.fma_gflop_per_s;
    row.gb_per_s = per_ns(row.bytes);
    row.copy_share = row.gb_per_s / ceiling.traffic_gb_per_s;
}
