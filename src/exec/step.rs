//! A step: the phases of a graph, one after the other.
use super::Executor;
use super::border::Border;
use super::buffers::Buffers;
use super::lending::{begin, collect, lend};
use super::meter::{Laps, Tally, What};
use super::ranks::ghosts::Ghosts;
use super::ranks::migrate;
use super::ranks::occupied::{self, Beside};
use super::ranks::reduction::{self, Counters};
use super::ranks::{Network, NetworkError};
use super::relocate::{Relocation, Way};
use super::scratch::Scratch;
use super::stage::{self, Context};
use super::trace::{Event, Recorder};
use super::wave;
use super::work::{Blocks, Memory, Watch, Which, Work, lock};
use crate::data::label::Reduce;
use crate::data::labels::LabelId;
use crate::data::schedule::Schedule;
use crate::data::warehouse::{Shared, Warehouse};
use crate::graph::build::TaskGraph;
use crate::graph::fuse::{Phase, Stage};
use crate::graph::task::Domain;
use crate::grid::Partition;
use crate::simd::Isa;
use std::ops::Range;
use std::sync::Mutex;

/// Runs graphs with an executor. Keeps what workers need between steps.
pub struct Engine<E> {
    executor: E,
    isa: Isa,
    scratch: Vec<Mutex<Scratch>>,
    schedule: Schedule,
    memory: Memory,
    buffers: Buffers,
    /// Layers of blocks that a wave takes at once.
    slabs: Vec<Range<i32>>,
    /// Ranks in sight.
    beside: Vec<Beside>,
    /// What passes between them and this one.
    ghosts: Ghosts,
    metered: bool,
    /// Whether blocks remember what work on them takes.
    weighing: bool,
    /// What is done when.
    trace: Recorder,
}

impl<E: Executor> Engine<E> {
    /// An engine for runs on `warehouse`.
    pub fn new(executor: E, isa: Isa, warehouse: &Warehouse) -> Self {
        let scratch = || Mutex::new(Scratch::new(warehouse.materials.len(), &warehouse.shared));
        let scratch = (0..executor.workers()).map(|_| scratch()).collect();
        let schedule = Schedule::everyone(warehouse.materials.len());
        let (memory, buffers, slabs) = (Memory::default(), Buffers::default(), Vec::new());
        let beside = occupied::beside(&warehouse.decomposition, &warehouse.partition);
        let (ghosts, metered, weighing, trace) = (Ghosts::default(), false, false, Recorder::off());
        Self {
            executor,
            isa,
            scratch,
            schedule,
            memory,
            buffers,
            slabs,
            beside,
            ghosts,
            metered,
            weighing,
            trace,
        }
    }

    /// Instruction set that tasks run on.
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// Bytes of the buffers in which blocks add up what they give to nodes.
    pub fn buffer_bytes(&self) -> usize {
        self.buffers.bytes()
    }

    /// Number of workers.
    pub fn workers(&self) -> usize {
        self.executor.workers()
    }

    /// Meters what is run from now on, or stops that. See [`super::meter`].
    pub fn set_meter(&mut self, on: bool) {
        self.metered = on;
        self.take_meter();
        (0..self.workers()).for_each(|w| lock(&self.scratch[w]).tally.counting = self.isa == Isa::COUNTING);
    }

    /// What the work since the last [`Engine::set_meter`] took, summed over workers.
    pub fn take_meter(&self) -> Tally {
        let mut sum = Tally::default();
        (0..self.workers()).for_each(|w| sum.merge(&lock(&self.scratch[w]).tally.take()));
        sum
    }

    /// Lets blocks remember what work on them takes from now on, or stops that.
    pub fn set_weighing(&mut self, on: bool) {
        self.weighing = on;
    }

    /// Records from now on what is done when, at most `bound` events a worker; 0: no more.
    pub fn set_trace(&mut self, bound: usize) {
        self.trace = if bound == 0 { Recorder::off() } else { Recorder::new(self.workers(), bound) };
    }

    /// What is done when.
    pub fn trace(&self) -> &Recorder {
        &self.trace
    }

    /// Does work of its own, and meters it as `what`.
    pub fn metered<T>(&self, what: What, work: impl FnOnce() -> T) -> T {
        if !self.metered {
            return work();
        }
        let tally = &mut lock(&self.scratch[0]).tally;
        let mut laps = Laps::<true>::begin(tally);
        let result = work();
        laps.lap(what);
        laps.end(tally);
        result
    }

    /// Runs `graph` once: a tick. A task that computes the label `Step` decides which materials act in the rest of it;
    /// without one, all do. Reductions that only the end completes are left to [`Engine::relocate`] or [`Engine::reduce`].
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn run(
        &mut self,
        graph: &TaskGraph,
        warehouse: &mut Warehouse,
        network: &mut dyn Network,
    ) -> Result<(), NetworkError> {
        if warehouse.stale {
            self.activate(warehouse, network)?;
        }
        if self.slabs.is_empty() {
            self.slabs = wave::slabs(warehouse, self.workers());
        }
        self.schedule.reset();
        for wave in &graph.waves {
            let phases = &graph.phases[wave.clone()];
            self.reduce(Some(wave.start), &phases[0].reductions, &mut warehouse.shared, network)?;
            let names = || phases.iter().flat_map(|p| &p.stages).flat_map(|s| &s.nodes);
            let span = tracing::debug_span!("wave", tasks = tracing::field::Empty);
            if !span.is_disabled() {
                let names: Vec<&str> = names().map(|&n| graph.graph[n].name.as_str()).collect();
                span.record("tasks", names.join(" "));
            }
            span.in_scope(|| self.wave(graph, wave, warehouse, network))?;
            if phases.iter().any(|phase| phase.decides) {
                self.schedule.read(&warehouse.shared);
            }
        }
        Ok(())
    }

    /// Which blocks are active, here and in sight.
    fn activate(&mut self, warehouse: &mut Warehouse, network: &mut dyn Network) -> Result<(), NetworkError> {
        if network.size() > 1 {
            occupied::tell(network, warehouse, &self.beside)?;
        }
        self.metered(What::Activation, || warehouse.activate());
        if network.size() > 1 {
            self.ghosts = Ghosts::new(warehouse, &self.beside);
        }
        self.slabs.clear();
        Ok(())
    }

    /// Gives patches to the ranks that `partition` wants.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn migrate(
        &mut self,
        partition: Partition,
        warehouse: &mut Warehouse,
        network: &mut dyn Network,
    ) -> Result<(), NetworkError> {
        migrate::migrate(network, warehouse, partition)?;
        self.beside = occupied::beside(&warehouse.decomposition, &warehouse.partition);
        Ok(())
    }

    /// Brings the parts of all ranks of some labels together, before a phase or at the end.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn reduce(
        &self,
        before: Option<usize>,
        labels: &[LabelId],
        shared: &mut Shared,
        network: &mut dyn Network,
    ) -> Result<(), NetworkError> {
        if labels.is_empty() || network.size() == 1 {
            return Ok(());
        }
        let began = self.trace.now();
        reduction::reduce(network, labels, |m| self.schedule.ends(m), shared, &mut Counters::default())?;
        self.trace.record(0, began, Event::reduction(before));
        Ok(())
    }

    /// Finds the particles that have to move after a tick of `graph`, and completes its reductions. If `reflect`, particles
    /// outside the level come back.
    ///
    /// # Errors
    /// If a rank or a particle is gone.
    pub fn relocate(
        &self,
        graph: &TaskGraph,
        warehouse: &mut Warehouse,
        network: &mut dyn Network,
        reflect: bool,
    ) -> Result<Relocation, NetworkError> {
        let moved = |material: usize| self.schedule.ends(material);
        let (labels, trace) = (&graph.at_end[..], &self.trace);
        let mut way = Way { network, beside: &self.beside, labels, reflect, trace };
        let prepare = || Relocation::prepare(warehouse, &mut way, moved);
        self.metered(What::Relocation, prepare)
    }

    /// Runs phases that may follow one another layer by layer.
    fn wave(
        &mut self,
        graph: &TaskGraph,
        wave: &Range<usize>,
        warehouse: &mut Warehouse,
        network: &mut dyn Network,
    ) -> Result<(), NetworkError> {
        let (isa, metered, weighing) = (self.isa, self.metered, self.weighing);
        let Self { executor, scratch, schedule, memory, buffers, slabs, ghosts, trace, .. } = self;
        let Warehouse { level, decomposition, partition, materials, particles, nodes, shared, .. } =
            warehouse;
        let (first, phases) = (wave.start, &graph.phases[wave.clone()]);
        let context = Context { isa, recipe: &graph.recipe, level, materials, schedule, buffers };
        phases.iter().for_each(|phase| begin(phase, schedule, shared));
        let once = phases[0].stages.first().filter(|s| s.domain == Domain::Once);
        if let Some(stage) = once {
            let tally = &mut lock(&scratch[0]).tally;
            match metered {
                true => once_for_all::<true>(&context, stage, shared, tally, network.rank()),
                false => once_for_all::<false>(&context, stage, shared, tally, network.rank()),
            }
            return Ok(());
        }
        lend(phases, scratch, shared);
        let blocks = level.blocks();
        let whole = blocks.lower[0]..blocks.upper[0];
        let slabs = if wave::busy(schedule, particles) { &slabs[..] } else { std::slice::from_ref(&whole) };
        let watch = Watch { weighing, trace };
        let mut work = Work { executor, context, scratch, memory, metered, watch };
        let mut data = Blocks { first_layer: whole.start, decomposition, partition, particles, nodes };
        if network.size() == 1 {
            executor.enter(|| {
                let order = wave::order(phases, slabs);
                order.for_each(|(phase, slab)| work.over(phase, Which::All(slab), &mut data));
            });
        } else {
            let border = Border::new(network, ghosts, (first, phases), whole.clone());
            together(border, phases, slabs, &mut work, &mut data)?;
        }
        collect(phases, scratch, shared);
        Ok(())
    }
}

/// Runs a wave with other ranks: the rim as soon as it can be, the interior in between.
fn together<E: Executor>(
    mut border: Border<'_>,
    phases: &[Phase],
    slabs: &[Range<i32>],
    work: &mut Work<'_, E>,
    data: &mut Blocks<'_>,
) -> Result<(), NetworkError> {
    border.await_next(work);
    border.advance(work, data, false)?;
    for (phase, slab) in wave::order(phases, slabs) {
        work.over(phase, Which::Interior(slab), data);
        border.advance(work, data, false)?;
    }
    border.advance(work, data, true)
}

/// Runs a stage that has no place. All ranks do, with the same result; what it adds to sums counts on the first alone.
fn once_for_all<const METERED: bool>(
    context: &Context<'_>,
    stage: &Stage,
    shared: &mut Shared,
    tally: &mut Tally,
    rank: usize,
) {
    let sums = stage.touched.iter().filter(|a| a.mode.writes() && a.label.reduce() != Reduce::No);
    let before: Vec<_> = match rank {
        0 => Vec::new(),
        _ => sums.map(|a| (a.label, shared.column(a.label).to_vec())).collect(),
    };
    stage::once::<METERED>(context, stage, shared, tally);
    before.iter().for_each(|(label, lines)| shared.column_mut(*label).copy_from_slice(lines));
}
