//! A step: the phases of a graph, one after the other.
use super::Executor;
use super::buffers::Buffers;
use super::meter::{Laps, Tally, What};
use super::scratch::Scratch;
use super::stage::{self, Context};
use super::wave;
use crate::data::label::Home;
use crate::data::nodes::NodeBlock;
use crate::data::particles::ParticleBlock;
use crate::data::reduction;
use crate::data::schedule::Schedule;
use crate::data::warehouse::{NodePatch, ParticlePatch, Shared, Warehouse};
use crate::graph::build::TaskGraph;
use crate::graph::fuse::{Phase, Stage, When};
use crate::graph::task::Domain;
use crate::grid::Decomposition;
use crate::simd::Isa;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

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
    metered: bool,
}

impl<E: Executor> Engine<E> {
    /// An engine for runs on `warehouse`.
    pub fn new(executor: E, isa: Isa, warehouse: &Warehouse) -> Self {
        let scratch = || Mutex::new(Scratch::new(warehouse.materials.len(), &warehouse.shared));
        let scratch = (0..executor.workers()).map(|_| scratch()).collect();
        let schedule = Schedule::everyone(warehouse.materials.len());
        let (memory, slabs) = (Memory::default(), Vec::new());
        Self { executor, isa, scratch, schedule, memory, buffers: Buffers::default(), slabs, metered: false }
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
    /// without one, all do.
    pub fn run(&mut self, graph: &TaskGraph, warehouse: &mut Warehouse) {
        if warehouse.stale {
            self.metered(What::Activation, || warehouse.activate());
            self.slabs.clear();
        }
        if self.slabs.is_empty() {
            self.slabs = wave::slabs(warehouse, self.workers());
        }
        self.schedule.reset();
        for wave in &graph.waves {
            let phases = &graph.phases[wave.clone()];
            let names = || phases.iter().flat_map(|p| &p.stages).flat_map(|s| &s.nodes);
            let span = tracing::debug_span!("wave", tasks = tracing::field::Empty);
            if !span.is_disabled() {
                let names: Vec<&str> = names().map(|&n| graph.graph[n].name.as_str()).collect();
                span.record("tasks", names.join(" "));
            }
            span.in_scope(|| self.wave(graph, phases, warehouse));
            if phases.iter().any(|phase| phase.decides) {
                self.schedule.read(&warehouse.shared);
            }
        }
    }

    /// Whether a step of the material ended with the last tick.
    pub fn ended(&self, material: usize) -> bool {
        self.schedule.ends(material)
    }

    /// Runs phases that may follow one another layer by layer.
    fn wave(&mut self, graph: &TaskGraph, phases: &[Phase], warehouse: &mut Warehouse) {
        let Self { executor, isa, scratch, schedule, metered, memory, buffers, slabs } = self;
        let Warehouse { level, decomposition, materials, particles, nodes, shared, .. } = warehouse;
        let context = Context { isa: *isa, recipe: &graph.recipe, level, materials, schedule, buffers };
        phases.iter().for_each(|phase| begin(phase, schedule, shared));
        let once = phases[0].stages.first().filter(|s| s.domain == Domain::Once);
        if let Some(stage) = once {
            let once = if *metered { stage::once::<true> } else { stage::once::<false> };
            return once(&context, stage, shared, &mut lock(&scratch[0]).tally);
        }
        lend(phases, scratch, shared);
        let blocks = level.blocks();
        let whole = blocks.lower[0]..blocks.upper[0];
        let slabs = if wave::busy(schedule, particles) { &slabs[..] } else { &[whole] };
        let mut work = Work { executor, context, scratch, memory, metered: *metered };
        let mut data = Blocks { decomposition, particles, nodes };
        executor.enter(|| {
            for (phase, slab) in wave::order(phases, slabs) {
                match phase.stages.first().map(|stage| stage.domain) {
                    Some(Domain::Nodes) => work.over_nodes(phase, slab, &mut data),
                    _ => work.over_particles(phase, slab, &mut data),
                }
            }
        });
        collect(phases, scratch, shared);
    }
}

/// What a wave works with.
struct Work<'a, E> {
    executor: &'a E,
    context: Context<'a>,
    scratch: &'a [Mutex<Scratch>],
    memory: &'a mut Memory,
    metered: bool,
}

impl<E: Executor> Work<'_, E> {
    /// Runs a phase over nodes on one slab.
    fn over_nodes(&mut self, phase: &Phase, slab: &Range<i32>, data: &mut Blocks<'_>) {
        let Self { executor, context, scratch, memory, metered } = self;
        let Some(stage) = phase.stages.first() else { return };
        let (awake, next) = (context.schedule.awake(), context.schedule.next());
        let mut items = recycle(std::mem::take(&mut memory.nodes));
        for (nodes, patch) in data.nodes.iter_mut().zip(&data.decomposition.patches) {
            let blocks = nodes.slab_mut(patch.blocks.lower[0], slab);
            items.extend(blocks.filter(|(present, _)| present & awake != 0).map(|(_, block)| block));
        }
        let update = if *metered { stage::update_nodes::<true> } else { stage::update_nodes::<false> };
        executor.each(&mut items, |worker, block| {
            let ran = update(context, stage, data.particles, &mut lock(&scratch[worker]), block);
            if ran && phase.settles {
                block.until.fill(next);
            }
        });
        memory.nodes = recycle(items);
    }

    /// Runs a phase over particles on one slab.
    fn over_particles(&mut self, phase: &Phase, slab: &Range<i32>, data: &mut Blocks<'_>) {
        let Self { executor, context, scratch, memory, metered } = self;
        let mut items = recycle(std::mem::take(&mut memory.particles));
        for (homes, patch) in data.particles.iter_mut().zip(&data.decomposition.patches) {
            for (material, home) in homes.iter_mut().enumerate() {
                if let Some(stage) = phase.stages.iter().find(|s| acts(s, context.schedule, material)) {
                    let blocks = home.slab_mut(patch.blocks.lower[0], slab).iter_mut();
                    items.extend(blocks.map(|block| (stage, block)));
                }
            }
        }
        let sweep = if *metered { stage::sweep::<true> } else { stage::sweep::<false> };
        executor.each(&mut items, |worker, (stage, block)| {
            sweep(context, stage, data.nodes, &mut lock(&scratch[worker]), block);
        });
        memory.particles = recycle(items);
    }
}

/// The blocks that a wave works on.
struct Blocks<'a> {
    decomposition: &'a Decomposition,
    particles: &'a mut [Vec<ParticlePatch>],
    nodes: &'a mut [NodePatch],
}

/// Whether a stage over particles runs for a material in this tick.
fn acts(stage: &Stage, schedule: &Schedule, material: usize) -> bool {
    stage.material == Some(material)
        && match stage.when {
            When::Begin => schedule.begins(material),
            When::End => schedule.ends(material),
        }
}

/// A worker's scratch. Nobody else takes it while the worker works.
fn lock(scratch: &Mutex<Scratch>) -> MutexGuard<'_, Scratch> {
    scratch.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Gives every worker the shared labels that the phases read, and nothing yet of those that they reduce.
fn lend(phases: &[Phase], scratch: &[Mutex<Scratch>], shared: &Shared) {
    for scratch in scratch {
        let mut scratch = lock(scratch);
        for &(label, reduces) in phases.iter().flat_map(|phase| &phase.shared) {
            let copy = scratch.shared.column_mut(label);
            match reduces {
                true => reduction::clear(label.reduce(), copy),
                false => copy.copy_from_slice(shared.column(label)),
            }
        }
    }
}

/// Adds up what the workers reduced.
fn collect(phases: &[Phase], scratch: &[Mutex<Scratch>], shared: &mut Shared) {
    for scratch in scratch {
        let mut scratch = lock(scratch);
        for &(label, _) in phases.iter().flat_map(|phase| &phase.shared).filter(|(_, reduces)| *reduces) {
            let part = scratch.shared.column_mut(label);
            reduction::merge(label.reduce(), shared.column_mut(label), part);
            // two phases of a wave may add to one label: it counts once
            reduction::clear(label.reduce(), part);
        }
    }
}

/// The first phase of a tick that reduces a label starts it afresh; what is kept for each material, only for those
/// whose step ends.
fn begin(phase: &Phase, schedule: &Schedule, shared: &mut Shared) {
    for &label in &phase.afresh {
        let column = shared.column_mut(label);
        match label.home() {
            Home::Material => {
                let tiles = column.chunks_exact_mut(label.width()).enumerate();
                let ending = tiles.filter(|(material, _)| schedule.ends(*material));
                ending.for_each(|(_, tile)| reduction::clear(label.reduce(), tile));
            }
            _ => reduction::clear(label.reduce(), column),
        }
    }
}

/// Memory of the lists of blocks of a phase, which are empty between phases.
#[derive(Default)]
struct Memory {
    particles: Vec<(&'static Stage, &'static mut ParticleBlock)>,
    nodes: Vec<&'static mut NodeBlock>,
}

/// An empty list that takes over the memory of another: no allocation a step.
fn recycle<T, U>(mut list: Vec<T>) -> Vec<U> {
    list.clear();
    list.into_iter().map(|_| unreachable!("the list is empty")).collect()
}
