//! A run: a scene becomes particles and graphs, steps are taken, faults become errors.
mod balance;
mod checkpoint;
mod conduct;
pub mod failures;
pub mod fault;
mod half_step;
mod hash;
pub mod layout;
mod leaving;
pub mod ledger;
mod meter;
pub mod populate;
mod probes;
pub mod rates;
pub mod recorder;
pub mod report;
mod snapshot;
pub mod start;
mod surfaces;
mod timing;
mod together;
pub mod watch;

pub use balance::Balance;
pub use fault::RunError;
pub use ledger::Ledger;
pub use report::{Energies, GiverReport, MaterialReport, Report};
pub use snapshot::Snapshot;

use crate::output;
pub use checkpoint::Kept;
pub use conduct::Impatience;
use conduct::{Direction, Reporting};
use engine::data::rates::Clock;
use engine::data::warehouse::Warehouse;
pub use engine::exec::ranks::launch::available_threads;
use engine::exec::ranks::{Alone, Network, NetworkError, collective};
use engine::exec::{Backend, Engine, Serial, Threads};
use engine::graph::build::TaskGraph;
use engine::graph::error::GraphError;
use engine::program::{Program, Script};
use engine::schema::{Label, LabelId};
use grid::{BlockIndex, Partition};
use probes::Probes;
use scene::{Rates, Scene};
use simd::Isa;
use start::Roll;
use start::memory::Share;
use std::path::Path;
use tasks::{labels, recipes};

/// Labels that runs want besides what the next step reads.
const WANTED: &[LabelId] = &[
    labels::Time::ID,
    labels::Fault::ID,
    labels::FirstEvent::ID,
    labels::ContactWork::ID,
    labels::Reactions::ID,
    labels::TransferLoss::ID,
    labels::ForceWork::ID,
    labels::StressWork::ID,
    labels::BlockExtent::ID,
];

/// The program of one step of `scene` on `patches` patches.
///
/// # Errors
/// A fault of the recipe: an error in Sinew, not in the scene.
pub fn step_program(scene: &Scene, patches: usize) -> Result<Program, GraphError> {
    Program::build("step", recipes::step(scene), WANTED, patches)
}

/// The graph of a tick of `scene` on `patches` patches.
///
/// # Errors
/// As [`step_program`].
pub fn step_graph(scene: &Scene, patches: usize) -> Result<TaskGraph, GraphError> {
    step_program(scene, patches).map(Program::into_main_graph)
}

/// The calling thread, or a pool of threads.
fn backend(threads: usize) -> Result<Box<dyn Backend>, RunError> {
    Ok(match threads {
        1 => Box::new(Serial),
        n => Box::new(Threads::new(n)?),
    })
}

/// A simulation between two steps.
pub struct Simulation {
    /// What is simulated.
    pub scene: Scene,
    /// All data.
    pub warehouse: Warehouse,
    /// The program of a step.
    pub program: Program,
    report_program: Program,
    engine: Engine,
    network: Box<dyn Network>,
    ledger: Ledger,
    steps: u64,
    updates: u64,
    balance: Balance,
    probes: Probes,
    impatient: Impatience,
}

impl Simulation {
    /// Particles, graphs and workers for `scene`, and the state before the first step, on one rank.
    ///
    /// # Errors
    /// Patches that do not fit, or threads that do not start.
    pub fn new(scene: Scene, isa: Isa) -> Result<Self, RunError> {
        Self::on(Box::new(Alone), scene, isa)
    }

    /// This rank's part of the same, on all ranks of `network`.
    ///
    /// # Errors
    /// Patches that do not fit, or threads that do not start.
    pub fn on(network: Box<dyn Network>, scene: Scene, isa: Isa) -> Result<Self, RunError> {
        let census =
            |scene: &Scene, roll: &Roll, network: &mut dyn Network| Ok(start::census(scene, roll, network)?);
        let mut simulation = Self::assemble(network, scene, isa, census, populate::populate)?;
        // what the first step reads, too
        let wanted: Vec<LabelId> = WANTED.iter().chain(&simulation.graph().carried).copied().collect();
        let patches = simulation.warehouse.decomposition.patches.len();
        let start = Script::Graph("start", recipes::start(&simulation.scene));
        let start = Program::build("start", vec![start], &wanted, patches)?;
        simulation.execute(Some(&start))?;
        simulation.updates = 0;
        let report = simulation.report()?;
        let givers = simulation.warehouse.tiles.of(labels::Reactions::ID, 0);
        simulation.ledger.begin(&report, givers);
        Ok(simulation)
    }

    /// Patches, graphs and workers for `scene`: `census` says which blocks are occupied, with their particles, and `fill` puts those
    /// of this rank into its patches, on so many threads.
    fn assemble(
        mut network: Box<dyn Network>,
        scene: Scene,
        isa: Isa,
        census: impl FnOnce(&Scene, &Roll, &mut dyn Network) -> Result<Vec<(BlockIndex, u64)>, RunError>,
        fill: impl FnOnce(&Scene, &Roll, &mut Warehouse, &mut dyn Network, usize) -> Result<(), RunError>,
    ) -> Result<Self, RunError> {
        let threads = scene.run.threads.unwrap_or_else(available_threads);
        let (rank, ranks) = (network.rank(), network.size());
        let roll = Roll::call(&scene, &mut *network)?;
        let census = census(&scene, &roll, &mut *network)?;
        let (decomposition, loads) =
            layout::cut(&scene, 8 * threads * ranks, ranks, &census).map_err(RunError::Patches)?;
        let partition = Partition::by_cost(&decomposition, &loads, rank, ranks).map_err(RunError::Patches)?;
        let mine = Share::here(partition.mine().map(|patch| loads[patch]).sum());
        start::memory::fits(&start::memory::shares(mine, &mut *network)?)?;
        let patches = decomposition.patches.len();
        let program = step_program(&scene, patches)?;
        let report = Script::Graph("report", recipes::report(&scene));
        let report_program = Program::build("report", vec![report], ledger::REPORTED, patches)?;
        let labels = |material| populate::layout_of(&scene, &program, material);
        let tiles = &recipes::tiles(&scene);
        let mut warehouse =
            populate::empty(&scene, decomposition, partition, labels, program.labels(), tiles);
        fill(&scene, &roll, &mut warehouse, &mut *network, threads)?;
        let engine = Engine::new(backend(threads)?, isa, &warehouse);
        let probes = Probes::of(&scene, &roll, &mut *network)?;
        let (ledger, balance) = (Ledger::default(), Balance::default());
        let (steps, updates) = (0, 0);
        Ok(Self {
            scene,
            warehouse,
            program,
            report_program,
            engine,
            network,
            ledger,
            steps,
            updates,
            balance,
            probes,
            impatient: Box::new(|| false),
        })
    }

    /// Goes on with another backend.
    pub fn set_backend(&mut self, backend: Box<dyn Backend>) {
        self.engine = Engine::new(backend, self.engine.isa(), &self.warehouse);
    }

    /// The graph of a tick.
    pub fn graph(&self) -> &TaskGraph {
        self.program.main_graph()
    }

    /// Runs a program: that of a step, or another one.
    fn execute(&mut self, other: Option<&Program>) -> Result<(), RunError> {
        // what comes before the first step is none
        self.engine.trace().pause(other.is_some());
        let Self { scene, warehouse, program, engine, network, ledger, steps, updates, impatient, .. } = self;
        let (level, clock) = (warehouse.level, warehouse.shared.get(labels::Time::ID, 0));
        let mut direction = Direction { scene, level, ledger, updates, step: *steps, clock, impatient };
        engine.execute(other.unwrap_or(program), warehouse, &mut **network, &mut direction)
    }

    /// Takes one step, after which all materials are together; returns false when the end of the run was reached before.
    ///
    /// # Errors
    /// An inadmissible particle, a collapsed step, a particle that left where the scene forbids it.
    pub fn step(&mut self) -> Result<bool, RunError> {
        if self.finished() {
            return Ok(false);
        }
        self.engine.trace().set_step(self.steps);
        self.execute(None)?;
        self.steps += 1;
        self.share_load()?;
        Ok(true)
    }

    /// Goes on with other time steps, from the next step on.
    ///
    /// # Errors
    /// A fault of the recipe: an error in Sinew.
    pub fn set_rates(&mut self, rates: Rates) -> Result<(), RunError> {
        self.scene.run.rates = rates;
        self.program = step_program(&self.scene, self.warehouse.decomposition.patches.len())?;
        self.warehouse.own_rates = rates != Rates::Common;
        self.warehouse.reactivate = true;
        Ok(())
    }

    /// Gives each patch to a rank, between two steps. All ranks call it, with the same list.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn set_ranks(&mut self, of: Vec<u32>) -> Result<(), RunError> {
        let Self { engine, warehouse, network, .. } = self;
        let partition = Partition::new(of, network.rank(), network.size());
        Ok(engine.migrate(partition, warehouse, &mut **network)?)
    }

    /// Sets what is asked after each tick of a step: whether the run shall end in the middle of it, with
    /// [`RunError::Stopped`] on all ranks. Such a state cannot be gone on from.
    pub fn set_impatience(&mut self, impatient: Impatience) {
        self.impatient = impatient;
    }

    /// Whether the end of the run is reached.
    pub fn finished(&self) -> bool {
        self.clock().time >= self.scene.run.until
            || self.scene.run.steps.is_some_and(|most| self.steps >= most)
    }

    /// Time and step size.
    pub fn clock(&self) -> Clock {
        self.warehouse.shared.get(labels::Time::ID, 0)
    }

    /// Bytes of particle data, and of node data with the buffers that feed it.
    pub fn bytes(&self) -> (usize, usize) {
        let (particles, nodes) = self.warehouse.bytes();
        (particles, nodes + self.engine.buffer_bytes())
    }

    /// Particles moved so far, counted once each time.
    pub fn updates(&self) -> u64 {
        self.updates
    }

    /// Ticks taken: steps of the fastest material.
    pub fn ticks(&self) -> u64 {
        self.clock().number as u64
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The ranks of the run.
    pub fn network(&mut self) -> &mut dyn Network {
        &mut *self.network
    }

    /// Records anew from now on what each worker does, at most `bound` events a worker.
    pub fn set_trace(&mut self, bound: usize) {
        self.engine.set_trace(bound);
    }

    /// Writes what was recorded on all ranks, from rank 0.
    ///
    /// # Errors
    /// A file that cannot be written, or a rank that is gone.
    pub fn write_trace(&mut self, path: &Path) -> output::Result<()> {
        let Self { engine, program, network, scene, .. } = self;
        let scene = crate::input::identity::fingerprint(&scene.resolved);
        let written = output::trace::write(path, &scene, &program.graphs(), engine.trace(), &mut **network);
        output::together::agree(&mut **network, written)
    }

    /// Instruction set that runs.
    pub fn isa(&self) -> Isa {
        self.engine.isa()
    }

    /// Number of threads.
    pub fn threads(&self) -> usize {
        self.engine.workers()
    }

    /// Energies, momenta and failures now, over all ranks.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn report(&mut self) -> Result<Report, NetworkError> {
        let report = self.peek()?;
        self.ledger.note(&report);
        Ok(report)
    }

    /// The same of a moment that nobody may know of later: what is reported after it does not depend on it.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn peek(&mut self) -> Result<Report, NetworkError> {
        let Self { engine, report_program, warehouse, network, .. } = self;
        engine.execute(report_program, warehouse, &mut **network, &mut Reporting)?;
        let mut report = self.ledger.report(&self.scene, &self.warehouse, self.steps);
        together::count_particles(&mut *self.network, &mut report)?;
        report.probes = self.probes.measure(&self.scene, &self.warehouse, &mut *self.network)?;
        Ok(report)
    }

    /// What the probes of the scene show now.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn probes(&mut self) -> Result<Vec<f64>, NetworkError> {
        self.probes.measure(&self.scene, &self.warehouse, &mut *self.network)
    }

    /// A row of the history has been written: mean forces are taken from here on.
    pub fn mark_row(&mut self) {
        self.ledger.mark(self.clock().time);
    }

    /// One number that changes with any bit of any particle, whatever the order, patches, threads and ranks.
    pub fn state_hash(&mut self) -> u64 {
        let mut total = [hash::particles(&self.warehouse)];
        // a rank that is gone stops the next exchange of a step or of output
        let _ = collective::sum(&mut *self.network, &mut total);
        hash::state(total[0], &self.warehouse)
    }

    /// The particles of this rank, for output.
    pub fn snapshot(&self) -> Snapshot<'_> {
        Snapshot::new(&self.scene, &self.warehouse)
    }
}
