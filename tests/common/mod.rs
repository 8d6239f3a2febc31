//! Small scenes, and simulations of them.
#![allow(dead_code)] // each test takes what it needs
#![allow(clippy::result_large_err)] // errors are rare here
use engine::data::schedule::FieldTime;
use engine::graph::task::At;
use engine::schema::Label;
use engine::schema::LabelId;
use grid::{IndexBox, NODES, Origin};
use scene::Scene;
use simd::Isa;
use sinew::input::{read, read_text};
use sinew::simulation::{GiverReport, Report, RunError, Simulation};
use std::path::Path;
use tasks::labels;
use tasks::rigid::state::RigidState;

pub mod command;
pub mod rubber;
mod splitmix;
#[allow(unused_imports)] // each test takes what it needs
pub use splitmix::Random;

pub type Overrides<'a> = &'a [(&'a str, &'a str)];

fn owned(overrides: Overrides<'_>) -> Vec<(String, String)> {
    overrides.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect()
}

/// The scene of a text, with overrides.
#[track_caller]
pub fn scene(text: &str, overrides: Overrides<'_>) -> Scene {
    read_text("test", text, &owned(overrides), None)
        .unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e)))
}

/// A scene of `problems/`, with overrides.
#[track_caller]
pub fn problem(name: &str, overrides: Overrides<'_>) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems").join(name);
    read(&folder, &owned(overrides)).unwrap_or_else(|e| panic!("{:?}", miette::Report::new(e)))
}

/// The quick slab with a ball of soft lead, so that some 40 steps shoot it through the slab.
#[track_caller]
pub fn soft_shot(steps: &str, overrides: Overrides<'_>) -> Scene {
    let soft = [
        ("material.lead.bulk-modulus", "46 MPa"),
        ("material.lead.shear-modulus", "5.6 MPa"),
        ("material.lead.yield-stress", "0.2 MPa"),
        ("body.bullet.shape.sphere.center.1", "4.6 mm"),
        ("run.steps", steps),
    ];
    problem("slab-quick", &[&soft, overrides].concat())
}

pub fn instruction_sets() -> Vec<Isa> {
    Isa::available()
}

/// Starts a scene on the best instruction set.
#[track_caller]
pub fn start(scene: Scene) -> Simulation {
    Simulation::new(scene, Isa::detect()).unwrap_or_else(|e| panic!("{e}"))
}

/// Steps to the end of the run.
pub fn finish(simulation: &mut Simulation) -> Result<Report, RunError> {
    while simulation.step()? {}
    Ok(simulation.report()?)
}

/// Steps until a time [s] is reached.
#[track_caller]
pub fn until(simulation: &mut Simulation, time: f64) {
    while simulation.clock().time < time {
        simulation.step().expect("steps");
    }
}

/// The report at the end of a scene.
#[track_caller]
pub fn run(scene: Scene) -> Report {
    let mut simulation = start(scene);
    finish(&mut simulation).unwrap_or_else(|e| panic!("{e}"))
}

/// What a report says of a giver.
#[track_caller]
pub fn giver<'a>(report: &'a Report, name: &str) -> &'a GiverReport {
    report.givers.iter().find(|it| it.name == name).unwrap_or_else(|| panic!("{name} gives nothing"))
}

/// Momentum of all materials [N s].
pub fn momentum(report: &Report) -> [f64; 3] {
    report.materials.iter().fold([0.0; 3], |sum, m| add(sum, m.momentum))
}

/// Angular momentum of all materials about the origin [N m s].
pub fn angular_momentum(report: &Report) -> [f64; 3] {
    report.materials.iter().fold([0.0; 3], |sum, m| add(sum, m.angular_momentum))
}

/// All numbers of a label, particle by particle, in the order of the blocks.
pub fn numbers(simulation: &Simulation, label: LabelId) -> Vec<Vec<f64>> {
    let mut all = Vec::new();
    for (material, block) in simulation.warehouse.blocks() {
        let layout = &simulation.warehouse.materials[material].layout;
        let width = layout.widths[label.index()];
        all.extend((0..block.count).map(|p| (0..width).map(|c| block.get(layout, label, p, c)).collect()));
    }
    all
}

/// The state of a rigid material.
pub fn body(simulation: &Simulation, material: usize) -> RigidState {
    simulation.warehouse.shared.get(labels::RigidMotion::ID, material)
}

/// The slope of the line through points, by least squares.
pub fn slope(points: impl Iterator<Item = [f64; 2]>) -> f64 {
    let points: Vec<[f64; 2]> = points.collect();
    let mean = |a: usize| points.iter().map(|p| p[a]).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(0), mean(1));
    let [xy, xx] =
        points.iter().fold([0.0; 2], |[xy, xx], p| [xy + (p[0] - x) * (p[1] - y), xx + (p[0] - x).powi(2)]);
    xy / xx
}

/// Where a task runs on a block of which nothing is known.
pub fn place(origin: Origin, count: usize, fields: &[FieldTime]) -> At<'_> {
    let (node, touched) = ([0; 3], IndexBox { lower: [0; 3], upper: [0; 3] });
    At { origin, count, node, nodes: NODES, touched, fields }
}

/// Gives every particle the velocity `field(x)`, as if the scene had said so.
pub fn set_velocity(simulation: &mut Simulation, mut field: impl FnMut([f64; 3]) -> [f64; 3]) {
    let warehouse = &mut simulation.warehouse;
    for (material, home) in warehouse.particles.iter_mut().flat_map(|patch| patch.iter_mut().enumerate()) {
        let layout = &warehouse.materials[material].layout;
        for block in &mut home.blocks {
            for particle in 0..block.count {
                let x = [0, 1, 2].map(|a| block.get(layout, labels::Position::ID, particle, a));
                for (a, v) in field(x).into_iter().enumerate() {
                    block.set(layout, labels::Velocity::ID, particle, a, v);
                }
            }
        }
    }
}

pub fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + b[i])
}

pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

pub fn norm(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Tasks that declare and do nothing.
#[allow(unused_macros)]
macro_rules! tasks {
    ($($domain:ident $module:ident $name:ident { $($declaration:tt)* })*) => {$(
        #[allow(dead_code)]
        mod $module {
            use super::*;
            engine::task! {
                /// Declares, and does nothing.
                pub struct $name;
                $domain task { $($declaration)* }
            }
            impl engine::graph::task::Body for $name {
                fn run<S: simd::Simd>(&self, _at: &engine::graph::task::At<'_>, _io: Io<'_>) {}
            }
        }
        #[allow(unused_imports)]
        pub(crate) use $module::$name;
    )*};
}
#[allow(unused_imports)]
pub(crate) use tasks;
