//! From bodies to particles.
use super::fault::RunError;
use super::start::census::Blocks;
use super::start::maker::{self, Clash, Maker};
use super::start::{self, Roll};
use super::surfaces::Surfaces;
use engine::data::layout::ParticleLayout;
use engine::data::nearby::Nearby;
use engine::data::particles::ParticleBlock;
use engine::data::rates::Clock;
use engine::data::warehouse::{MaterialData, ParticlePatch, Warehouse};
use engine::exec::ranks::Network;
use engine::exec::{Executor, Serial, Threads};
use engine::program::Program;
use engine::schema::{Label, LabelId, Tiles};
use grid::{BLOCK, BlockIndex, Decomposition, IndexBox, Partition, REACH};
use physics::law::Reference;
use scene::sampling::{Numbering, Pencils, Span, size};
use scene::{Rates, Scene};
use tasks::labels::RigidMotion as RigidMotionLabel;
use tasks::labels::{History, Identity, InitialPosition, Mass, Position, SCHEMA, Time, Velocity};
use tasks::recipes::{self, Givers};
use tasks::rigid::state::RigidState;

/// Puts the particles of `scene` into the patches of this rank, some threads at once. All ranks call it, and each looks at what
/// lies in its patches.
///
/// # Errors
/// Bodies that differ in resolution within a material, a particle that two drives or forces claim, threads that do not start, a rank
/// that is gone.
pub fn populate(
    scene: &Scene,
    roll: &Roll,
    warehouse: &mut Warehouse,
    network: &mut dyn Network,
    threads: usize,
) -> Result<(), RunError> {
    for body in &scene.bodies {
        let first = scene.bodies.iter().find(|b| b.material == body.material);
        if first.is_some_and(|b| b.particles_per_cell != body.particles_per_cell) {
            let material = scene.materials[body.material].name.clone();
            return Err(RunError::Resolution { material });
        }
    }
    let surfaces = Surfaces::of(scene, roll, network)?;
    let mut makers = Vec::new();
    for (index, body) in scene.bodies.iter().enumerate() {
        // turning bodies need it; all ranks ask for it in this order
        let turns = body.angular_velocity != [0.0; 3];
        let center = if turns { start::center(scene, body, network)? } else { [0.0; 3] };
        makers.extend(roll.of(index).map(|_| Maker::new(scene, &surfaces, index, center, warehouse)));
    }
    let clash = fill(roll, makers, warehouse, threads)?;
    Clash::agree(clash, scene, network)?;
    let clock = Clock { until: scene.run.until, ..bytemuck::Zeroable::zeroed() };
    warehouse.shared.set(Time::ID, 0, clock);
    start::place_bodies(scene, warehouse, network)?;
    Ok(())
}

/// Fills the patches of this rank with the particles of bodies, one body after the other; the first particle that is claimed twice.
fn fill(
    roll: &Roll,
    makers: Vec<Maker<'_>>,
    warehouse: &mut Warehouse,
    threads: usize,
) -> Result<Option<Clash>, RunError> {
    let Warehouse { level, decomposition, partition, materials, node_layout, particles, .. } = warehouse;
    let (level, patches) = (&*level, &decomposition.patches);
    let blocks = |maker: &Maker<'_>| {
        let filling = roll.of(maker.index)?.filling();
        Some(Blocks::new(level, materials[maker.material].half_size, filling))
    };
    let blocks: Vec<Option<Blocks<'_>>> = makers.iter().map(blocks).collect();
    let mine = particles.iter_mut().enumerate().filter(|(patch, _)| partition.is_mine(*patch));
    let mut items: Vec<_> = mine.map(|(patch, homes)| (patches[patch].blocks, homes, None)).collect();
    let work = |_: usize, (reach, homes, clash): &mut (IndexBox, &mut Vec<ParticlePatch>, Option<Clash>)| {
        for (maker, blocks) in makers.iter().zip(&blocks) {
            let (Some(numbering), Some(blocks)) = (roll.of(maker.index), blocks) else { continue };
            let mut list = Vec::new();
            let (home, data) = (&mut homes[maker.material], &materials[maker.material]);
            let into = (level, data, &*node_layout);
            blocks.visit(reach, &mut |index, points, all| {
                if all {
                    home.reserve(into, index, size(&points) as usize);
                }
                list.push((index, points));
            });
            if list.is_empty() {
                continue;
            }
            let (mut maker, first) = (maker.clone(), roll.identities(maker.index).start);
            fill_blocks(numbering, list, &mut |index, number, x| {
                home.push(into, index, x, maker.make(first + number, x));
            });
            *clash = [*clash, maker.clash].into_iter().flatten().min();
        }
    };
    match threads {
        1 => Serial.each(&mut items, work),
        n => Threads::new(n)?.each(&mut items, work),
    }
    let clash = items.into_iter().filter_map(|(.., clash)| clash).min();
    warehouse.reactivate = true;
    Ok(clash)
}

/// Hands out the particles of a body in some blocks, block by block, with their blocks and numbers; within a block in the order of
/// these.
fn fill_blocks(
    numbering: &Numbering,
    mut blocks: Vec<(BlockIndex, Span)>,
    each: &mut impl FnMut(BlockIndex, u64, [f64; 3]),
) {
    // in columns along z, so that what lies below a block is counted once
    blocks.sort_unstable_by_key(|(index, _)| *index);
    let mut pencils = Pencils::default();
    for (index, points) in blocks {
        numbering.fill(&points, &mut pencils, &mut |number, x| each(index, number, x));
    }
}

/// Tells particles that come from a checkpoint what is known from the start: where they were.
pub fn recall(scene: &Scene, roll: &Roll, warehouse: &mut Warehouse) {
    if !scene.shows_start() {
        return;
    }
    let Warehouse { partition, particles, materials, .. } = warehouse;
    for patch in partition.mine() {
        for (material, home) in particles[patch].iter_mut().enumerate() {
            recall_home(scene, roll, (material, &materials[material].layout), &mut home.blocks);
        }
    }
}

fn recall_home(
    scene: &Scene,
    roll: &Roll,
    (material, layout): (usize, &ParticleLayout),
    blocks: &mut [ParticleBlock],
) {
    // by identity, so that each row of a lattice is looked at once
    let (mut slots, mut wanted) = (Vec::new(), Vec::new());
    for (at, block) in blocks.iter().enumerate() {
        for particle in 0..block.count {
            wanted.push((block.get(layout, Identity::ID, particle, 0).to_bits(), slots.len()));
            slots.push((at, particle));
        }
    }
    wanted.sort_unstable();
    // a crafted checkpoint may have any
    let mut starts = vec![[f64::NAN; 3]; slots.len()];
    for body in (0..scene.bodies.len()).filter(|&body| scene.bodies[body].material == material) {
        let (Some(numbering), identities) = (roll.of(body), roll.identities(body)) else { continue };
        let from = wanted.partition_point(|(identity, _)| *identity < identities.start);
        let to = wanted.partition_point(|(identity, _)| *identity < identities.end);
        let own: Vec<_> = wanted[from..to].iter().map(|&(it, slot)| (it - identities.start, slot)).collect();
        numbering.places(&own, &mut |slot, x| starts[slot] = x);
    }
    for ((at, particle), start) in slots.into_iter().zip(starts) {
        (0..3).for_each(|a| blocks[at].set(layout, InitialPosition::ID, particle, a, start[a]));
    }
}

/// A warehouse for `scene` without particles; `layout` says which labels a material has.
pub fn empty(
    scene: &Scene,
    decomposition: Decomposition,
    partition: Partition,
    layout: impl Fn(usize) -> ParticleLayout,
    node_labels: impl IntoIterator<Item = LabelId>,
    tiles: &Tiles,
) -> Warehouse {
    let touches = |a: usize, b: usize| scene.contacts.iter().any(|c| c.between == [a.min(b), a.max(b)]);
    let (all, fields) = (0..scene.materials.len(), recipes::fields(scene));
    let materials = all.clone().map(|material| MaterialData {
        name: scene.materials[material].name.clone(),
        layout: layout(material),
        half_size: recipes::half_size(scene, material),
        fields: fields.of(material).len(),
        interacts: all.clone().map(|other| touches(material, other)).collect(),
    });
    let (level, cut) = (super::layout::level(scene), (decomposition, partition));
    let mut warehouse = Warehouse::new(&SCHEMA, level, cut, materials.collect(), node_labels);
    warehouse.set_tiles(tiles);
    warehouse.nearby = nearby(scene);
    warehouse.own_rates = scene.run.rates != Rates::Common;
    warehouse
}

/// Blocks are near a tool if it comes within the nodes that their particles touch, and two cells.
fn nearby(scene: &Scene) -> Option<Nearby> {
    let tools = recipes::tools(scene, &Givers::of(scene));
    // from the middle of a block to the farthest corner of its buffer
    let reach = (3f64.sqrt() * (0.5 * f64::from(BLOCK) + f64::from(REACH)) + 2.0) * scene.domain.cell;
    (!tools.is_empty()).then(|| {
        Nearby::new(move |shared, material, middle| {
            let clock: Clock = shared.get(Time::ID, 0);
            let bodies: &[RigidState] = bytemuck::cast_slice(shared.column(RigidMotionLabel::ID));
            tools.iter().any(|tool| tool.meets(material) && tool.is_beside(&clock, bodies, middle, reach))
        })
    })
}

/// The labels that the tasks of `program` need of a material's particles, and those that every run needs.
pub fn layout_of(scene: &Scene, program: &Program, material: usize) -> ParticleLayout {
    let always = [Identity::ID, Position::ID, Velocity::ID, Mass::ID];
    let shown = scene.shows_start().then_some(InitialPosition::ID);
    let labels = program.particle_labels(material).into_iter().chain(always).chain(shown);
    let reference = Reference { fiber: [1.0, 0.0, 0.0], stretch: [1.0; 3] };
    let history = maker::history(&scene.materials[material].behavior, reference);
    ParticleLayout::new(&SCHEMA, labels, [(History::ID, history)].into())
}
