//! Materials with time steps of their own: the common step where it must be, momentum always, energy and the outcome
//! within what the step size does anyway.

use crate::common::{
    Overrides, add, angular_momentum, finish, minus, momentum, norm, problem, run, scene, start,
};
use scene::Scene;
use sinew::simulation::{MaterialReport, Report, Simulation};

/// A hard and a soft ball, and a rigid one, that meet; sound is 30 times faster in the hard one.
const MEETING: &str = r#"
[domain]
lower = [-8, -8, -8]
upper = [8, 8, 8]
cell = 0.8
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "0.6 MPa"
[material.middle]
law = "neo-hookean"
density = 1000
bulk-modulus = "30 MPa"
shear-modulus = "20 MPa"
[material.hard]
law = "neo-hookean"
density = 2000
bulk-modulus = "2 GPa"
shear-modulus = "1 GPa"
[[body]]
name = "a"
material = "soft"
shape = { sphere = { center = [-2.2, -2.0, -2.1], radius = 2.4 } }
velocity = [6, 5, 4]
[[body]]
name = "b"
material = "middle"
particles-per-cell = [2, 3, 2]
shape = { sphere = { center = [2.2, -4.2, -2.4], radius = 1.7 } }
velocity = [-8, 6, 1]
[[body]]
name = "c"
material = "hard"
shape = { sphere = { center = [1.2, 0.9, 0.8], radius = 1.8 } }
velocity = [-5, -6, -5]
[[contact]]
between = ["soft", "hard"]
law = "friction"
friction = 0.3
[[contact]]
between = ["soft", "middle"]
law = "friction"
friction = 0.3
[[contact]]
between = ["middle", "hard"]
law = "friction"
friction = 0.1
[run]
until = "0.2 s"
rates = "per-material"
[output]
frames = 0
"#;

/// Ends at the same time, whatever the steps.
fn end(scene: Scene) -> (Simulation, Report) {
    let mut simulation = start(scene);
    let report = finish(&mut simulation).unwrap_or_else(|e| panic!("{e}"));
    (simulation, report)
}

#[test]
fn one_substep_is_the_common_step_bit_by_bit() {
    let short = [("run.steps", "150")];
    let same = |of: &dyn Fn(Overrides<'_>) -> Scene| {
        let hash = |more: Overrides<'_>| {
            let (mut simulation, report) = end(of(&[&short, more].concat()));
            (simulation.state_hash(), format!("{report:?}"))
        };
        let common = hash(&[("run.rates", "common")]);
        assert_eq!(hash(&[("run.rates", "per-material"), ("run.most-substeps", "1")]), common);
        assert_ne!(hash(&[("run.rates", "per-material")]), common, "rates of their own change the result");
    };
    same(&|overrides| scene(MEETING, overrides));
    same(&|overrides| problem("slab-quick", overrides));
}

#[test]
fn every_material_is_where_it_flies_at_the_end_of_every_step() {
    let mut simulation = start(scene(MEETING, &[("contact", ""), ("run.steps", "40")]));
    let before = simulation.report().expect("one rank");
    let mut ticks = 0;
    while simulation.step().unwrap_or_else(|e| panic!("{e}")) {
        let now = simulation.report().expect("one rank");
        let more = simulation.ticks() - ticks;
        ticks = simulation.ticks();
        assert!(more > 20 && more <= 256 || simulation.finished(), "{more} ticks a step");
        for (start, body) in before.materials.iter().zip(&now.materials) {
            let way = start.velocity().map(|v| v * now.time);
            let off = norm(minus(body.center, add(start.center, way)));
            assert!(off <= 1e-12 * norm(body.center), "{off:e} m off its way at {} s", now.time);
        }
    }
    let particles: u64 = before.materials.iter().map(|m| m.particles).sum();
    let moved = simulation.updates() as f64 / (particles * ticks) as f64;
    println!("{ticks} ticks in 40 steps; {:.1} % of the particle updates of a common step", 100.0 * moved);
    assert!(moved < 0.5);
}

#[test]
fn momentum_is_kept_and_energy_accounted_when_materials_with_rates_meet() {
    let (simulation, slow) = end(scene(MEETING, &[]));
    let start = run(scene(MEETING, &[("run.steps", "1")]));
    let common = run(scene(MEETING, &[("run.rates", "common")]));
    let (before, after) = (momentum(&start), momentum(&slow));
    let drift = norm(minus(after, before)) / norm(before);
    let energy = start.energy().kinetic;
    println!(
        "{} steps, {} ticks (common: {} steps); momentum drift {drift:.1e}; residual {:+.2e}, common {:+.2e} of {energy:.3e} J",
        simulation.steps(),
        simulation.ticks(),
        common.steps,
        slow.residual,
        common.residual
    );
    assert!(simulation.ticks() > 5 * simulation.steps());
    assert!(drift < 1e-12);
    assert!(slow.friction > 0.0 && slow.impact > 0.0, "the balls must meet");
    // the soft ball's steps are 23 times as long as in the common step, and the account of second order
    assert!(slow.residual.abs() < 1e-3 * energy && common.residual.abs() < 1e-5 * energy);
    let turned = norm(minus(angular_momentum(&slow), angular_momentum(&common)));
    println!("angular momentum {turned:.2e} apart of {:.2e}", norm(angular_momentum(&common)));
    assert!(
        slow.materials.iter().zip(&start.materials).all(|(a, b)| apart(a, b) > 0.5),
        "all three must meet"
    );
}

fn apart(a: &MaterialReport, b: &MaterialReport) -> f64 {
    norm(minus(a.velocity(), b.velocity()))
}

#[test]
fn smaller_steps_of_their_own_come_to_the_common_result() {
    let smallest = run(scene(MEETING, &[("run.rates", "common"), ("run.cfl", "0.1")]));
    let off = |overrides: Overrides<'_>| {
        let report = run(scene(MEETING, overrides));
        let pairs = report.materials.iter().zip(&smallest.materials);
        let worst = pairs.map(|(own, same)| apart(own, same)).fold(0.0, f64::max);
        println!("{overrides:?}: {} steps, {worst:.3e} m/s off", report.steps);
        worst
    };
    let common = off(&[("run.rates", "common")]);
    let [coarse, middle, fine] = ["0.4", "0.2", "0.1"].map(|cfl| off(&[("run.cfl", cfl)]));
    // balls of three cells that meet at 10 m/s; the common step itself is 0.15 m/s off
    assert!(coarse < 3.0 * common && fine < 1.5 * common, "{coarse} {fine} {common}");
    assert!(fine < 0.7 * coarse && fine < middle && middle < coarse, "{coarse} {middle} {fine}");
}

/// Which blocks are active follows from where particles are, not from when that was looked at: patches that move, and restarts,
/// look at other times.
#[test]
fn no_bit_depends_on_when_blocks_are_activated() {
    let shot = || start(problem("slab-quick", &[("run.rates", "per-material"), ("run.steps", "150")]));
    let (mut undisturbed, mut disturbed) = (shot(), shot());
    finish(&mut undisturbed).expect("a run");
    loop {
        disturbed.warehouse.reactivate = true;
        if !disturbed.step().expect("a step") {
            break;
        }
    }
    assert_eq!(disturbed.state_hash(), undisturbed.state_hash());
}
