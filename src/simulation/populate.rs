//! From bodies to particles.
use super::fault::RunError;
use super::surfaces::Surfaces;
use engine::data::layout::ParticleLayout;
use engine::data::nearby::Nearby;
use engine::data::rates::Clock;
use engine::data::warehouse::{MaterialData, Warehouse};
use engine::program::Program;
use engine::schema::{Label, LabelId, Tiles};
use grid::{BLOCK, Decomposition, Partition, REACH};
use nalgebra::{Matrix3, Vector3};
use physics::contact::cross;
use physics::law::{Law, Reference};
use physics::materials::WithLaw;
use scene::{Behavior, Rates, RigidMotion, Scene, sampling};
use tasks::labels::RigidMotion as RigidMotionLabel;
use tasks::labels::{
    Bond, Deformation, DriveIndex, ForceIndex, History, Identity, InitialPosition, InitialVolume, Mass,
    Position, ReferencePosition, SCHEMA, SurfaceArea, Time, UNDEFORMED, Velocity, Volume,
};
use tasks::recipes::{self, Givers};
use tasks::rigid::state::RigidState;

/// Puts the particles of `scene` into the patches of this rank.
///
/// # Errors
/// Bodies that do not fit the level, or differ in resolution within a material.
pub fn populate(scene: &Scene, warehouse: &mut Warehouse) -> Result<(), RunError> {
    let (mut identity, surfaces) = (0, Surfaces::of(scene));
    for (index, body) in scene.bodies.iter().enumerate() {
        let first = scene.bodies.iter().find(|b| b.material == body.material);
        if first.is_some_and(|b| b.particles_per_cell != body.particles_per_cell) {
            let material = scene.materials[body.material].name.clone();
            return Err(RunError::Resolution { material });
        }
        if scene.materials[body.material].has_particles() {
            add_body(scene, &surfaces, index, warehouse, &mut identity)?;
        }
    }
    let clock = Clock { until: scene.run.until, ..bytemuck::Zeroable::zeroed() };
    warehouse.shared.set(Time::ID, 0, clock);
    place_bodies(scene, warehouse);
    Ok(())
}

/// Tells particles that come from a checkpoint what is known from the start: where they were.
pub fn recall(scene: &Scene, warehouse: &mut Warehouse) {
    if !scene.shows_start() {
        return;
    }
    let starts: Vec<[f64; 3]> = sampling::all(scene).map(|(_, x)| x).collect();
    let materials = &warehouse.materials;
    for (material, home) in warehouse.particles.iter_mut().flat_map(|patch| patch.iter_mut().enumerate()) {
        let layout = &materials[material].layout;
        for block in &mut home.blocks {
            for particle in 0..block.count {
                let identity = block.get(layout, Identity::ID, particle, 0).to_bits();
                // a crafted checkpoint may have any
                let start = starts.get(identity as usize).copied().unwrap_or([f64::NAN; 3]);
                (0..3).for_each(|a| block.set(layout, InitialPosition::ID, particle, a, start[a]));
            }
        }
    }
}

/// Puts rigid bodies where they are at the start.
pub fn place_bodies(scene: &Scene, warehouse: &mut Warehouse) {
    (0..scene.materials.len()).for_each(|m| start_rigid(scene, warehouse, m));
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
    let history = initial_history(&scene.materials[material].behavior, reference);
    ParticleLayout::new(&SCHEMA, labels, [(History::ID, history)].into())
}

struct Initial(Reference);
impl WithLaw for Initial {
    type Output = Vec<f64>;
    fn with<L: Law>(self, law: L) -> Vec<f64> {
        let mut history = vec![0.0; L::HISTORY.len()];
        law.initial(&self.0, &mut history);
        history
    }
}

fn initial_history(behavior: &Behavior, reference: Reference) -> Vec<f64> {
    match behavior {
        Behavior::Deformable(law) => law.visit(Initial(reference)),
        Behavior::Rigid(_) => Vec::new(),
    }
}

fn add_body(
    scene: &Scene,
    surfaces: &Surfaces<'_>,
    index: usize,
    warehouse: &mut Warehouse,
    identity: &mut u64,
) -> Result<(), RunError> {
    let body = &scene.bodies[index];
    let material = &scene.materials[body.material];
    let layout = warehouse.materials[body.material].layout.clone();
    let volume = sampling::particle_volume(scene, body);
    let (j, mut stretched) = (body.stretch.iter().product::<f64>(), UNDEFORMED);
    (0..3).for_each(|a| stretched[4 * a] = body.stretch[a]);
    let center = if body.angular_velocity == [0.0; 3] { [0.0; 3] } else { sampling::middle(scene, body) };
    let outside = |_| RunError::Outside { body: body.name.clone() };
    // what a scene does not say is as where there is no particle
    let inert = layout.inert_record([0.0; 3]);
    let mut record = inert.clone();
    for x in sampling::sample(scene, body) {
        let (_, patch) = warehouse.home(body.material, x).map_err(outside)?;
        let this = *identity;
        *identity += 1;
        if !warehouse.partition.is_mine(patch) {
            continue;
        }
        let reference = Reference { fiber: sampling::fiber_at(&body.fibers, x), stretch: body.stretch };
        let history = initial_history(&material.behavior, reference);
        let holds = |d: &scene::Drive| d.material == body.material && d.region.contains(index, x);
        let drive = scene.drives.iter().position(holds);
        if let Some(first) = drive
            && let Some(other) = scene.drives[first + 1..].iter().find(|d| holds(d))
        {
            let names = [scene.drives[first].name.clone(), other.name.clone()];
            return Err(RunError::TwoDrives { names, position: x });
        }
        let force = surfaces.on(index, x)?;
        record.copy_from_slice(&inert);
        let mut set = |label: LabelId, numbers: &[f64]| {
            let width = layout.width(label);
            record[layout.starts[label.index()]..][..width].copy_from_slice(&numbers[..width]);
        };
        set(Position::ID, &x);
        set(InitialPosition::ID, &x);
        let turned = cross(body.angular_velocity, std::array::from_fn(|a| x[a] - center[a]));
        set(Velocity::ID, &[0, 1, 2].map(|a| body.velocity[a] + turned[a]));
        set(Mass::ID, &[material.density * volume / j]);
        set(InitialVolume::ID, &[volume / j]);
        set(Deformation::ID, &stretched);
        set(Volume::ID, &[volume]);
        set(History::ID, &history);
        set(Bond::ID, &[1.0]);
        set(ForceIndex::ID, &[force.map_or(0.0, |(number, _)| number as f64 + 1.0)]);
        set(SurfaceArea::ID, &force.map_or([0.0; 3], |(_, area)| area));
        set(DriveIndex::ID, &[drive.map_or(0.0, |d| d as f64 + 1.0)]);
        set(Identity::ID, &[f64::from_bits(this)]);
        warehouse.insert(body.material, x, &record).map_err(outside)?;
    }
    Ok(())
}

/// Mass, center, inertia and motion of a rigid material, and the reference positions of its particles.
fn start_rigid(scene: &Scene, warehouse: &mut Warehouse, material: usize) {
    let Behavior::Rigid(motion) = &scene.materials[material].behavior else { return };
    // in the order of identities, over all ranks' particles, so that no decomposition changes a bit
    let bodies = || scene.bodies.iter().filter(|body| body.material == material);
    let particles = || {
        bodies().flat_map(|body| {
            let m = scene.materials[material].density * sampling::particle_volume(scene, body);
            let edges = Vector3::from(body.particles_per_cell.map(|n| scene.domain.cell / n as f64));
            let v = Vector3::from(body.velocity);
            sampling::sample(scene, body).map(move |x| (m, Vector3::from(x), v, edges))
        })
    };
    let (mut mass, mut moment, mut momentum) = (0.0, Vector3::zeros(), Vector3::zeros());
    let mut second = Matrix3::zeros();
    for (m, x, v, _) in particles() {
        mass += m;
        moment += m * x;
        momentum += m * v;
    }
    let center = moment / mass;
    for (m, x, _, edges) in particles() {
        let r = x - center;
        second += m * (Matrix3::identity() * r.norm_squared() - r * r.transpose());
        // of the particle itself, a box
        let square = edges.component_mul(&edges);
        let own = Vector3::new(square.y + square.z, square.z + square.x, square.x + square.y);
        second += Matrix3::from_diagonal(&(m / 12.0 * own));
    }
    let (center, velocity, angular, free) = match motion {
        RigidMotion::Free { angular_velocity, locked, locked_turns, .. } => {
            let held =
                |v: [f64; 3], locked: &[bool; 3]| std::array::from_fn(|a| if locked[a] { 0.0 } else { v[a] });
            let (v, w) = (held((momentum / mass).into(), locked), held(*angular_velocity, locked_turns));
            (center, v, w, 1.0)
        }
        // of a tool only its center counts: where it says, or that of what is in the domain
        RigidMotion::Prescribed { center: given, .. } => {
            let within = mass > 0.0;
            let center = if within { center } else { recipes::middle(&scene.shape(material)).into() };
            (given.map_or(center, Vector3::from), [0.0; 3], [0.0; 3], 0.0)
        }
    };
    let mut body = RigidState {
        // what is there and has no mass would not be there
        mass: if mass > 0.0 { mass } else { f64::MIN_POSITIVE },
        center: center.into(),
        velocity,
        angular,
        free,
        origin: center.into(),
        inertia: std::array::from_fn(|n| second[(n / 3, n % 3)]),
        ..bytemuck::Zeroable::zeroed()
    };
    (0..3).for_each(|a| body.rotation[4 * a] = 1.0);
    warehouse.shared.set(RigidMotionLabel::ID, material, body);
    let layout = warehouse.materials[material].layout.clone();
    for block in warehouse.particles.iter_mut().flat_map(|patch| &mut patch[material].blocks) {
        for particle in 0..block.count {
            for a in 0..3 {
                let r = block.get(&layout, Position::ID, particle, a) - center[a];
                block.set(&layout, ReferencePosition::ID, particle, a, r);
            }
        }
    }
}
