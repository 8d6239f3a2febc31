//! Cases as Sinew reads them and as the reference does, and their particles.
use crate::common::{Overrides, Random, scene};
use crate::laws::Law;
use crate::step::{Face, M3, Material, Model, Particle, V3};
use engine::data::layout::ParticleLayout;
use engine::data::particles::ParticleBlock;
use engine::schema::{Label, LabelId};
use physics::faces::AnyFaceCondition;
use scene::{Scene, ShapeFunction};
use simd::Isa;
use sinew::simulation::Simulation;
use tasks::labels::*;

/// Where the balls are [m], and where the first one flies.
const CENTERS: [V3; 2] = [V3::new(0.61, 3.72, -1.53), V3::new(3.07, 3.95, -1.71)];
const DIRECTION: V3 = V3::new(1.0, 0.3, -0.2);

/// Two balls of different materials that share nodes; they are not in contact and pass through each other.
pub struct Case {
    pub name: &'static str,
    pub laws: [Law; 2],
    pub densities: [f64; 2],
    /// Steps that are compared.
    pub steps: usize,
    /// Mean velocity of each ball along [`DIRECTION`] [m/s].
    pub speeds: [f64; 2],
    /// Size of a random rate of deformation of each ball [1/s].
    pub rate: f64,
    /// Size of random velocities of particles [m/s].
    pub noise: f64,
    /// Size of random displacements of particles [cells].
    pub jitter: f64,
    pub overrides: Overrides<'static>,
}

/// A scene of ragged numbers; the two materials have different particles.
fn text(case: &Case) -> String {
    let material = |name: &str, law: &Law, density: f64| {
        let law = match *law {
            Law::NeoHookean { bulk, shear } => {
                format!("law = \"neo-hookean\"\nbulk-modulus = {bulk:?}\nshear-modulus = {shear:?}")
            }
            Law::J2 { bulk, shear, yield_stress, hardening } => format!(
                "law = \"j2\"\nbulk-modulus = {bulk:?}\nshear-modulus = {shear:?}\nyield-stress = {yield_stress:?}\n\
                 hardening = {hardening:?}"
            ),
            Law::Tissue(t) => format!(
                "law = \"tissue\"\nc1 = {:?}\nc3 = {:?}\nc4 = {:?}\nc5 = {:?}\nlambda-star = {:?}\nbulk-modulus = {:?}\n\
                 failure = \"two-surface\"\nfiber-limit = {:?}\nmatrix-limit = {:?}",
                t.c1, t.c3, t.c4, t.c5, t.straight, t.bulk, t.fiber_limit, t.matrix_limit
            ),
        };
        format!("[material.{name}]\ndensity = {density:?}\n{law}\n")
    };
    let velocity = |m: usize| format!("{:?}", (DIRECTION * case.speeds[m]).as_slice());
    let [a, b] = [0, 1].map(|m| material(["a", "b"][m], &case.laws[m], case.densities[m]));
    format!(
        r#"
[domain]
lower = [-3.1, 0.2, -5.3]
upper = [7.26, 7.6, 2.1]
cell = 0.37
{a}{b}
[[body]]
name = "a"
material = "a"
shape = {{ sphere = {{ center = {:?}, radius = 1.27 }} }}
particles-per-cell = [3, 2, 1]
velocity = {}
fibers = {{ turning = {{ start = [1, 0, 0], axis = [0, 1, 0], from = 2.5, to = 5, angle = "120 deg" }} }}
[[body]]
name = "b"
material = "b"
shape = {{ sphere = {{ center = {:?}, radius = 1.11 }} }}
particles-per-cell = 2
velocity = {}
fibers = {{ uniform = [1, 2, -2] }}
[run]
until = 1e9
threads = 2
patches = [2, 1, 2]
"#,
        CENTERS[0].as_slice(),
        velocity(0),
        CENTERS[1].as_slice(),
        velocity(1)
    )
}

/// What the textbook needs of a scene.
fn model(scene: &Scene, laws: [Law; 2]) -> Model {
    let domain = &scene.domain;
    let material = |m: usize| {
        let body = scene.bodies.iter().find(|body| body.material == m).expect("a body");
        let half_size = V3::from(body.particles_per_cell.map(|n| 0.5 / n as f64 * domain.cell));
        Material { law: laws[m], density: scene.materials[m].density, half_size }
    };
    let face = |f: usize| match scene.faces[f] {
        AnyFaceCondition::Free(_) => Face::Free,
        AnyFaceCondition::Fixed(_) => Face::Fixed,
        AnyFaceCondition::Symmetric(_) => Face::Symmetric,
        _ => unimplemented!("the reference has no walls"),
    };
    Model {
        lower: domain.lower.into(),
        cells: domain.cells.map(|n| n as i32),
        h: domain.cell,
        gimp: scene.run.shape == ShapeFunction::Gimp,
        faces: [0, 1, 2].map(|a| [face(2 * a), face(2 * a + 1)]),
        gravity: scene.loads.gravity.at(0.0).into(),
        damping: scene.loads.damping,
        pic: scene.run.pic,
        viscosity: scene.run.viscosity.map_or(0.0, |law| {
            assert!(
                law.linear == 0.0,
                "the linear term needs the bound of the wave speed, which is Sinew's own"
            );
            law.quadratic
        }),
        materials: vec![material(0), material(1)],
    }
}

/// Shows each particle of Sinew to `change`.
pub fn each(
    simulation: &mut Simulation,
    mut change: impl FnMut(usize, &ParticleLayout, &mut ParticleBlock, usize),
) {
    let warehouse = &mut simulation.warehouse;
    for (material, home) in warehouse.particles.iter_mut().flat_map(|patch| patch.iter_mut().enumerate()) {
        for block in &mut home.blocks {
            (0..block.count).for_each(|p| change(material, &warehouse.materials[material].layout, block, p));
        }
    }
}

/// Starts a case: positions, masses, volumes and velocities of its particles are random.
pub fn start(case: &Case, isa: Isa) -> (Simulation, Model) {
    let scene = scene(&text(case), case.overrides);
    let model = model(&scene, case.laws);
    let mut simulation = Simulation::new(scene, isa).unwrap_or_else(|e| panic!("{e}"));
    let mut random = Random(11);
    let rate = [0, 1].map(|_| M3::from_fn(|_, _| random.sign()) * case.rate);
    each(&mut simulation, |material, layout, block, p| {
        let (heavier, larger) = (1.0 + 0.2 * random.sign(), 1.0 + 0.1 * random.sign());
        for (label, factor) in [(Mass::ID, heavier), (InitialVolume::ID, larger), (Volume::ID, larger)] {
            block.set(layout, label, p, 0, factor * block.get(layout, label, p, 0));
        }
        let x =
            V3::from_fn(|a, _| block.get(layout, Position::ID, p, a) + case.jitter * model.h * random.sign());
        let v = DIRECTION * case.speeds[material] + rate[material] * (x - CENTERS[material]);
        let v = v + V3::from(random.vector()) * case.noise;
        for a in 0..3 {
            block.set(layout, Position::ID, p, a, x[a]);
            block.set(layout, Velocity::ID, p, a, v[a]);
        }
    });
    (simulation, model)
}

/// The particles of Sinew, by identity.
pub fn particles(simulation: &Simulation) -> Vec<Particle> {
    let mut all = Vec::new();
    for (material, block) in simulation.warehouse.blocks() {
        let layout = &simulation.warehouse.materials[material].layout;
        for p in 0..block.count {
            let get = |label: LabelId, c: usize| block.get(layout, label, p, c);
            let vector = |label: LabelId| V3::from_fn(|a, _| get(label, a));
            let t: [f64; 6] = std::array::from_fn(|c| get(KirchhoffStress::ID, c));
            all.push(Particle {
                identity: get(Identity::ID, 0).to_bits(),
                material,
                mass: get(Mass::ID, 0),
                initial_volume: get(InitialVolume::ID, 0),
                volume: get(Volume::ID, 0),
                x: vector(Position::ID),
                v: vector(Velocity::ID),
                f: M3::from_fn(|i, j| get(Deformation::ID, 3 * i + j)),
                kirchhoff: M3::new(t[0], t[1], t[2], t[1], t[3], t[4], t[2], t[4], t[5]),
                history: (0..layout.width(History::ID)).map(|c| get(History::ID, c)).collect(),
            });
        }
    }
    all.sort_by_key(|p| p.identity);
    all
}
