//! Forces, tractions and pressures on parts of bodies, against closed forms.

use crate::common::{Overrides, finish, giver, numbers, run, scene, start, until};
use engine::schema::Label;
use std::collections::HashMap;
use tasks::labels;

const BLOCK: &str = r#"
[domain]
lower = ["-6 mm", "-6 mm", "-6 mm"]
upper = ["6 mm", "6 mm", "6 mm"]
cell = "1 mm"
[material.rubber]
law = "neo-hookean"
density = 1000
bulk-modulus = "100 kPa"
shear-modulus = "50 kPa"
[[body]]
name = "block"
material = "rubber"
shape = { box = { lower = ["-3 mm", "-3 mm", "-3 mm"], upper = ["3 mm", "3 mm", "3 mm"] } }
[run]
until = "40 ms"
cfl = 0.4
"#;

#[test]
fn a_total_force_is_mass_times_acceleration() {
    let pushed: Overrides<'_> = &[
        (
            "force",
            "[{ name = 'push', material = 'rubber', total = [[0, '0 N', 0, 0], ['10 ms', '2 mN', 0, 0], [1, 0.002, 0, 0]], \
             region = { box = { lower = [0, -1, -1], upper = [1, 1, 1] } } }]",
        ),
        ("run.until", "20 ms"),
        ("domain.upper.0", "12e-3"),
    ];
    let report = run(scene(BLOCK, pushed));
    let exact = 0.5 * 0.002 * 0.01 + 0.002 * 0.01;
    let push = giver(&report, "force.push");
    for found in [report.materials[0].momentum[0], push.impulse[0]] {
        assert!((found / exact - 1.0).abs() < 1e-10, "{found}, not {exact}");
    }
    // its work is all energy that there is, but for what the transfer loses
    let all = report.energy().total() + report.transfer;
    assert!((push.work / all - 1.0).abs() < 0.01, "{} {all}", push.work);
}

/// A force on one of two bodies of a material moves that one alone.
#[test]
fn a_force_on_a_body_moves_that_body() {
    let two: Overrides<'_> = &[
        (
            "body",
            "[{ name = 'block', material = 'rubber', shape = { box = { lower = [-5e-3, -1e-3, -1e-3], upper = [-3e-3, 1e-3, 1e-3] } } }, \
              { name = 'other', material = 'rubber', shape = { box = { lower = [1e-3, -1e-3, -1e-3], upper = [3e-3, 1e-3, 1e-3] } } }]",
        ),
        ("force", "[{ material = 'rubber', body = 'other', total = [2e-4, 0, 0] }]"),
        ("run.until", "5 ms"),
    ];
    let mut simulation = start(scene(BLOCK, two));
    finish(&mut simulation).expect("runs");
    let (x, v) = (numbers(&simulation, labels::Position::ID), numbers(&simulation, labels::Velocity::ID));
    for (x, v) in x.iter().zip(&v) {
        // 8 mg
        let exact = if x[0] > 0.0 { 2e-4 * 5e-3 / 8e-6 } else { 0.0 };
        assert!((v[0] - exact).abs() < 1e-9, "{x:?} {v:?}");
    }
}

/// An eighth of a cube under pressure from all sides: K/2 (J − 1/J) = −p; under a dead pressure −p J^(−2/3).
#[test]
fn a_cube_under_pressure_has_the_volume_of_its_pressure() {
    for (follows, exact) in [("true", true), ("false", false)] {
        let force = format!(
            "[{{ material = 'rubber', pressure = [[0, 0], ['10 ms', '20 kPa'], [1, '20 kPa']], follows = {follows} }}]"
        );
        let pressed: Overrides<'_> = &[
            ("domain.lower", "[0, 0, 0]"),
            ("domain.upper", "[0.01, 0.01, 0.01]"),
            ("body.block.shape.box.lower", "[0, 0, 0]"),
            ("body.block.shape.box.upper", "[0.008, 0.008, 0.008]"),
            ("boundary.x-min", "symmetric"),
            ("boundary.y-min", "symmetric"),
            ("boundary.z-min", "symmetric"),
            ("force", &force),
            ("load.damping", "1000"),
        ];
        let mut simulation = start(scene(BLOCK, pressed));
        finish(&mut simulation).expect("runs");
        let (v, v0) =
            (numbers(&simulation, labels::Volume::ID), numbers(&simulation, labels::InitialVolume::ID));
        let x = numbers(&simulation, labels::Position::ID);
        let inner = x.iter().zip(v.iter().zip(&v0)).filter(|(x, _)| x.iter().all(|x| *x < 3e-3));
        let all: Vec<f64> = inner.map(|(_, (v, v0))| v[0] / v0[0]).collect();
        let j = all.iter().sum::<f64>() / all.len() as f64;
        // ½ K (J − 1/J) + p(J) = 0 by bisection
        let p = |j: f64| if exact { 20e3 } else { 20e3 * j.powf(-2.0 / 3.0) };
        let (mut low, mut high) = (0.3, 1.0);
        while high - low > 1e-12 {
            let mid = 0.5 * (low + high);
            if 50e3 * (mid - 1.0 / mid) + p(mid) > 0.0 { high = mid } else { low = mid }
        }
        println!("follows {follows}: J {j:.4}, exact {low:.4}");
        assert!(((1.0 - j) / (1.0 - low) - 1.0).abs() < 0.02);
    }
}

/// A pressure on a side of a block that a drive turns goes with it, ∫ p A (cos ωt, sin ωt) dt, if it follows; or keeps its direction.
#[test]
fn a_pressure_that_follows_turns_with_its_surface() {
    let (spin, time, push) = (150.0, 0.01, 20.0 * 36e-6);
    for (follows, exact) in
        [(true, [f64::sin(spin * time) / spin, (1.0 - f64::cos(spin * time)) / spin]), (false, [time, 0.0])]
    {
        let force = format!("[{{ material = 'rubber', pressure = 20, side = '+x', follows = {follows} }}]");
        let turning: Overrides<'_> = &[
            ("drive", "[{ material = 'rubber', angular-velocity = [0, 0, 150] }]"),
            ("force", &force),
            ("run.until", "10 ms"),
        ];
        let mut simulation = start(scene(BLOCK, turning));
        let report = finish(&mut simulation).expect("runs");
        let given = giver(&report, "force.0").impulse;
        let found = [0, 1].map(|a| -given[a] / push);
        println!(
            "follows {follows}: {:.6} {:.6} s, exact {:.6} {:.6} s",
            found[0], found[1], exact[0], exact[1]
        );
        assert!((0..2).all(|a| (found[a] - exact[a]).abs() < 0.005 * time));
    }
}

/// A thick ring under pressure from within (Lamé, plane strain): u = (1 + ν) p a² / (E (b² − a²)) ((1 − 2ν) r + b²/r).
#[test]
fn a_thick_ring_widens_as_lame_says() {
    let ring: Overrides<'_> = &[
        ("domain.lower", "[0, 0, 0]"),
        ("domain.upper", "[0.02, 0.02, 0.001]"),
        ("domain.cell", "0.5 mm"),
        (
            "body.block.shape",
            "{ intersection = [{ box = { lower = [0, 0, 0], upper = [0.02, 0.02, 0.001] } }, { difference = [\
             { cylinder = { start = [0, 0, -1], end = [0, 0, 1], radius = 0.016 } }, \
             { cylinder = { start = [0, 0, -1], end = [0, 0, 1], radius = 0.008 } }] }] }",
        ),
        (
            "force",
            "[{ material = 'rubber', pressure = [[0, 0], ['10 ms', 200], [1, 200]], \
             region = { cylinder = { start = [0, 0, -1], end = [0, 0, 1], radius = 0.0095 } } }]",
        ),
        ("boundary.x-min", "symmetric"),
        ("boundary.y-min", "symmetric"),
        ("boundary.z-min", "symmetric"),
        ("boundary.z-max", "symmetric"),
        ("load.damping", "600"),
    ];
    let mut simulation = start(scene(BLOCK, ring));
    let places: HashMap<u64, Vec<f64>> = {
        let who = numbers(&simulation, labels::Identity::ID).into_iter().map(|id| id[0].to_bits());
        who.zip(numbers(&simulation, labels::Position::ID)).collect()
    };
    finish(&mut simulation).expect("runs");
    let (bulk, shear, a, b, p) = (100e3, 50e3, 8e-3, 16e-3, 200.0);
    let (young, nu) = (
        9.0 * bulk * shear / (3.0 * bulk + shear),
        (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear)),
    );
    let exact =
        |r: f64| (1.0 + nu) * p * a * a / (young * (b * b - a * a)) * ((1.0 - 2.0 * nu) * r + b * b / r);
    let who = numbers(&simulation, labels::Identity::ID);
    let (mut found, mut wanted) = (0.0, 0.0);
    for (id, x) in who.iter().zip(numbers(&simulation, labels::Position::ID)) {
        let before = &places[&id[0].to_bits()];
        let r = before[0].hypot(before[1]);
        found += ((x[0] - before[0]) * before[0] + (x[1] - before[1]) * before[1]) / r;
        wanted += exact(r);
    }
    println!("the ring widens by {:.4} of what Lamé says", found / wanted);
    assert!((found / wanted - 1.0).abs() < 0.02);
}

/// A bar that is pulled at its end by a dead traction between mirrors: P = t.
#[test]
fn a_dead_traction_is_the_nominal_stress() {
    let bar: Overrides<'_> = &[
        ("domain.lower", "[0, 0, 0]"),
        ("domain.upper", "[0.02, 0.002, 0.002]"),
        ("body.block.shape", "{ box = { lower = [0, 0, 0], upper = [0.012, 0.002, 0.002] } }"),
        (
            "force",
            "[{ material = 'rubber', traction = [[0, 0, 0, 0], ['5 ms', '30 kPa', 0, 0], [1, 30e3, 0, 0]], side = '+x' }]",
        ),
        ("boundary.x-min", "symmetric"),
        ("boundary.y-min", "symmetric"),
        ("boundary.y-max", "symmetric"),
        ("boundary.z-min", "symmetric"),
        ("boundary.z-max", "symmetric"),
        ("load.damping", "800"),
    ];
    let mut simulation = start(scene(BLOCK, bar));
    until(&mut simulation, 0.035);
    simulation.mark_row();
    let report = finish(&mut simulation).expect("runs");
    let (f, tau) =
        (numbers(&simulation, labels::Deformation::ID), numbers(&simulation, labels::KirchhoffStress::ID));
    let x = numbers(&simulation, labels::Position::ID);
    let inner = x.iter().zip(tau.iter().zip(&f)).filter(|(x, _)| (x[0] - 6e-3).abs() < 3e-3);
    let all: Vec<f64> = inner.map(|(_, (tau, f))| tau[0] / f[0]).collect();
    let stress = all.iter().sum::<f64>() / all.len() as f64;
    println!("nominal stress {:.4} of the traction", stress / 30e3);
    assert!((stress / 30e3 - 1.0).abs() < 0.02);
    let [pull, wall] = ["force.0", "face.x-min"].map(|name| giver(&report, name).force[0]);
    assert!((wall + pull).abs() < 1e-3 * pull, "{wall} {pull}");
}
