//! From bodies to particles.
use super::fault::RunError;
use crate::data::labels::LabelId;
use crate::data::particles::Layout;
use crate::data::shared::{Clock, RigidState};
use crate::data::warehouse::{MaterialData, Warehouse};
use crate::graph::build::TaskGraph;
use crate::grid::{Decomposition, Partition};
use crate::input::lattice;
use crate::input::scene::{Behavior, Body, Rates, RigidMotion, Scene};
use crate::physics::law::{Declared, Law, Reference};
use crate::physics::materials::WithLaw;
use crate::tasks::timestep;
use nalgebra::{Matrix3, Vector3};

/// Puts the particles of `scene` into the patches of this rank.
///
/// # Errors
/// Bodies that do not fit the level, or differ in resolution within a material.
pub fn populate(scene: &Scene, warehouse: &mut Warehouse) -> Result<(), RunError> {
    let mut identity = 0;
    for body in &scene.bodies {
        let first = scene.bodies.iter().find(|b| b.material == body.material);
        if first.is_some_and(|b| b.particles_per_cell != body.particles_per_cell) {
            let material = scene.materials[body.material].name.clone();
            return Err(RunError::Resolution { material });
        }
        add_body(scene, body, warehouse, &mut identity)?;
    }
    let clock = Clock { until: scene.run.until, ..bytemuck::Zeroable::zeroed() };
    warehouse.shared.set(LabelId::Time, 0, clock);
    (0..scene.materials.len()).for_each(|m| start_rigid(scene, warehouse, m));
    Ok(())
}

/// A warehouse for `scene` without particles; `layout` says which labels a material has.
pub fn empty(
    scene: &Scene,
    decomposition: Decomposition,
    partition: Partition,
    layout: impl Fn(usize) -> Layout,
) -> Warehouse {
    let touches = |a: usize, b: usize| scene.contacts.iter().any(|c| c.between == [a.min(b), a.max(b)]);
    let all = 0..scene.materials.len();
    let materials = all.clone().map(|material| MaterialData {
        name: scene.materials[material].name.clone(),
        layout: layout(material),
        half_size: timestep::half_size(scene, material),
        contacts: all.clone().map(|other| touches(material, other)).collect(),
    });
    let mut warehouse =
        Warehouse::new(super::layout::level(scene), decomposition, partition, materials.collect());
    warehouse.own_rates = scene.run.rates != Rates::Common;
    warehouse
}

/// The labels that the tasks of `graph` need of a material's particles, and those that every run needs.
pub fn layout_of(scene: &Scene, graph: &TaskGraph, material: usize) -> Layout {
    let always = [LabelId::Identity, LabelId::Position, LabelId::Velocity, LabelId::Mass];
    let labels = graph.particle_labels(material).into_iter().chain(always);
    let reference = Reference { fiber: [1.0, 0.0, 0.0] };
    Layout::new(labels, initial_history(&scene.materials[material].behavior, reference))
}

/// What a material's law declares.
pub fn declared(behavior: &Behavior) -> Declared {
    match behavior {
        Behavior::Deformable(law) => law.visit(DeclaredBy),
        Behavior::Rigid(_) => Declared::default(),
    }
}

struct DeclaredBy;
impl WithLaw for DeclaredBy {
    type Output = Declared;
    fn with<L: Law>(self, _law: L) -> Declared {
        Declared::by::<L>()
    }
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
    body: &Body,
    warehouse: &mut Warehouse,
    identity: &mut u64,
) -> Result<(), RunError> {
    let material = &scene.materials[body.material];
    let layout = warehouse.materials[body.material].layout.clone();
    let volume = lattice::particle_volume(scene, body);
    let outside = |_| RunError::Outside { body: body.name.clone() };
    for x in lattice::sample(scene, body) {
        let (_, patch) = warehouse.home(body.material, x).map_err(outside)?;
        let this = *identity;
        *identity += 1;
        if !warehouse.partition.is_mine(patch) {
            continue;
        }
        let reference = Reference { fiber: lattice::fiber_at(&body.fibers, x) };
        let history = initial_history(&material.behavior, reference);
        let drive = scene.drives.iter().position(|d| d.material == body.material && d.region.contains(x));
        let mut record = Vec::with_capacity(layout.total);
        for label in layout.labels() {
            match label {
                LabelId::Position => record.extend(x),
                LabelId::Velocity => record.extend(body.velocity),
                LabelId::Mass => record.push(material.density * volume),
                LabelId::InitialVolume | LabelId::Volume => record.push(volume),
                LabelId::Deformation => record.extend([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
                LabelId::History => record.extend(&history),
                LabelId::DriveIndex => record.push(drive.map_or(0.0, |d| d as f64 + 1.0)),
                LabelId::Identity => record.push(f64::from_bits(this)),
                other => record.extend(std::iter::repeat_n(0.0, other.width())),
            }
        }
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
            let m = scene.materials[material].density * lattice::particle_volume(scene, body);
            lattice::sample(scene, body).map(move |x| (m, Vector3::from(x), Vector3::from(body.velocity)))
        })
    };
    let (mut mass, mut moment, mut momentum) = (0.0, Vector3::zeros(), Vector3::zeros());
    let mut second = Matrix3::zeros();
    for (m, x, v) in particles() {
        mass += m;
        moment += m * x;
        momentum += m * v;
    }
    let center = moment / mass;
    for (m, x, _) in particles() {
        let r = x - center;
        second += m * (Matrix3::identity() * r.norm_squared() - r * r.transpose());
    }
    let (velocity, angular, free) = match motion {
        RigidMotion::Free { angular_velocity } => ((momentum / mass).into(), *angular_velocity, 1.0),
        RigidMotion::Prescribed { velocity, angular_velocity } => (velocity.at(0.0), *angular_velocity, 0.0),
    };
    let mut body = RigidState {
        mass,
        center: center.into(),
        velocity,
        angular,
        free,
        inertia: std::array::from_fn(|n| second[(n / 3, n % 3)]),
        ..bytemuck::Zeroable::zeroed()
    };
    (0..3).for_each(|a| body.rotation[4 * a] = 1.0);
    warehouse.shared.set(LabelId::RigidMotion, material, body);
    let layout = warehouse.materials[material].layout.clone();
    for block in warehouse.particles.iter_mut().flat_map(|patch| &mut patch[material].blocks) {
        for particle in 0..block.count {
            for a in 0..3 {
                let r = block.get(&layout, LabelId::Position, particle, a) - center[a];
                block.set(&layout, LabelId::ReferencePosition, particle, a, r);
            }
        }
    }
}
