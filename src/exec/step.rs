//! A step: the phases of a graph, one after the other.
use super::Executor;
use super::meter::{Laps, Tally, What};
use super::scratch::Scratch;
use super::stage::{self, Context};
use crate::data::label::{Home, Reduce};
use crate::data::labels::LabelId;
use crate::data::particles::ParticleBlock;
use crate::data::reduction;
use crate::data::warehouse::{ParticlePatch, Shared, Warehouse};
use crate::graph::build::TaskGraph;
use crate::graph::fuse::{Phase, Stage};
use crate::graph::task::{Domain, Mode};
use crate::simd::Isa;
use std::collections::BTreeSet;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Runs graphs with an executor. Keeps what workers need between steps.
pub struct Engine<E> {
    executor: E,
    isa: Isa,
    scratch: Vec<Mutex<Scratch>>,
    metered: bool,
}

impl<E: Executor> Engine<E> {
    /// An engine for runs on `warehouse`.
    pub fn new(executor: E, isa: Isa, warehouse: &Warehouse) -> Self {
        let scratch = || Mutex::new(Scratch::new(warehouse.materials.len(), &warehouse.shared));
        let scratch = (0..executor.workers()).map(|_| scratch()).collect();
        Self { executor, isa, scratch, metered: false }
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
        (0..self.workers()).for_each(|w| self.worker(w).tally.counting = self.isa == Isa::COUNTING);
    }

    /// What the work since the last [`Engine::set_meter`] took, summed over workers.
    pub fn take_meter(&self) -> Tally {
        let mut sum = Tally::default();
        (0..self.workers()).for_each(|w| sum.merge(&self.worker(w).tally.take()));
        sum
    }

    /// Does work of its own, and meters it as `what`.
    pub fn metered<T>(&self, what: What, work: impl FnOnce() -> T) -> T {
        if !self.metered {
            return work();
        }
        let tally = &mut self.worker(0).tally;
        let mut laps = Laps::<true>::begin(tally);
        let result = work();
        laps.lap(what);
        laps.end(tally);
        result
    }

    fn worker(&self, worker: usize) -> MutexGuard<'_, Scratch> {
        self.scratch[worker].lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs `graph` once.
    pub fn run(&self, graph: &TaskGraph, warehouse: &mut Warehouse) {
        if warehouse.stale {
            self.metered(What::Activation, || warehouse.activate());
        }
        let mut begun = BTreeSet::new();
        for phase in &graph.phases {
            let names = || phase.stages.iter().flat_map(|s| &s.nodes).map(|&n| graph.graph[n].name.as_str());
            let span = tracing::debug_span!("phase", tasks = tracing::field::Empty);
            if !span.is_disabled() {
                span.record("tasks", names().collect::<Vec<_>>().join(" "));
            }
            span.in_scope(|| self.phase(graph, phase, warehouse, &mut begun));
        }
    }

    fn phase(
        &self,
        graph: &TaskGraph,
        phase: &Phase,
        warehouse: &mut Warehouse,
        begun: &mut BTreeSet<LabelId>,
    ) {
        let Warehouse { level, materials, particles, nodes, shared, .. } = warehouse;
        let context = Context { isa: self.isa, recipe: &graph.recipe, level, materials };
        let first = phase.stages.first();
        if let Some(stage) = first.filter(|s| s.domain == Domain::Once) {
            begin(phase, shared, begun);
            let once = if self.metered { stage::once::<true> } else { stage::once::<false> };
            return once(&context, stage, shared, &mut self.worker(0).tally);
        }
        self.lend(phase, shared);
        match first.filter(|s| s.domain == Domain::Nodes) {
            Some(stage) => {
                let mut items: Vec<_> = nodes.iter_mut().flat_map(|patch| &mut patch.blocks).collect();
                let update =
                    if self.metered { stage::update_nodes::<true> } else { stage::update_nodes::<false> };
                self.executor.each(&mut items, |worker, block| {
                    update(&context, stage, particles, &mut self.worker(worker), block);
                });
            }
            None => {
                let mut items = sweep_items(phase, particles);
                let sweep = if self.metered { stage::sweep::<true> } else { stage::sweep::<false> };
                self.executor.each(&mut items, |worker, (stage, block)| {
                    sweep(&context, stage, nodes, &mut self.worker(worker), block);
                });
            }
        }
        self.collect(phase, shared, begun);
    }

    /// Gives every worker the shared labels that the phase reads, and nothing yet of those that it reduces.
    fn lend(&self, phase: &Phase, shared: &Shared) {
        for scratch in &self.scratch {
            let mut scratch = scratch.lock().unwrap_or_else(PoisonError::into_inner);
            for (label, reduces) in shared_labels(phase) {
                let copy = scratch.shared.column_mut(label);
                match reduces {
                    true => reduction::clear(label.reduce(), copy),
                    false => copy.copy_from_slice(shared.column(label)),
                }
            }
        }
    }

    /// Adds up what the workers reduced.
    fn collect(&self, phase: &Phase, shared: &mut Shared, begun: &mut BTreeSet<LabelId>) {
        begin(phase, shared, begun);
        for (label, _) in shared_labels(phase).into_iter().filter(|&(_, reduces)| reduces) {
            let total = shared.column_mut(label);
            for scratch in &self.scratch {
                let scratch = scratch.lock().unwrap_or_else(PoisonError::into_inner);
                reduction::merge(label.reduce(), total, scratch.shared.column(label));
            }
        }
    }
}

/// The first phase of a step that reduces a label starts it afresh.
fn begin(phase: &Phase, shared: &mut Shared, begun: &mut BTreeSet<LabelId>) {
    for (label, _) in shared_labels(phase).into_iter().filter(|&(_, reduces)| reduces) {
        if begun.insert(label) {
            reduction::clear(label.reduce(), shared.column_mut(label));
        }
    }
}

/// The blocks of the phase's materials, with their stages.
fn sweep_items<'a>(
    phase: &'a Phase,
    particles: &'a mut [Vec<ParticlePatch>],
) -> Vec<(&'a Stage, &'a mut ParticleBlock)> {
    let stage_of = |material: usize| phase.stages.iter().find(|s| s.material == Some(material));
    particles
        .iter_mut()
        .flat_map(|patch| patch.iter_mut().enumerate())
        .filter_map(|(material, home)| Some((stage_of(material)?, home)))
        .flat_map(|(stage, home)| home.blocks.iter_mut().map(move |block| (stage, block)))
        .collect()
}

/// Labels of home `Material` and `Global` that a phase touches, and whether it reduces them.
fn shared_labels(phase: &Phase) -> Vec<(LabelId, bool)> {
    let touched = phase.stages.iter().flat_map(|s| &s.touched);
    let mut labels: Vec<_> = touched
        .filter(|a| matches!(a.label.home(), Home::Material | Home::Global))
        .map(|a| (a.label, a.mode == Mode::Computes && a.label.reduce() != Reduce::No))
        .collect();
    labels.sort();
    labels.dedup();
    labels
}
