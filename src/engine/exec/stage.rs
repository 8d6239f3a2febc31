//! One stage on one block: columns are laid out, then the fused tasks run chunk by chunk.
use super::buffers::Buffers;
use super::halo::Clear;
use super::meter::{Laps, StagePart, What};
use super::region::{LoadRegion, ValuesAround};
use super::scratch::{AHEAD, CHUNK, Scratch};
use super::sums::{Around, SumPartials, Touching};
use crate::data::extent;
use crate::data::fields::{FieldId, Fields};
use crate::data::layout::NodeLayout;
use crate::data::nodes::{NodeBlock, is_there};
use crate::data::particles::{ParticleBlock, Split};
use crate::data::reduction;
use crate::data::schedule::Schedule;
use crate::data::shared::Shared;
use crate::data::warehouse::{MaterialData, NodePatch, ParticlePatch};
use crate::data::workspace::{Workspace, no_columns, recycle};
use crate::graph::phase::{Line, Stage};
use crate::graph::recipe::{Recipe, RecipeLine};
use crate::graph::task::{At, Mode, Runnable};
use crate::schema::{Home, Life};
use grid::{BlockIndex, BlockShape, IndexBox, Level};
use simd::{Isa, LANES, Wide};
use smallvec::SmallVec;

/// What is the same for all blocks of a phase.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// Instruction set.
    pub isa: Isa,
    /// The recipe.
    pub recipe: &'a Recipe,
    /// The grid.
    pub level: &'a Level,
    /// How the nodes of its blocks follow one another.
    pub shape: &'static BlockShape,
    /// The materials.
    pub materials: &'a [MaterialData],
    /// Their velocity fields.
    pub fields: &'a Fields,
    /// Labels of nodes.
    pub node_layout: &'a NodeLayout,
    /// Who acts.
    pub schedule: &'a Schedule,
    /// Buffers for what blocks add to nodes.
    pub buffers: &'a Buffers,
}

impl Context<'_> {
    fn at(&self, index: [i32; 3]) -> At<'_> {
        let (node, nodes) = (self.shape.first_node(index), self.shape.node_count());
        let touched = IndexBox { lower: node, upper: node };
        At { origin: self.level.origin(index), count: 0, node, nodes, touched, fields: &[] }
    }

    /// A span a task: at level TRACE, because a task runs for microseconds.
    fn span(&self, entry: usize) -> tracing::span::Span {
        let RecipeLine { task, material, .. } = &self.recipe.entries[entry];
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
    if block.count == 0 {
        return pass_over(context, stage, block);
    }
    let data = &context.materials[material];
    let (mut laps, part) =
        (Laps::<METERED>::begin(&mut scratch.tally), |part| What::Part(stage.entries[0], part));
    let (mut columns, shared, _) = scratch.lend();
    ready_buffers(context, stage, data.fields, block);
    laps.lap(part(StagePart::Zeroing));
    load_regions(context, stage, nodes, block, &mut columns);
    laps.lap(part(StagePart::LoadRegion));
    let (count, tiles, near, index) = (block.count, block.tiles(), block.near, block.index);
    let touched = match stage.before.is_empty() && stage.after.is_empty() {
        true => IndexBox { lower: [0; 3], upper: [0; 3] },
        false => in_level(context.shape, index, extent::touched(&block.extent, context.shape, index)),
    };
    let Split { columns: own, partials, extent: bounds } = block.split(&data.layout);
    own.for_each(|(label, column)| columns[label.index()] = column);
    for (label, partial) in context.node_layout.partial().iter().zip(partials) {
        if stage.adds.contains(label) {
            columns[label.index()] = partial;
        }
    }
    let extent = context.recipe.schema.roles.extent;
    let widens = stage.touches(extent, Mode::writes);
    if widens {
        reduction::clear(extent.combine(), bounds);
        columns[extent.index()] = bounds;
    }
    lend_shared(&mut columns, shared, Some(material));
    let mut space = Workspace { columns, chunk: 0..0, ahead: AHEAD, widths: &data.layout.widths };
    let mut at = context.at(index);
    at.touched = touched;
    let traced = tracing::enabled!(tracing::Level::TRACE);
    laps.lap(part(StagePart::Setup));
    let mut run = |line: &Line, at: &At<'_>, space: &mut Workspace<'_>| {
        if near || !line.near {
            let _span = traced.then(|| context.span(line.entry).entered());
            context.task(line.entry).run_on(context.isa, at, space);
            laps.lap(What::Entry(line.entry));
        }
    };
    stage.before.iter().for_each(|line| run(line, &at, &mut space));
    for first in (0..tiles).step_by(CHUNK) {
        space.chunk = first..(first + CHUNK).min(tiles);
        at.count = (count - first * LANES).min(CHUNK * LANES);
        stage.chunks.iter().for_each(|line| run(line, &at, &mut space));
    }
    stage.after.iter().for_each(|line| run(line, &at, &mut space));
    scratch.columns = recycle(space.columns);
    if widens {
        // here the extent is in cache
        block.leaving = block.count > 0
            && extent::somebody_left(&block.extent, context.level, block.index, data.half_size);
    }
    laps.end(&mut scratch.tally);
}

/// What a stage leaves of a block without particles.
fn pass_over(context: &Context<'_>, stage: &Stage, block: &mut ParticleBlock) {
    for (label, partial) in context.node_layout.partial().iter().zip(&mut block.partials) {
        if stage.adds.contains(label) || stage.releases.contains(label) {
            context.buffers.put_back(std::mem::take(partial));
        }
    }
    if !stage.adds.is_empty() {
        block.touched = IndexBox { lower: [0; 3], upper: [0; 3] };
    }
    (block.extent, block.leaving) = (extent::NOBODY, false);
}

/// A part of a block's buffer in nodes of the level.
fn in_level(shape: &BlockShape, block: BlockIndex, part: IndexBox) -> IndexBox {
    let first = shape.first_of_buffer(block);
    let moved = |corner: [i32; 3]| [0, 1, 2].map(|a| corner[a] + first[a]);
    IndexBox { lower: moved(part.lower), upper: moved(part.upper) }
}

/// Buffers for what the stage adds to nodes, with nothing in them but what stages before have added to the same sums; those
/// that nobody needs any more are put back.
fn ready_buffers(context: &Context<'_>, stage: &Stage, fields: usize, block: &mut ParticleBlock) {
    let Context { node_layout: layout, buffers, shape, .. } = context;
    if !stage.adds.is_empty() {
        block.touched = extent::touched(&block.extent, shape, block.index);
    }
    for (&label, partial) in layout.partial().iter().zip(&mut block.partials) {
        let adds = stage.adds.contains(&label);
        if adds && (block.near || !label.added_where_near()) {
            let width = label.width();
            if partial.is_empty() {
                *partial = buffers.take(layout.buffer * width * fields);
            } else if !stage.begins.contains(&label) {
                continue;
            }
            let (nothing, touched) = (reduction::nothing(label.combine()), &block.touched);
            context.isa.dispatch(Clear { buffers: partial, width, nothing, shape, touched });
        } else if adds || stage.releases.contains(&label) {
            buffers.put_back(std::mem::take(partial));
        }
    }
}

/// The values of the nodes around the block that the stage reads, of all fields of its material.
fn load_regions(
    context: &Context<'_>,
    stage: &Stage,
    nodes: &[NodePatch],
    block: &ParticleBlock,
    columns: &mut [&mut [Wide]],
) {
    let Some(material) = stage.material.filter(|_| !stage.reads.is_empty()) else { return };
    // they may have moved since they were added to nodes
    let touched = &extent::touched(&block.extent, context.shape, block.index);
    for &label in &stage.reads {
        let Some(place) = context.node_layout.stored_place(label) else { continue };
        let length = context.node_layout.buffer * label.width();
        let fields = context.fields.of(material).map(FieldId::new);
        let regions = columns[label.index()].chunks_exact_mut(length);
        for (field, region) in fields.zip(regions) {
            let (width, shape, around) = (label.width(), context.shape, &block.around);
            let from = ValuesAround { place, field, width, shape, nodes, around, touched };
            context.isa.dispatch(LoadRegion { from, region });
        }
    }
}

/// Runs a node stage on one block, unless no particle touches its nodes and they keep nothing; returns whether it did.
pub fn update_nodes<const METERED: bool>(
    context: &Context<'_>,
    stage: &Stage,
    particles: &[Vec<ParticlePatch>],
    scratch: &mut Scratch,
    block: &mut NodeBlock,
) -> bool {
    let (shape, layout) = (context.shape, context.node_layout);
    let index = block.index;
    let split = block.split();
    let present = split.present;
    let around = |slot: usize, place, width| {
        let (material, field) = (context.fields.material(present[slot]), present[slot].index());
        let field = field - context.fields.of(material).start;
        Around { place, material, field, width, shape, particles, around: &split.around[slot] }
    };
    let touching: SmallVec<[Touching; 4]> =
        (0..present.len()).map(|slot| around(slot, 0, 0).touching()).collect();
    let known = |slot: &usize| !stage.unknown.contains(&context.fields.material(present[*slot]));
    if !stage.everywhere && (0..present.len()).filter(known).all(|slot| touching[slot].is_empty()) {
        return false;
    }
    let (mut laps, part) =
        (Laps::<METERED>::begin(&mut scratch.tally), |part| What::Part(stage.entries[0], part));
    let (mut columns, shared, fields) = scratch.lend();
    fields.clear();
    let times = present.iter().zip(split.until);
    fields.extend(times.map(|(&field, &until)| context.schedule.field(context.fields, field, until)));
    for (label, column) in layout.stored().iter().zip(split.columns) {
        columns[label.index()] = column;
    }
    for (place, &label) in layout.partial().iter().enumerate() {
        let column = std::mem::take(&mut columns[label.index()]);
        let length = layout.nodes * label.width();
        let lines = if is_there(label, present.len()) { length * present.len() } else { 0 };
        if stage.sums.contains(&label) {
            for (slot, sums) in column[..lines].chunks_exact_mut(length).enumerate() {
                let material = context.fields.material(present[slot]);
                if !stage.adders.contains(label, material) {
                    if !stage.kept.contains(label, material) {
                        reduction::clear(label.combine(), sums);
                    }
                    continue;
                }
                let (from, touching) = (around(slot, place, label.width()), touching[slot]);
                context.isa.dispatch(SumPartials { from, touching, combine: label.combine(), sums });
            }
        }
        // sums that live for a stage are not there without being added up
        if stage.sums.contains(&label) || label.life() != Life::Stage {
            columns[label.index()] = &mut column[..lines];
        }
    }
    laps.lap(part(StagePart::SumPartials));
    lend_shared(&mut columns, shared, None);
    let mut space = Workspace { columns, chunk: 0..0, ahead: 0, widths: &[] };
    let mut at = context.at(index);
    at.fields = fields;
    let traced = tracing::enabled!(tracing::Level::TRACE);
    laps.lap(part(StagePart::Setup));
    for &entry in &stage.entries {
        let _span = traced.then(|| context.span(entry).entered());
        context.task(entry).run_on(context.isa, &at, &mut space);
        laps.lap(What::Entry(entry));
    }
    scratch.columns = recycle(space.columns);
    laps.end(&mut scratch.tally);
    true
}

/// Runs a stage that has no place.
pub fn once<const METERED: bool>(
    context: &Context<'_>,
    stage: &Stage,
    shared: &mut Shared,
    scratch: &mut Scratch,
) {
    let mut laps = Laps::<METERED>::begin(&mut scratch.tally);
    let mut columns = no_columns(std::mem::take(&mut scratch.columns), context.recipe.schema.len());
    shared.columns_mut().for_each(|(label, column)| columns[label.index()] = column);
    let mut space = Workspace { columns, chunk: 0..0, ahead: 0, widths: &[] };
    let at = context.at([0; 3]);
    for &entry in &stage.entries {
        let _span = context.span(entry).entered();
        context.task(entry).run_on(context.isa, &at, &mut space);
        laps.lap(What::Entry(entry));
    }
    scratch.columns = recycle(space.columns);
    laps.end(&mut scratch.tally);
}

/// Puts shared labels into their columns: one material's tile, or all tiles.
fn lend_shared<'a>(columns: &mut [&'a mut [Wide]], shared: &'a mut Shared, material: Option<usize>) {
    for (label, column) in shared.columns_mut() {
        columns[label.index()] = match (label.home(), material) {
            (Home::Material, Some(m)) => &mut column[m * label.width()..(m + 1) * label.width()],
            _ => column,
        };
    }
}
