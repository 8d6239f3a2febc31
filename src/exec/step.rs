//! A step: the phases of a graph, one after the other.
use super::Executor;
use super::meter::{Laps, Tally, What};
use super::scratch::Scratch;
use super::stage::{self, Context};
use crate::data::label::Home;
use crate::data::nodes::NodeBlock;
use crate::data::particles::ParticleBlock;
use crate::data::reduction;
use crate::data::schedule::Schedule;
use crate::data::warehouse::{ParticlePatch, Shared, Warehouse};
use crate::graph::build::TaskGraph;
use crate::graph::fuse::{Phase, Stage, When};
use crate::graph::task::Domain;
use crate::simd::Isa;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Runs graphs with an executor. Keeps what workers need between steps.
pub struct Engine<E> {
    executor: E,
    isa: Isa,
    scratch: Vec<Mutex<Scratch>>,
    schedule: Schedule,
    /// Memory of the lists of blocks of a phase, empty between phases.
    particle_items: Vec<Item<'static>>,
    node_items: Vec<&'static mut NodeBlock>,
    metered: bool,
}

impl<E: Executor> Engine<E> {
    /// An engine for runs on `warehouse`.
    pub fn new(executor: E, isa: Isa, warehouse: &Warehouse) -> Self {
        let scratch = || Mutex::new(Scratch::new(warehouse.materials.len(), &warehouse.shared));
        let scratch = (0..executor.workers()).map(|_| scratch()).collect();
        let schedule = Schedule::everyone(warehouse.materials.len());
        let (particle_items, node_items) = (Vec::new(), Vec::new());
        Self { executor, isa, scratch, schedule, particle_items, node_items, metered: false }
    }

    /// Instruction set that tasks run on.
    pub fn isa(&self) -> Isa {
        self.isa
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
        }
        self.schedule.reset();
        for phase in &graph.phases {
            let names = || phase.stages.iter().flat_map(|s| &s.nodes).map(|&n| graph.graph[n].name.as_str());
            let span = tracing::debug_span!("phase", tasks = tracing::field::Empty);
            if !span.is_disabled() {
                span.record("tasks", names().collect::<Vec<_>>().join(" "));
            }
            span.in_scope(|| self.phase(graph, phase, warehouse));
            if phase.decides {
                self.schedule.read(&warehouse.shared);
            }
        }
    }

    /// Whether a step of the material ended with the last tick.
    pub fn ended(&self, material: usize) -> bool {
        self.schedule.ends(material)
    }

    fn phase(&mut self, graph: &TaskGraph, phase: &Phase, warehouse: &mut Warehouse) {
        let Warehouse { level, materials, particles, nodes, shared, .. } = warehouse;
        let Self { executor, isa, scratch, schedule, metered, .. } = self;
        let context = Context { isa: *isa, recipe: &graph.recipe, level, materials, schedule };
        begin(phase, schedule, shared);
        let first = phase.stages.first();
        if let Some(stage) = first.filter(|s| s.domain == Domain::Once) {
            let once = if *metered { stage::once::<true> } else { stage::once::<false> };
            return once(&context, stage, shared, &mut lock(&scratch[0]).tally);
        }
        lend(phase, scratch, shared);
        match first.filter(|s| s.domain == Domain::Nodes) {
            Some(stage) => {
                let blocks = nodes.iter_mut().flat_map(|patch| &mut patch.blocks);
                let mut items = recycle(std::mem::take(&mut self.node_items));
                items.extend(blocks.filter(|block| schedule.wakes(&block.present)));
                let update =
                    if *metered { stage::update_nodes::<true> } else { stage::update_nodes::<false> };
                executor.each(&mut items, |worker, block| {
                    update(&context, stage, particles, &mut lock(&scratch[worker]), block);
                    if phase.settles {
                        block.until.fill(schedule.next());
                    }
                });
                self.node_items = recycle(items);
            }
            None => {
                let mut items = recycle(std::mem::take(&mut self.particle_items));
                sweep_items(phase, schedule, particles, &mut items);
                let sweep = if *metered { stage::sweep::<true> } else { stage::sweep::<false> };
                executor.each(&mut items, |worker, (stage, block)| {
                    sweep(&context, &phase.stages[*stage], nodes, &mut lock(&scratch[worker]), block);
                });
                self.particle_items = recycle(items);
            }
        }
        collect(phase, scratch, shared);
    }
}

/// A worker's scratch. Nobody else takes it while the worker works.
fn lock(scratch: &Mutex<Scratch>) -> MutexGuard<'_, Scratch> {
    scratch.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Gives every worker the shared labels that the phase reads, and nothing yet of those that it reduces.
fn lend(phase: &Phase, scratch: &[Mutex<Scratch>], shared: &Shared) {
    for scratch in scratch {
        let mut scratch = lock(scratch);
        for &(label, reduces) in &phase.shared {
            let copy = scratch.shared.column_mut(label);
            match reduces {
                true => reduction::clear(label.reduce(), copy),
                false => copy.copy_from_slice(shared.column(label)),
            }
        }
    }
}

/// Adds up what the workers reduced.
fn collect(phase: &Phase, scratch: &[Mutex<Scratch>], shared: &mut Shared) {
    for &(label, _) in phase.shared.iter().filter(|(_, reduces)| *reduces) {
        let total = shared.column_mut(label);
        for scratch in scratch {
            let scratch = lock(scratch);
            reduction::merge(label.reduce(), total, scratch.shared.column(label));
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

/// A block, with the place of its stage in the phase.
type Item<'a> = (usize, &'a mut ParticleBlock);

/// The blocks of the materials that act in a phase.
fn sweep_items<'a>(
    phase: &Phase,
    schedule: &Schedule,
    particles: &'a mut [Vec<ParticlePatch>],
    items: &mut Vec<Item<'a>>,
) {
    let acts = |stage: &Stage, material: usize| {
        stage.material == Some(material)
            && match stage.when {
                When::Begin => schedule.begins(material),
                When::End => schedule.ends(material),
            }
    };
    for (material, home) in particles.iter_mut().flat_map(|patch| patch.iter_mut().enumerate()) {
        if let Some(stage) = phase.stages.iter().position(|stage| acts(stage, material)) {
            items.extend(home.blocks.iter_mut().map(|block| (stage, block)));
        }
    }
}

/// An empty list that takes over the memory of another: no allocation a step.
fn recycle<T, U>(mut list: Vec<T>) -> Vec<U> {
    list.clear();
    list.into_iter().map(|_| unreachable!("the list is empty")).collect()
}
