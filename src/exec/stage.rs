//! One stage on one block: columns are laid out, then the fused tasks run chunk by chunk.
use super::buffers::Buffers;
use super::halo::{Around, Clear, LoadRegion, MotionAround, SumPartials};
use super::meter::{Laps, Part, Tally, What};
use super::relocate::somebody_left;
use super::scratch::{AHEAD, CHUNK, Scratch};
use crate::data::extent;
use crate::data::label::Home;
use crate::data::labels::{LABELS, LabelId};
use crate::data::nodes::{NODES, NodeBlock};
use crate::data::particles::ParticleBlock;
use crate::data::reduction;
use crate::data::schedule::{Field, Schedule};
use crate::data::warehouse::{MaterialData, NodePatch, ParticlePatch, Shared};
use crate::data::workspace::Workspace;
use crate::graph::fuse::Stage;
use crate::graph::recipe::{Entry, Recipe};
use crate::graph::task::{At, Domain, Mode, Runnable};
use crate::grid::{BLOCK, Level};
use crate::physics::shape::{BELOW, Origin};
use crate::simd::{Isa, LANES, Wide};

/// Node labels that particles fill, and the index of their partial buffers.
pub const SCATTERED: [(LabelId, usize); 2] = [(LabelId::NodeSums, 0), (LabelId::ContactSums, 1)];

/// What is the same for all blocks of a phase.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Instruction set.
    pub isa: Isa,
    /// The recipe.
    pub recipe: &'a Recipe,
    /// The grid.
    pub level: &'a Level,
    /// The materials.
    pub materials: &'a [MaterialData],
    /// Who acts.
    pub schedule: &'a Schedule,
    /// Buffers for what blocks give to nodes.
    pub buffers: &'a Buffers,
}

impl Context<'_> {
    fn at(&self, index: [i32; 3]) -> At<'_> {
        let node = index.map(|b| BLOCK * b);
        let origin = Origin {
            node: node.map(|n| f64::from(n - BELOW)),
            lower: self.level.lower.map(|x| x / self.level.cell),
        };
        At { origin, count: 0, node, fields: &[] }
    }

    /// A span a task: at level TRACE, because a task runs for microseconds.
    fn span(&self, entry: usize) -> tracing::span::Span {
        let Entry { task, material, .. } = &self.recipe.entries[entry];
        let material = material.map_or("", |m| &self.recipe.materials[m]);
        tracing::trace_span!("task", name = task.declaration().name, material)
    }

    fn task(&self, entry: usize) -> &dyn Runnable {
        &*self.recipe.entries[entry].task
    }
}

/// Runs a particle stage on one block.
pub fn sweep<const METERED: bool>(
    context: &Context<'_>,
    stage: &Stage,
    nodes: &[NodePatch],
    scratch: &mut Scratch,
    block: &mut ParticleBlock,
) {
    let Some(material) = stage.material else { return };
    let layout = &context.materials[material].layout;
    let (mut laps, part) =
        (Laps::<METERED>::begin(&mut scratch.tally), |part| What::Part(stage.entries[0], part));
    let (mut columns, shared) = scratch.split();
    if stage.touches(LabelId::NodeSums, Mode::writes) {
        block.touched = extent::touched(&block.extent, block.index);
    }
    for (label, which) in SCATTERED.iter().filter(|(label, _)| stage.touches(*label, Mode::writes)) {
        if *label == LabelId::NodeSums || block.near {
            let mut buffer = context.buffers.take();
            context.isa.dispatch(Clear { buffer: &mut buffer, touched: &block.touched });
            block.partials[*which] = buffer;
        }
    }
    if stage.after_nodes {
        block.partials.iter_mut().for_each(|buffer| context.buffers.put_back(std::mem::take(buffer)));
    }
    laps.lap(part(Part::Zeroing));
    if stage.touches(LabelId::NodeMotion, Mode::reads) {
        let region = &mut *columns[LabelId::NodeMotion as usize];
        let from = MotionAround { material, nodes, around: &block.around, touched: &block.touched };
        context.isa.dispatch(LoadRegion { from, region });
    }
    laps.lap(part(Part::LoadRegion));
    let (count, tiles, near, index) = (block.count, block.tiles(), block.near, block.index);
    let split = block.split(layout);
    let homes = split.columns.into_iter().zip(LabelId::ALL).zip(&mut columns);
    for ((column, label), slot) in homes {
        if label.home() == Home::Particle {
            *slot = column;
        }
    }
    for ((label, _), partial) in SCATTERED.iter().zip(split.partials) {
        if stage.touches(*label, Mode::writes) {
            columns[*label as usize] = partial;
        }
    }
    if stage.touches(LabelId::BlockExtent, Mode::writes) {
        reduction::clear(LabelId::BlockExtent.reduce(), split.extent);
        columns[LabelId::BlockExtent as usize] = split.extent;
    }
    lend_shared(&mut columns, shared, Some(material));
    let history = layout.widths[LabelId::History as usize];
    let mut space = Workspace { columns, chunk: 0..0, ahead: AHEAD, history };
    let mut at = context.at(index);
    let traced = tracing::enabled!(tracing::Level::TRACE);
    laps.lap(part(Part::Setup));
    for first in (0..tiles).step_by(CHUNK) {
        space.chunk = first..(first + CHUNK).min(tiles);
        at.count = (count - first * LANES).min(CHUNK * LANES);
        for &entry in &stage.entries {
            let task = context.task(entry);
            if near || task.declaration().domain != Domain::NearParticles {
                let _span = traced.then(|| context.span(entry).entered());
                task.run_on(context.isa, &at, &mut space);
                laps.lap(What::Entry(entry));
            }
        }
    }
    if stage.touches(LabelId::BlockExtent, Mode::writes) {
        // here the extent is in cache
        block.leaving = somebody_left(context.level, &context.materials[material], block);
    }
    laps.end(&mut scratch.tally);
}

/// Runs a node stage on one block, unless no particle touches its nodes; returns whether it did.
pub fn update_nodes<const METERED: bool>(
    context: &Context<'_>,
    stage: &Stage,
    particles: &[Vec<ParticlePatch>],
    scratch: &mut Scratch,
    block: &mut NodeBlock,
) -> bool {
    let of = |which, material, around| Around { which, material, particles, around };
    let fields = || block.present.iter().map(|&m| m as usize).zip(&block.around);
    if !fields().any(|(material, around)| of(0, material, around).is_something()) {
        return false;
    }
    let (mut laps, part) =
        (Laps::<METERED>::begin(&mut scratch.tally), |part| What::Part(stage.entries[0], part));
    let mut materials = std::mem::take(&mut scratch.fields);
    materials.clear();
    materials.extend(fields_of(context.schedule, block));
    let (mut columns, shared) = scratch.split();
    let lines = NODES * block.present.len();
    for (label, which) in SCATTERED {
        let column = std::mem::take(&mut columns[label as usize]);
        let exists = label == LabelId::NodeSums || block.present.len() > 1;
        if !stage.touches(label, Mode::reads) || !exists {
            continue;
        }
        let column = &mut column[..lines];
        for (sums, (material, around)) in column.chunks_exact_mut(NODES).zip(fields()) {
            context.isa.dispatch(SumPartials { from: of(which, material, around), sums });
        }
        columns[label as usize] = column;
    }
    laps.lap(part(Part::SumPartials));
    columns[LabelId::NodeMotion as usize] = &mut block.motion;
    if stage.touches(LabelId::ContactImpulse, Mode::writes) && block.present.len() > 1 {
        block.impulse.resize(lines, Wide::default());
    }
    columns[LabelId::ContactImpulse as usize] = &mut block.impulse;
    lend_shared(&mut columns, shared, None);
    let mut space = Workspace { columns, ..Workspace::empty() };
    let mut at = context.at(block.index);
    at.fields = &materials;
    let traced = tracing::enabled!(tracing::Level::TRACE);
    laps.lap(part(Part::Setup));
    for &entry in &stage.entries {
        let _span = traced.then(|| context.span(entry).entered());
        context.task(entry).run_on(context.isa, &at, &mut space);
        laps.lap(What::Entry(entry));
    }
    scratch.fields = materials;
    laps.end(&mut scratch.tally);
    true
}

/// The materials at a block's nodes, in this tick.
fn fields_of<'a>(schedule: &'a Schedule, block: &'a NodeBlock) -> impl Iterator<Item = Field> + 'a {
    let fields = block.present.iter().zip(&block.until);
    fields.map(|(&material, &until)| schedule.field(material, until))
}

/// Runs a stage that has no place.
pub fn once<const METERED: bool>(
    context: &Context<'_>,
    stage: &Stage,
    shared: &mut Shared,
    tally: &mut Tally,
) {
    let mut laps = Laps::<METERED>::begin(tally);
    let mut space = Workspace { columns: shared.split(), ..Workspace::empty() };
    let at = context.at([0; 3]);
    for &entry in &stage.entries {
        let _span = context.span(entry).entered();
        context.task(entry).run_on(context.isa, &at, &mut space);
        laps.lap(What::Entry(entry));
    }
    laps.end(tally);
}

/// Puts shared labels into their columns: one material's tile, or all tiles.
fn lend_shared<'a>(columns: &mut [&'a mut [Wide]; LABELS], shared: &'a mut Shared, material: Option<usize>) {
    for (slot, (column, label)) in columns.iter_mut().zip(shared.split().into_iter().zip(LabelId::ALL)) {
        match (label.home(), material) {
            (Home::Material, Some(m)) => *slot = &mut column[m * label.width()..(m + 1) * label.width()],
            (Home::Material | Home::Global, _) => *slot = column,
            _ => {}
        }
    }
}
