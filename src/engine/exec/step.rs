//! Runs graphs: the segments of a tick, one after the other.
use super::backend::{Backend, Purpose};
use super::buffers::Buffers;
use super::exchange::Exchanges;
use super::lending::{begin, collect, lend};
use super::meter::{Laps, Tally, What};
use super::order::{self, Cursor, Op, Part, Segment, Wave};
use super::ranks::halos::Halos;
use super::ranks::migrate;
use super::ranks::occupied::{self, Neighbor};
use super::ranks::reduction::{self, Counters};
use super::ranks::{Network, NetworkError};
use super::recorder::Recorder;
use super::relocate::{Leaving, Relocation, Transit};
use super::scratch::Scratch;
use super::stage::{self, Context};
use super::trace::{Event, Kind};
use super::wave;
use super::work::{Blocks, Call, Memory, Watch, Which, lock};
use crate::data::schedule::Schedule;
use crate::data::shared::Shared;
use crate::data::warehouse::Warehouse;
use crate::graph::build::TaskGraph;
use crate::graph::phase::Stage;
use crate::graph::recipe::TaskNode;
use crate::graph::task::{Domain, Mode};
use crate::schema::Combine;
use grid::Partition;
use simd::Isa;
use std::ops::Range;
use std::sync::Mutex;

/// Runs graphs on a backend. Keeps what workers need between steps.
pub struct Engine {
    pub(super) backend: Box<dyn Backend>,
    isa: Isa,
    scratch: Vec<Mutex<Scratch>>,
    schedule: Schedule,
    memory: Memory,
    buffers: Buffers,
    /// Layers of blocks that a wave takes at once.
    slabs: Vec<Range<i32>>,
    /// The wave that runs.
    wave: Wave,
    /// Ranks in sight.
    neighbors: Vec<Neighbor>,
    /// What passes between them and this one.
    halos: Halos,
    /// Messages that a wave waits for.
    outstanding: Vec<(usize, usize)>,
    metered: bool,
    /// Whether blocks remember what work on them takes.
    weighing: bool,
    /// What is done when.
    pub(super) trace: Recorder,
}

impl Engine {
    /// An engine for runs on `warehouse`.
    pub fn new(backend: Box<dyn Backend>, isa: Isa, warehouse: &Warehouse) -> Self {
        let scratch = (0..backend.workers()).map(|_| Mutex::new(Scratch::new(warehouse))).collect();
        let neighbors = occupied::neighbors(&warehouse.decomposition, &warehouse.partition);
        // a run that goes on knows its blocks already
        let active = warehouse.partition.ranks > 1 && !warehouse.reactivate;
        let halos = if active { Halos::new(warehouse, &neighbors) } else { Halos::default() };
        Self {
            trace: Recorder::new(backend.workers(), 0),
            backend,
            isa,
            scratch,
            schedule: Schedule::everyone(warehouse.materials.len()),
            memory: Memory::default(),
            buffers: Buffers::default(),
            slabs: Vec::new(),
            wave: Wave::default(),
            neighbors,
            halos,
            outstanding: Vec::new(),
            metered: false,
            weighing: false,
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
        self.backend.workers()
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

    /// Records anew from now on: what the time goes to, and what is done when, at most `bound` events a worker.
    pub fn set_trace(&mut self, bound: usize) {
        self.trace = Recorder::new(self.workers(), bound);
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

    /// Runs `graph` once. A task that computes the steps of the materials decides which of them act in the rest of it, and in graphs
    /// that follow in the same program; where none has, all do. Reductions that only the end completes are left to [`Engine::relocate`] or [`Engine::reduce`].
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn run(
        &mut self,
        graph: &TaskGraph,
        warehouse: &mut Warehouse,
        network: &mut dyn Network,
    ) -> Result<(), NetworkError> {
        let asks = |node: &TaskNode| node.declaration.domain == Domain::NearParticles;
        if graph.graph.node_weights().any(asks) && warehouse.nearby.is_some() && !warehouse.reactivate {
            warehouse.mark_near();
        }
        if warehouse.reactivate {
            self.activate(warehouse, network)?;
        }
        if self.slabs.is_empty() {
            self.slabs = wave::slabs(warehouse, self.workers());
        }
        if graph.phases.iter().any(|phase| phase.decides) {
            self.schedule.reset();
        }
        for segment in order::segments(graph) {
            let phases = match segment {
                Segment::One(Op::Reduce(phase)) => {
                    self.reduce(graph, Some(phase), &mut warehouse.shared, network)?;
                    continue;
                }
                Segment::One(Op::Once(phase)) => {
                    self.once(graph, phase, warehouse, network.rank());
                    phase..phase + 1
                }
                Segment::One(_) => continue,
                Segment::Wave(phases) => {
                    self.wave(graph, phases.clone(), warehouse, network)?;
                    phases
                }
            };
            if let Some(rates) = warehouse.schema.roles.rates
                && graph.phases[phases].iter().any(|phase| phase.decides)
            {
                self.schedule.read(rates, &warehouse.shared);
            }
        }
        Ok(())
    }

    /// Nobody has decided yet who acts.
    pub(super) fn begin_program(&mut self) {
        self.schedule.reset();
    }

    /// Which blocks are active, here and in sight.
    fn activate(&mut self, warehouse: &mut Warehouse, network: &mut dyn Network) -> Result<(), NetworkError> {
        if network.size() > 1 {
            occupied::tell(network, warehouse, &self.neighbors)?;
        }
        let began = self.trace.now();
        self.backend.download(Purpose::Activation, &mut Blocks::of(warehouse));
        // who has moved once moves again
        let ahead = warehouse.is_arranged() && !warehouse.nodes_keep();
        self.metered(What::Activation, || {
            warehouse.vacate(&*self.backend);
            if ahead {
                warehouse.make_ready(&*self.backend);
            }
            warehouse.arrange(&*self.backend);
        });
        self.backend.upload(Purpose::Activation, &mut Blocks::of(warehouse));
        self.trace.record(0, began, Event::other(Kind::Arrange));
        if network.size() > 1 {
            self.halos = Halos::new(warehouse, &self.neighbors);
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
        self.neighbors = occupied::neighbors(&warehouse.decomposition, &warehouse.partition);
        Ok(())
    }

    /// Brings the parts of all ranks of labels together, before a phase of a graph or at its end.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn reduce(
        &self,
        graph: &TaskGraph,
        before: Option<usize>,
        shared: &mut Shared,
        network: &mut dyn Network,
    ) -> Result<(), NetworkError> {
        let labels = before.map_or(&graph.at_end, |phase| &graph.phases[phase].reductions);
        if labels.is_empty() || network.size() == 1 {
            return Ok(());
        }
        let began = self.trace.now();
        let contributes = |label, material| graph.contributes(before, label, material);
        let ends = |material| self.schedule.ends(material);
        reduction::reduce(network, labels, ends, contributes, shared, &mut Counters::default())?;
        self.trace.record(0, began, Event::reduction(before));
        Ok(())
    }

    /// Finds the particles that have to move after a tick of `graph`, and completes its reductions. `leaving` says what
    /// becomes of particles outside of the level, and `stop` whether this rank wants all to stop.
    ///
    /// # Errors
    /// If a rank or a particle is gone.
    pub fn relocate(
        &self,
        graph: &TaskGraph,
        warehouse: &mut Warehouse,
        network: &mut dyn Network,
        leaving: &mut Leaving<'_>,
        stop: bool,
    ) -> Result<Relocation, NetworkError> {
        let moved = |material: usize| self.schedule.ends(material);
        let mut way =
            Transit { network, neighbors: &self.neighbors, graph, leaving, stop, trace: &self.trace };
        let prepare = || Relocation::prepare(warehouse, (&*self.backend, self.isa), &mut way, moved);
        self.metered(What::Relocation, prepare)
    }

    /// Runs a phase that has no place. All ranks do, with the same result; what it adds to sums counts on the first alone.
    fn once(&mut self, graph: &TaskGraph, phase: usize, warehouse: &mut Warehouse, rank: usize) {
        let (isa, metered, began) = (self.isa, self.metered, self.trace.now());
        let Self { scratch, schedule, buffers, trace, .. } = self;
        let phase = &graph.phases[phase];
        let (context, shared, _) = context(graph, warehouse, (isa, schedule, buffers));
        begin(phase, schedule, shared);
        let Some(stage) = phase.stages.first() else { return };
        let scratch = &mut lock(&scratch[0]);
        match metered {
            true => once_for_all::<true>(&context, stage, shared, scratch, rank),
            false => once_for_all::<false>(&context, stage, shared, scratch, rank),
        }
        trace.record(0, began, Event::stage(stage));
    }

    /// Runs phases that may follow one another layer by layer.
    fn wave(
        &mut self,
        graph: &TaskGraph,
        numbers: Range<usize>,
        warehouse: &mut Warehouse,
        network: &mut dyn Network,
    ) -> Result<(), NetworkError> {
        let (isa, metered, weighing) = (self.isa, self.metered, self.weighing);
        let Self {
            backend, scratch, schedule, memory, buffers, slabs, wave, halos, outstanding, trace, ..
        } = self;
        let phases = &graph.phases[numbers.clone()];
        let span = tracing::debug_span!("wave", tasks = tracing::field::Empty);
        if !span.is_disabled() {
            let names = phases.iter().flat_map(|p| &p.stages).flat_map(|s| &s.nodes);
            let names: Vec<&str> = names.map(|&n| graph.graph[n].name.as_str()).collect();
            span.record("tasks", names.join(" "));
        }
        let _entered = span.entered();
        let blocks = warehouse.level.blocks();
        let whole = blocks.lower[0]..blocks.upper[0];
        let busy = wave::busy(schedule, &warehouse.particles);
        let slabs = if busy { &slabs[..] } else { std::slice::from_ref(&whole) };
        let (context, shared, mut data) = context(graph, warehouse, (isa, schedule, buffers));
        phases.iter().for_each(|phase| begin(phase, schedule, shared));
        lend(phases, scratch, shared);
        let watch = Watch { weighing, trace };
        let mut call = Call { context, scratch, memory, metered, watch };
        let alone = network.size() == 1;
        wave.fill(graph, numbers, slabs.len(), alone);
        let which = |part| match part {
            Part::Slab(slab) => Which::All(&slabs[slab]),
            Part::Interior(slab) => Which::Interior(&slabs[slab]),
            Part::Rim => Which::Rim(&whole),
        };
        let backend = &**backend;
        if alone {
            backend.enter(&mut || {
                for op in wave.ops() {
                    let Op::Work(phase, part) = op else { continue };
                    backend.run(&mut call, &graph.phases[phase], which(part), &mut data);
                }
            });
        } else {
            let mut exchanges = Exchanges::new(backend, network, halos, &graph.exchanges, outstanding);
            let mut cursor = Cursor::default();
            while let Some(op) =
                cursor.next(wave, |exchange| exchanges.take(exchange, &call, &mut data, false))?
            {
                match op {
                    Op::Work(phase, part) => {
                        backend.run(&mut call, &graph.phases[phase], which(part), &mut data);
                    }
                    Op::Send(exchange) => exchanges.send(exchange, &call, &mut data),
                    Op::Expect(exchange) => exchanges.expect(exchange, &call),
                    Op::Unpack(exchange) => {
                        exchanges.take(exchange, &call, &mut data, true)?;
                    }
                    _ => {}
                }
            }
        }
        collect(phases, scratch, shared);
        Ok(())
    }
}

/// What stages see of a warehouse, its shared labels, and its blocks.
pub fn context<'a>(
    graph: &'a TaskGraph,
    warehouse: &'a mut Warehouse,
    (isa, schedule, buffers): (Isa, &'a Schedule, &'a Buffers),
) -> (Context<'a>, &'a mut Shared, Blocks<'a>) {
    let Warehouse { level, partition, materials, fields, node_layout, particles, nodes, shared, .. } =
        warehouse;
    let (recipe, shape, first_layer) = (&graph.recipe, level.shape(), level.blocks().lower[0]);
    let context = Context { isa, recipe, level, shape, materials, fields, node_layout, schedule, buffers };
    let blocks = Blocks { materials, node_layout, first_layer, partition, particles, nodes };
    (context, shared, blocks)
}

fn once_for_all<const METERED: bool>(
    context: &Context<'_>,
    stage: &Stage,
    shared: &mut Shared,
    scratch: &mut Scratch,
    rank: usize,
) {
    let sums =
        stage.touched.iter().filter(|a| a.mode == Mode::Computes && a.label.combine() != Combine::None);
    let before: Vec<_> = match rank {
        0 => Vec::new(),
        _ => sums.map(|a| (a.label, shared.column(a.label).to_vec())).collect(),
    };
    stage::once::<METERED>(context, stage, shared, scratch);
    before.iter().for_each(|(label, lines)| shared.column_mut(*label).copy_from_slice(lines));
}
