//! Phases over blocks: lists of blocks, spread over workers.
use super::Executor;
use super::recorder::Recorder;
use super::scratch::{AHEAD, Scratch};
use super::stage::{self, Context};
use super::trace::{Event, Kind, NONE};
use crate::data::brief::Brief;
use crate::data::layout::NodeLayout;
use crate::data::nodes::NodeBlock;
use crate::data::particles::ParticleBlock;
use crate::data::schedule::Schedule;
use crate::data::warehouse::{MaterialData, NodePatch, ParticlePatch, Warehouse};
use crate::data::workspace::recycle;
use crate::graph::exchange::{Exchange, Way};
use crate::graph::phase::{Phase, Stage, When};
use crate::schema::Home;
use grid::Partition;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// How stages are run.
pub struct Call<'a> {
    /// What is the same for all blocks.
    pub context: Context<'a>,
    /// One a worker.
    pub scratch: &'a [Mutex<Scratch>],
    /// Of lists of blocks.
    pub memory: &'a mut Memory,
    /// Whether work is metered.
    pub metered: bool,
    /// What looks at the work.
    pub watch: Watch<'a>,
}

/// Looks at work on blocks: for traces, and for the balance of ranks.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Whether blocks remember what work on them takes.
    pub weighing: bool,
    /// What is done when.
    pub trace: &'a Recorder,
}

impl Watch<'_> {
    /// A worker begins with a block.
    fn begin(&self) -> Option<Instant> {
        self.weighing.then(Instant::now)
    }

    /// A worker has done a block of a call that `began`; what it took, if that is weighed [ns].
    fn end(&self, began: u64, moment: Option<Instant>, worker: usize, stage: &Stage, slab: u32) -> u64 {
        let took = moment.map_or(0, |moment| moment.elapsed().as_nanos() as u64);
        self.trace.record_on(worker, began, Event { slab, ..Event::stage(stage) });
        took
    }
}

/// Which blocks of a phase.
#[derive(Clone, Copy, Debug)]
pub enum Which<'a> {
    /// All in some layers along x.
    All(&'a Range<i32>),
    /// Those in some layers along x that need nothing of other ranks.
    Interior(&'a Range<i32>),
    /// The others, in some layers along x.
    Rim(&'a Range<i32>),
}

impl Which<'_> {
    /// The layers.
    pub fn layers(&self) -> Range<i32> {
        let (Which::All(layers) | Which::Interior(layers) | Which::Rim(layers)) = self;
        (*layers).clone()
    }

    /// The slab's first layer, counted from the level's first, as traces have it.
    fn slab(&self, first: i32) -> u32 {
        match self {
            Which::All(layers) | Which::Interior(layers) => (layers.start - first) as u32,
            Which::Rim(_) => NONE,
        }
    }

    /// Whether the part has a block of which `rim` says whether it is one of the rim.
    pub fn has(&self, rim: impl FnOnce() -> bool) -> bool {
        match self {
            Which::All(_) => true,
            Which::Interior(_) => !rim(),
            Which::Rim(_) => rim(),
        }
    }
}

/// Runs a phase over nodes on some blocks.
pub fn over_nodes<E: Executor>(
    executor: &E,
    call: &mut Call<'_>,
    phase: &Phase,
    which: Which<'_>,
    data: &mut Blocks<'_>,
) {
    let Call { context, scratch, memory, metered, watch } = call;
    let Some(stage) = phase.stages.first() else { return };
    let (schedule, fields) = (context.schedule, context.fields);
    let (all, next) = (schedule.all_end(), schedule.next());
    let ends = |block: &NodeBlock| all || block.present.iter().any(|&f| schedule.ends(fields.material(f)));
    let mut items = recycle(std::mem::take(&mut memory.nodes));
    let (layers, began) = (which.layers(), watch.trace.now());
    let slab = which.slab(data.first_layer);
    for nodes in mine(data.nodes, data.partition) {
        let blocks = nodes.slab_mut(&layers);
        items.extend(blocks.iter_mut().filter(|block| ends(block) && which.has(|| block.rim)));
    }
    let update = if *metered { stage::update_nodes::<true> } else { stage::update_nodes::<false> };
    executor.each(&mut items, |worker, block| {
        let moment = watch.begin();
        let ran = update(context, stage, data.particles, &mut lock(&scratch[worker]), block);
        block.cost += watch.end(began, moment, worker, stage, slab);
        if ran && phase.settles {
            block.until.fill(next);
        }
    });
    watch.trace.record_idle(began, Event::idle(stage));
    memory.nodes = recycle(items);
}

/// Runs a phase over particles on some blocks.
pub fn over_particles<E: Executor>(
    executor: &E,
    call: &mut Call<'_>,
    phase: &Phase,
    which: Which<'_>,
    data: &mut Blocks<'_>,
) {
    let Call { context, scratch, memory, metered, watch } = call;
    let mut items = recycle(std::mem::take(&mut memory.particles));
    let (layers, began) = (which.layers(), watch.trace.now());
    let slab = which.slab(data.first_layer);
    for homes in mine(data.particles, data.partition) {
        // stages of a phase come in the order of their materials
        let mut homes = homes.iter_mut().enumerate();
        for stage in phase.stages.iter().filter(|stage| acts(stage, context.schedule)) {
            let mine = |(material, _): &(usize, _)| stage.material == Some(*material);
            let Some((_, home)) = homes.find(mine) else { continue };
            let blocks = home.slab_mut(&layers).filter(|(block, _)| which.has(|| block.rim));
            items.extend(blocks.map(|(block, brief)| (stage, block, brief, Brief::NOTHING)));
        }
    }
    let mut next = Brief::NOTHING;
    for (_, _, brief, behind) in items.iter_mut().rev() {
        (*behind, next) = (next, **brief);
    }
    let sweep = if *metered { stage::sweep::<true> } else { stage::sweep::<false> };
    executor.each(&mut items, |worker, (stage, block, brief, next)| {
        let moment = watch.begin();
        if let Some(material) = stage.material {
            let labels = stage.touched.iter().map(|access| access.label);
            let particles = labels.filter(|label| label.home() == Home::Particle);
            next.announce(&context.materials[material].layout, particles, AHEAD);
        }
        sweep(context, stage, data.nodes, &mut lock(&scratch[worker]), block);
        **brief = Brief::of(block, context.shape);
        block.cost += watch.end(began, moment, worker, stage, slab);
    });
    watch.trace.record_idle(began, phase.stages.first().map_or(Event::other(Kind::Idle), Event::idle));
    memory.particles = recycle(items);
}

/// What each patch of this rank has of something that all patches have.
fn mine<'a, T>(of_patches: &'a mut [T], partition: &'a Partition) -> impl Iterator<Item = &'a mut T> {
    let all = of_patches.iter_mut().enumerate();
    all.filter(|(patch, _)| partition.is_mine(*patch)).map(|(_, of)| of)
}

/// The blocks of a rank, and what is known about their labels.
pub struct Blocks<'a> {
    /// Labels of particles.
    pub materials: &'a [MaterialData],
    /// Labels of nodes.
    pub node_layout: &'a NodeLayout,
    /// The level's first layer of blocks along x.
    pub first_layer: i32,
    /// The ranks of patches.
    pub partition: &'a Partition,
    /// Particles: `[patch][material]`.
    pub particles: &'a mut [Vec<ParticlePatch>],
    /// Nodes: `[patch]`.
    pub nodes: &'a mut [NodePatch],
}

impl<'a> Blocks<'a> {
    /// The blocks of a warehouse.
    pub fn of(warehouse: &'a mut Warehouse) -> Self {
        let Warehouse { level, partition, materials, node_layout, particles, nodes, .. } = warehouse;
        let first_layer = level.blocks().lower[0];
        Self { materials, node_layout, first_layer, partition, particles, nodes }
    }
}

/// Whether a stage over particles runs in this tick.
pub fn acts(stage: &Stage, schedule: &Schedule) -> bool {
    stage.material.is_some_and(|material| match stage.when {
        When::Begin => schedule.begins(material),
        When::End => schedule.ends(material),
    })
}

/// Whether something of a material travels in an exchange in this tick.
pub fn travels(exchange: &Exchange, schedule: &Schedule, material: usize) -> bool {
    let acts = match exchange.way {
        Way::Partials => schedule.begins(material),
        Way::Values => schedule.ends(material),
    };
    acts && exchange.concerns(material)
}

/// A worker's scratch. Nobody else takes it while the worker works.
pub fn lock(scratch: &Mutex<Scratch>) -> MutexGuard<'_, Scratch> {
    scratch.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Memory of the lists of blocks of a phase, which are empty between phases.
#[derive(Default)]
pub struct Memory {
    /// A block, what others know of it, and what is known of the one that comes next.
    particles: Vec<(&'static Stage, &'static mut ParticleBlock, &'static mut Brief, Brief)>,
    nodes: Vec<&'static mut NodeBlock>,
}
