//! Free rigid bodies that nothing touches.

use crate::common;
use crate::common::{Overrides, body, scene, start};
use nalgebra::{Matrix3, Vector3};
use tasks::rigid::state::RigidState;

/// A brick that turns about its middle axis, a little off.
const BRICK: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["24 mm", "24 mm", "24 mm"]
cell = "1 mm"
[material.brick]
law = "rigid"
motion = "free"
density = 2000
angular-velocity = [0.01, 100, 0.02]
# something that limits the step, so that all steps are equal
[material.jelly]
law = "neo-hookean"
density = 1000
bulk-modulus = 600
shear-modulus = 150
[[body]]
name = "jelly"
material = "jelly"
shape = { box = { lower = [0, 0, 0], upper = ["2 mm", "2 mm", "2 mm"] } }
[[body]]
name = "brick"
material = "brick"
shape = { box = { lower = ["6 mm", "8 mm", "10 mm"], upper = ["18 mm", "16 mm", "14 mm"] } }
[run]
until = 10
cfl = 0.4
steps = 1400
"#;

/// ω in the body's frame after a time, by Euler's equations and fourth-order Runge and Kutta in small steps.
fn spin(inertia: [f64; 3], start: [f64; 3], time: f64) -> [f64; 3] {
    let rate = |w: [f64; 3]| -> [f64; 3] {
        std::array::from_fn(|a| {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            (inertia[b] - inertia[c]) * w[b] * w[c] / inertia[a]
        })
    };
    let add = |a: [f64; 3], b: [f64; 3], s: f64| -> [f64; 3] { std::array::from_fn(|i| a[i] + s * b[i]) };
    let steps = (time / 1e-5).ceil();
    let (dt, mut w) = (time / steps, start);
    for _ in 0..steps as usize {
        let k1 = rate(w);
        let k2 = rate(add(w, k1, 0.5 * dt));
        let k3 = rate(add(w, k2, 0.5 * dt));
        let k4 = rate(add(w, k3, dt));
        w = std::array::from_fn(|i| w[i] + dt / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    w
}

#[test]
fn a_tumbling_brick_keeps_its_energy_and_flips_in_time() {
    let mut simulation = start(scene(BRICK, &[]));
    let before = body(&simulation, 0);
    // a brick of mass M: M/12 (b² + c²), exactly
    let mass = 2000.0 * 12e-3 * 8e-3 * 4e-3;
    let exact =
        [(8e-3, 4e-3), (12e-3, 4e-3), (12e-3, 8e-3)].map(|(b, c): (f64, f64)| mass / 12.0 * (b * b + c * c));
    for a in 0..3 {
        assert!((before.inertia[4 * a] / exact[a] - 1.0).abs() < 1e-12);
    }
    let energy = |s: &RigidState| {
        let r = Matrix3::from_row_slice(&s.rotation);
        let w = r.transpose() * Vector3::from(s.angular);
        0.5 * (0..3).map(|a| exact[a] * w[a] * w[a]).sum::<f64>()
    };
    let (first, mut worst, mut flips, mut last) = (energy(&before), 0.0f64, Vec::new(), 1.0);
    while simulation.step().expect("steps") {
        let now = body(&simulation, 0);
        worst = worst.max((energy(&now) / first - 1.0).abs());
        let r = Matrix3::from_row_slice(&now.rotation);
        let w = r.transpose() * Vector3::from(now.angular);
        if w[1] * last < 0.0 {
            flips.push(simulation.clock().time);
            last = w[1];
        }
    }
    let turned = simulation.clock().time * 100.0 / std::f64::consts::TAU;
    println!("{turned:.1} turns, energy to {worst:.1e}, flips at {flips:.5?} s");
    assert!(worst < 1e-4 && flips.len() >= 2);
    for time in flips {
        // just then the spin about the middle axis passes through zero
        let [early, late] = [0.99, 1.01].map(|part| spin(exact, [0.01, 100.0, 0.02], part * time)[1]);
        assert!(early * late < 0.0, "no flip near {time} s: {early} {late}");
    }
    let report = simulation.report().expect("one rank");
    assert!((report.energy().kinetic / first - 1.0).abs() < 1e-4);
    let l = report.materials[0].angular_momentum;
    let wanted = [0, 1, 2].map(|a| exact[a] * [0.01, 100.0, 0.02][a]);
    assert!(l.iter().zip(wanted).all(|(l, w)| (l - w).abs() < 1e-12 * wanted[1]), "{l:?} {wanted:?}");
}

#[test]
fn damping_brakes_a_free_body_and_its_turn() {
    let damped: Overrides<'_> =
        &[("load.damping", "20"), ("body.brick.velocity", "[0.05, 0, 0]"), ("run.until", "0.05")];
    let mut simulation = start(scene(BRICK, damped));
    let before = simulation.report().expect("one rank").materials[0].clone();
    common::finish(&mut simulation).expect("runs");
    let after = body(&simulation, 0);
    let decay = f64::exp(-20.0 * 0.05);
    assert!((after.velocity[0] / 0.05 - decay).abs() < 1e-12);
    let l = simulation.report().expect("one rank").materials[0].angular_momentum[1];
    assert!((l / before.angular_momentum[1] / decay - 1.0).abs() < 1e-9);
}

/// What a fall about the origin gains of angular momentum, its torque gives.
#[test]
fn torques_and_angular_momentum_add_up() {
    let falling: Overrides<'_> = &[
        ("load.gravity", "[[0, 1, 0, -9], [0.01, 3, 2, -9]]"),
        ("body.brick.velocity", "[0.1, 0.2, 0.3]"),
        ("run.until", "0.005"),
    ];
    let mut simulation = start(scene(BRICK, falling));
    let before = simulation.report().expect("one rank").angular_momentum();
    let report = common::finish(&mut simulation).expect("runs");
    let size = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    let gained = [0, 1, 2].map(|a| report.angular_momentum()[a] - before[a]);
    println!("gained {:.3e}, lost {:.3e} N m s", size(gained), size(report.spin_lost));
    assert!(size(report.spin_lost) < 1e-12 * size(gained));
}

#[test]
fn a_locked_body_moves_and_turns_along_and_about_what_is_left() {
    let locked: Overrides<'_> = &[
        ("material.brick.locked", "xz"),
        ("material.brick.locked-turns", "xy"),
        ("material.brick.angular-velocity", "[0, 0, 40]"),
        ("body.brick.velocity", "[0, 0.02, 0]"),
        ("load.gravity", "[5, 1, 7]"),
        ("run.until", "0.03"),
    ];
    let mut simulation = start(scene(BRICK, locked));
    common::finish(&mut simulation).expect("runs");
    let it = body(&simulation, 0);
    let velocity = [0.0, 0.02 + 0.03, 0.0];
    assert!(
        it.velocity.iter().zip(velocity).all(|(v, wanted)| (v - wanted).abs() < 1e-12),
        "{:?}",
        it.velocity
    );
    assert!(it.angular[0] == 0.0 && it.angular[1] == 0.0 && (it.angular[2] - 40.0).abs() < 1e-9);
    let angle = it.rotation[3].atan2(it.rotation[0]);
    assert!((angle - 40.0 * 0.03).abs() < 1e-9, "{angle}");
}

/// A lock about one axis gives a torque about that alone: the angular momentum about the two others stays, and the energy.
#[test]
fn a_lock_gives_no_torque_about_other_axes() {
    for locked in 0..3 {
        let mut spin = [30.0, 20.0, 10.0];
        spin[locked] = 0.0;
        let (axis, spin) = (["x", "y", "z"][locked], format!("{spin:?}"));
        let lock: Overrides<'_> = &[
            ("material.brick.locked-turns", axis),
            ("material.brick.angular-velocity", &spin),
            ("run.until", "0.2"),
        ];
        let mut simulation = start(scene(BRICK, lock));
        let first = body(&simulation, 0);
        common::finish(&mut simulation).expect("runs");
        let last = body(&simulation, 0);
        let told = simulation.report().expect("one rank").materials[0].rigid.expect("it is rigid");
        assert_eq!(told, [[0.0; 3], last.angular]);
        let [before, after] = [&first, &last].map(tasks::rigid::rotation::momentum);
        let energy = |it: &RigidState, l: &Vector3<f64>| 0.5 * l.dot(&Vector3::from(it.angular));
        let drift = energy(&last, &after) / energy(&first, &before) - 1.0;
        let changed = (after - before) / before.norm();
        println!("{axis} locked: L changed by {changed:?}, energy by {drift:.1e}, ω {:?}", last.angular);
        assert!((0..3).all(|a| a == locked || changed[a].abs() < 1e-10), "{changed:?}");
        assert!(drift.abs() < 1e-3 && last.angular[locked] == 0.0);
        // the body does tumble
        assert!((0..3).any(|a| (last.angular[a] - first.angular[a]).abs() > 1.0));
    }
}

/// A tool that is pushed: ∫F dt / M, and what pushes it is accounted.
#[test]
fn a_force_in_time_moves_a_body_and_is_told() {
    let pushed: Overrides<'_> = &[
        ("material.brick.force", "[[0, 0, 0, 0], [0.02, 0.004, 0, -0.002]]"),
        ("material.brick.angular-velocity", "[0, 0, 0]"),
        ("load.damping", "0"),
        ("run.until", "0.03"),
    ];
    let mut simulation = start(scene(BRICK, pushed));
    let report = common::finish(&mut simulation).expect("runs");
    let (mass, it) = (2000.0 * 12e-3 * 8e-3 * 4e-3, body(&simulation, 0));
    let impulse = [0.004, 0.0, -0.002].map(|f| f * (0.5 * 0.02 + 0.01));
    assert!((0..3).all(|a| (it.velocity[a] - impulse[a] / mass).abs() < 1e-12), "{:?}", it.velocity);
    let pushes = report.givers.iter().find(|giver| giver.name == "rigid.brick").expect("its force gives");
    assert!((0..3).all(|a| (pushes.impulse[a] - impulse[a]).abs() < 1e-15), "{:?}", pushes.impulse);
    assert!((pushes.work / report.energy().kinetic - 1.0).abs() < 1e-9, "{}", pushes.work);
    assert!(report.residual.abs() < 1e-12 * report.turnover);
    // a great force from rest: no step is so long that it flies through a cell
    let hard: Overrides<'_> =
        &[("material.brick.force", "[2000, 0, 0]"), ("material.brick.angular-velocity", "[0, 0, 0]")];
    let mut simulation = start(scene(BRICK, hard));
    simulation.step().expect("steps");
    assert!(body(&simulation, 0).center[0] - 12e-3 < 0.41e-3);
}

/// A falling brick that lands on something rigid: told, and with whom.
#[test]
fn a_free_body_that_meets_something_rigid_ends_the_run() {
    let slab = "[{ name = \"jelly\", material = \"jelly\", shape = { box = { lower = [0, 0, 0], upper = [0.002, 0.002, 0.002] } } }, \
                { name = \"brick\", material = \"brick\", shape = { box = { lower = [0.006, 0.008, 0.010], upper = [0.018, 0.016, 0.014] } } }";
    let tool = ", { name = \"plate\", material = \"plate\", shape = { box = { lower = [0.004, 0.004, 0.004], upper = [0.020, 0.020, 0.006] } } }]";
    let with_tool = format!("{slab}{tool}");
    let alone = format!("{slab}]");
    let fall: Overrides<'_> = &[
        ("material.brick.angular-velocity", "[0, 0, 0]"),
        ("body.brick.velocity", "[0, 0, -1]"),
        ("run.until", "0.02"),
        ("run.steps", "100000"),
    ];
    let plates = [
        ("rigid.plate", "{ law = \"rigid\", motion = \"free\", density = 1000 }", &with_tool, "none"),
        ("rigid.plate", "{ law = \"rigid\", motion = \"prescribed\", density = 1000 }", &with_tool, "none"),
        ("face.z-min", "", &alone, "fixed"),
        ("face.z-min", "", &alone, "symmetric"),
    ];
    for (whom, plate, bodies, face) in plates {
        let mut overrides = vec![("body", bodies.as_str())];
        if !plate.is_empty() {
            overrides.push(("material.plate", plate));
        }
        if face != "none" {
            overrides.push(("boundary.z-min", face));
        }
        overrides.extend(fall);
        let mut simulation = start(scene(BRICK, &overrides));
        let error = common::finish(&mut simulation).expect_err("they meet").to_string();
        // 4 mm above the plate, 10 mm above the face, and the run ends with a particle beyond it, a quarter of a cell within the brick
        let when = if face == "none" { 4.25e-3 } else { 10.25e-3 };
        println!("{error}");
        assert!(error.contains("the free rigid body brick meets") && error.contains(whom), "{error}");
        assert!((simulation.clock().time - when).abs() < 0.3e-3, "{}", simulation.clock().time);
    }
}
