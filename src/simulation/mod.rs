//! A run: a scene becomes particles and graphs, steps are taken, faults become errors.
mod balance;
mod checkpoint;
pub mod failures;
pub mod fault;
mod hash;
pub mod layout;
pub mod ledger;
mod meter;
mod parcel;
pub mod populate;
pub mod rates;
pub mod recorder;
mod snapshot;
mod together;

pub use balance::Balance;
pub use fault::RunError;
pub use ledger::{Energies, Ledger, MaterialReport, Report};
pub use snapshot::Snapshot;

use crate::data::labels::LabelId;
use crate::data::shared::Clock;
use crate::data::warehouse::Warehouse;
use crate::exec::meter::What;
pub use crate::exec::ranks::launch::available_threads;
use crate::exec::ranks::{Alone, Network, NetworkError, collective};
use crate::exec::relocate::Relocation;
use crate::exec::{Engine, Executor, Serial, Threads};
use crate::graph::build::TaskGraph;
use crate::graph::error::GraphError;
use crate::grid::{Decomposition, Partition};
use crate::input::scene::{Leaving, Rates, Scene};
use crate::output;
use crate::simd::Isa;
use crate::tasks::timestep;
use std::path::Path;

/// Labels that runs want besides what the next step reads.
const WANTED: &[LabelId] = &[
    LabelId::Time,
    LabelId::Fault,
    LabelId::FirstEvent,
    LabelId::ContactWork,
    LabelId::BoundaryWork,
    LabelId::TransferLoss,
    LabelId::BlockExtent,
];

/// The graph of one step of `scene` on `patches` patches.
///
/// # Errors
/// A fault of the recipe: an error in Sinew, not in the scene.
pub fn step_graph(scene: &Scene, patches: usize) -> Result<TaskGraph, GraphError> {
    TaskGraph::build(timestep::timestep(scene), WANTED, patches)
}

/// Serial or threaded.
pub enum Workers {
    /// The calling thread.
    Serial(Serial),
    /// A pool.
    Threads(Threads),
}

impl Workers {
    fn new(threads: usize) -> Result<Self, RunError> {
        match threads {
            1 => Ok(Workers::Serial(Serial)),
            n => Ok(Workers::Threads(Threads::new(n)?)),
        }
    }
}

impl Executor for Workers {
    fn each<T: Send>(&self, items: &mut [T], work: impl Fn(usize, &mut T) + Sync) {
        match self {
            Workers::Serial(executor) => executor.each(items, work),
            Workers::Threads(executor) => executor.each(items, work),
        }
    }

    fn enter<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match self {
            Workers::Serial(executor) => executor.enter(work),
            Workers::Threads(executor) => executor.enter(work),
        }
    }

    fn workers(&self) -> usize {
        match self {
            Workers::Serial(executor) => executor.workers(),
            Workers::Threads(executor) => executor.workers(),
        }
    }
}

/// A simulation between two steps.
pub struct Simulation {
    /// What is simulated.
    pub scene: Scene,
    /// All data.
    pub warehouse: Warehouse,
    /// The graph of a step.
    pub graph: TaskGraph,
    report_graph: TaskGraph,
    engine: Engine<Workers>,
    network: Box<dyn Network>,
    ledger: Ledger,
    steps: u64,
    updates: u64,
    balance: Balance,
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
        let mut simulation = Self::assemble(network, scene, isa, layout::decompose, populate::populate)?;
        // what the first step reads, too
        let wanted: Vec<LabelId> = WANTED.iter().chain(&simulation.graph.carried).copied().collect();
        let patches = simulation.warehouse.decomposition.patches.len();
        let start = TaskGraph::build(timestep::start(&simulation.scene), &wanted, patches)?;
        simulation.begin(&start)?;
        simulation.updates = 0;
        let report = simulation.report()?;
        simulation.ledger.begin(&report);
        Ok(simulation)
    }

    /// Patches, graphs and workers for `scene`: `cut` makes about as many patches as it is told and says what each costs,
    /// `fill` puts the particles of this rank into them.
    fn assemble(
        network: Box<dyn Network>,
        scene: Scene,
        isa: Isa,
        cut: impl FnOnce(&Scene, usize) -> Result<(Decomposition, Vec<u64>), String>,
        fill: impl FnOnce(&Scene, &mut Warehouse) -> Result<(), RunError>,
    ) -> Result<Self, RunError> {
        let threads = scene.run.threads.unwrap_or_else(available_threads);
        let (decomposition, loads) = cut(&scene, 8 * threads * network.size()).map_err(RunError::Patches)?;
        let partition = Partition::by_cost(&decomposition, &loads, network.rank(), network.size())
            .map_err(RunError::Patches)?;
        let patches = decomposition.patches.len();
        let graph = step_graph(&scene, patches)?;
        let report_graph = TaskGraph::build(timestep::report(&scene), ledger::REPORTED, patches)?;
        let labels = |material| populate::layout_of(&scene, &graph, material);
        let mut warehouse = populate::empty(&scene, decomposition, partition, labels);
        fill(&scene, &mut warehouse)?;
        let engine = Engine::new(Workers::new(threads)?, isa, &warehouse);
        let (ledger, balance) = (Ledger::default(), Balance::default());
        let (steps, updates) = (0, 0);
        Ok(Self { scene, warehouse, graph, report_graph, engine, network, ledger, steps, updates, balance })
    }

    /// The state before the first step.
    fn begin(&mut self, start: &TaskGraph) -> Result<(), RunError> {
        let Self { engine, warehouse, network, .. } = self;
        engine.run(start, warehouse, &mut **network)?;
        let relocation = engine.relocate(start, warehouse, &mut **network, false)?;
        self.check_faults()?;
        self.carry_out(relocation)
    }

    /// Takes one step, after which all materials are together; returns false when the end of the run was reached before.
    ///
    /// # Errors
    /// An inadmissible particle, a collapsed step, a particle that left where the scene forbids it.
    pub fn step(&mut self) -> Result<bool, RunError> {
        if self.finished() {
            return Ok(false);
        }
        self.tick()?;
        while self.clock().number < self.clock().last {
            self.tick()?;
        }
        self.steps += 1;
        self.share_load()?;
        Ok(true)
    }

    /// The part of a step that the fastest material takes at once.
    fn tick(&mut self) -> Result<(), RunError> {
        self.engine.trace().set_step(self.steps);
        let reflect = self.scene.run.leaving == Leaving::Reflect;
        let Self { engine, graph, warehouse, network, .. } = self;
        engine.run(graph, warehouse, &mut **network)?;
        let relocation = engine.relocate(graph, warehouse, &mut **network, reflect)?;
        let mut clock = self.clock();
        self.check_step(&clock)?;
        self.check_faults()?;
        clock.number += 1.0;
        clock.time = if clock.number < clock.last { clock.time + clock.step } else { clock.end };
        self.warehouse.shared.set(LabelId::Time, 0, clock);
        self.ledger.add_step(&self.warehouse.shared);
        self.carry_out(relocation)
    }

    /// Goes on with other time steps, from the next step on.
    ///
    /// # Errors
    /// A fault of the recipe: an error in Sinew.
    pub fn set_rates(&mut self, rates: Rates) -> Result<(), RunError> {
        self.scene.run.rates = rates;
        self.graph = step_graph(&self.scene, self.warehouse.decomposition.patches.len())?;
        self.warehouse.own_rates = rates != Rates::Common;
        self.warehouse.stale = true;
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

    /// Whether the end of the run is reached.
    pub fn finished(&self) -> bool {
        self.clock().time >= self.scene.run.until
            || self.scene.run.steps.is_some_and(|most| self.steps >= most)
    }

    /// Time and step size.
    pub fn clock(&self) -> Clock {
        self.warehouse.shared.get(LabelId::Time, 0)
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

    /// Records from now on what each worker does, at most `bound` events a worker.
    pub fn set_trace(&mut self, bound: usize) {
        self.engine.set_trace(bound);
    }

    /// Writes what was recorded on all ranks, from rank 0.
    ///
    /// # Errors
    /// A file that cannot be written, or a rank that is gone.
    pub fn write_trace(&mut self, path: &Path) -> output::Result<()> {
        let Self { engine, graph, network, .. } = self;
        let written = output::trace::write(path, graph, engine.trace(), &mut **network);
        together::agree(&mut **network, written)
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
        let Self { engine, report_graph: graph, warehouse, network, .. } = self;
        engine.run(graph, warehouse, &mut **network)?;
        engine.reduce(None, &graph.at_end, &mut warehouse.shared, &mut **network)?;
        let mut report = self.ledger.report(&self.scene, &self.warehouse, self.steps);
        together::count_particles(&mut *self.network, &mut report)?;
        Ok(report)
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

    fn carry_out(&mut self, relocation: Relocation) -> Result<(), RunError> {
        self.updates += relocation.particles;
        self.ledger.reflect(relocation.reflected);
        if let Some(first) = relocation.left().first() {
            if self.scene.run.leaving == Leaving::Error {
                return Err(fault::left(&self.scene, first, relocation.left().len(), self.clock().time));
            }
            relocation.left().iter().for_each(|particle| self.ledger.delete(particle));
        }
        let (warehouse, engine) = (&mut self.warehouse, &self.engine);
        engine.metered(What::Relocation, || relocation.carry_out(warehouse));
        Ok(())
    }

    fn check_step(&self, clock: &Clock) -> Result<(), RunError> {
        if clock.step > 0.0 && (clock.step >= self.scene.run.smallest_step || clock.limited_by < 0.0) {
            return Ok(());
        }
        Err(fault::collapsed(&self.scene, clock, self.steps))
    }

    fn check_faults(&self) -> Result<(), RunError> {
        fault::find(&self.scene, &self.warehouse, self.clock().time, self.steps).map_or(Ok(()), Err)
    }
}
