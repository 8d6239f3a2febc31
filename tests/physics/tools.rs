//! Tools: shapes without particles, and moving faces, that push matter.

use crate::common;
use crate::common::{Overrides, finish, giver, scene, start, until};
use engine::schema::Label;

/// A soft block on a plate, in gravity.
const BLOCK: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["40 mm", "8 mm", "10 mm"]
cell = "1 mm"
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "100 kPa"
shear-modulus = "50 kPa"
[material.plate]
law = "rigid"
motion = "prescribed"
density = 1000
[[body]]
name = "block"
material = "soft"
shape = { box = { lower = ["2 mm", "2 mm", "3 mm"], upper = ["6 mm", "6 mm", "6 mm"] } }
velocity = [10, 0, 0]
[[body]]
name = "plate"
material = "plate"
shape = { half-space = { point = [0, 0, "3 mm"], normal = [0, 0, 1] } }
[[contact]]
between = ["soft", "plate"]
law = "friction"
friction = 0
[load]
gravity = [0, 0, -1000]
[run]
until = "2 ms"
cfl = 0.4
"#;

#[test]
fn a_plate_without_friction_does_not_brake_and_one_with_friction_does_by_coulomb() {
    for tenth in 0..10 {
        let height = format!("{}", 3e-3 - 1e-4 * f64::from(tenth));
        let at: Overrides<'_> = &[("body.plate.shape.half-space.point.2", &height)];
        let report = common::run(scene(BLOCK, at));
        let speed = report.materials[0].velocity()[0];
        assert!((speed / 10.0 - 1.0).abs() < 1e-6, "at {height} m: {speed} m/s");
        let push = giver(&report, "rigid.plate").impulse;
        assert!(push[2] > 0.0 && push[0].abs() < 1e-6 * push[2], "{push:?}");

        let rough = [at, &[("contact.0.friction", "0.3")]].concat();
        let report = common::run(scene(BLOCK, &rough));
        let [x, _, z] = giver(&report, "rigid.plate").impulse;
        println!(
            "at {height} m: friction / (mu normal) {:.4}, slowed to {:.4}",
            -x / (0.3 * z),
            report.materials[0].velocity()[0]
        );
        assert!((-x / (0.3 * z) - 1.0).abs() < 0.01);
        // what the block has lost is what the plate has given
        let lost = report.materials[0].momentum[0] - 10.0 * report.materials[0].mass;
        assert!((lost / x - 1.0).abs() < 1e-9, "{lost} {x}");
    }
}

/// A face that is a plate rubs what slides along it, and a plate that goes along does not.
#[test]
fn a_face_rubs_by_coulomb() {
    for (velocity, rubs) in [("[0, 0, 0]", 1.0), ("[10, 0, 0]", 0.0), ("[20, 0, 0]", -1.0)] {
        let face = format!("{{ plate = {{ friction = 0.3, velocity = {velocity} }} }}");
        let on_face: Overrides<'_> = &[
            ("boundary.z-min", &face),
            ("domain.lower.2", "3e-3"),
            ("domain.upper.2", "13e-3"),
            ("body.plate.shape.half-space.point.2", "-3e-3"),
        ];
        let report = common::run(scene(BLOCK, on_face));
        let [x, _, z] = giver(&report, "face.z-min").impulse;
        println!("a plate at {velocity} m/s: friction / (mu normal) {:.4}", -x / (0.3 * z));
        assert!(z > 0.0 && (-x / (0.3 * z) - rubs).abs() < 0.01);
        let lost = report.materials[0].momentum[0] - 10.0 * report.materials[0].mass;
        assert!((lost - x).abs() < 1e-9 * z, "{lost} {x}");
    }
}

/// A ball that flies against a plate of a quarter of a cell, and of a hundredth.
#[test]
fn a_thin_plate_has_two_sides() {
    for (center, speed, top) in
        [("8.2 mm", -0.6, "4.65e-3"), ("0.8 mm", 0.6, "4.65e-3"), ("8.2 mm", -0.6, "4.41e-3")]
    {
        let plate = format!("{{ box = {{ lower = [0, 0, 4.4e-3], upper = [40e-3, 8e-3, {top}] }} }}");
        let (shape, velocity) = (
            format!("{{ sphere = {{ center = [\"12 mm\", \"4 mm\", \"{center}\"], radius = \"3 mm\" }} }}"),
            format!("[0, 0, {speed}]"),
        );
        let ball: Overrides<'_> = &[
            ("body.block.shape", &shape),
            ("body.block.velocity", &velocity),
            ("body.plate.shape", &plate),
            ("load.gravity", "[0, 0, 0]"),
            ("domain.lower.2", "-4e-3"),
            ("domain.upper.2", "14e-3"),
            ("run.until", "6 ms"),
        ];
        let report = common::run(scene(BLOCK, ball));
        let back = -report.materials[0].velocity()[2] / speed;
        println!("from {center}: {back:.3} of the speed");
        assert!(back > 0.75, "{back}");
    }
}

/// A turntable takes a block along, without slip.
#[test]
fn a_turning_tool_carries_what_lies_on_it() {
    let table: Overrides<'_> = &[
        ("domain.lower", "[-0.02, -0.02, 0]"),
        ("domain.upper", "[0.02, 0.02, 0.01]"),
        ("material.soft.bulk-modulus", "20 kPa"),
        ("material.soft.shear-modulus", "10 kPa"),
        ("material.plate.angular-velocity", "[[0, 0, 0, 0], [0.1, 0, 0, 8]]"),
        ("body.block.shape", "{ box = { lower = [8e-3, -2e-3, 3e-3], upper = [12e-3, 2e-3, 5e-3] } }"),
        ("body.block.velocity", "[0, 0, 0]"),
        (
            "body.plate.shape",
            "{ cylinder = { start = [0, 0, 1e-3], end = [0, 0, 3e-3], radius = \"18 mm\" } }",
        ),
        ("contact.0.friction", "0.8"),
        ("load.gravity", "[0, 0, -10]"),
        ("load.damping", "20"),
        ("run.until", "0.25"),
    ];
    let report = common::run(scene(BLOCK, table));
    let [x, y, _] = report.materials[0].center;
    let wanted = 0.5 * 8.0 * 0.1 + 8.0 * 0.15;
    println!("radius {:.3} mm, angle {:.4} of {wanted:.4}", 1e3 * x.hypot(y), y.atan2(x));
    assert!((y.atan2(x) / wanted - 1.0).abs() < 0.03 && (x.hypot(y) / 0.01 - 1.0).abs() < 0.03);
}

/// A face that moves: matter that it touches is pushed with ρ c V, and held back with as much.
#[test]
fn a_moving_face_pushes_and_pulls() {
    let speed = (1e5f64 + 4.0 / 3.0 * 5e4).sqrt() / 1e3f64.sqrt();
    for (condition, velocity) in [("velocity", 0.05), ("velocity", -0.05), ("plate", 0.05), ("plate", -0.05)]
    {
        let face = match condition {
            "velocity" => format!("{{ velocity = [{velocity}, 0, 0] }}"),
            _ => format!("{{ plate = {{ friction = 0, velocity = [{velocity}, 0, 0] }} }}"),
        };
        let bar: Overrides<'_> = &[
            ("domain.lower.0", "-1e-3"),
            ("domain.upper", "[19e-3, 2e-3, 2e-3]"),
            ("boundary.x-min", &face),
            ("boundary.y-min", "symmetric"),
            ("boundary.y-max", "symmetric"),
            ("boundary.z-min", "symmetric"),
            ("boundary.z-max", "symmetric"),
            ("body.block.shape", "{ box = { lower = [-1e-3, 0, 0], upper = [16e-3, 2e-3, 2e-3] } }"),
            ("body.block.velocity", "[0, 0, 0]"),
            ("body.plate.shape.half-space.point.2", "-3e-3"),
            ("load.gravity", "[0, 0, 0]"),
            ("run.until", "1 ms"),
        ];
        let mut simulation = start(scene(BLOCK, bar));
        until(&mut simulation, 0.1e-3);
        simulation.mark_row();
        let report = finish(&mut simulation).expect("runs");
        let push = giver(&report, "face.x-min").force[0] / (4e-6 * 1e3 * speed * velocity);
        println!("{condition} {velocity}: F/(A rho c V) = {push:.4}");
        let wanted = if condition == "plate" && velocity < 0.0 { 0.0 } else { 1.0 };
        // what only pushes lets go, and closes, again and again
        let tolerance = if condition == "plate" { 0.04 } else { 0.02 };
        assert!((push - wanted).abs() < tolerance, "{condition} {velocity}: {push}");
    }
}

/// A tool goes where its table of displacements says, turns about its center, and particles show it where it is.
#[test]
fn a_tool_goes_where_its_table_says_and_is_seen_there() {
    let tables: Overrides<'_> = &[
        ("contact", "[]"),
        ("load.gravity", "[0, 0, 0]"),
        ("body.block.velocity", "[0, 0, 0]"),
        ("body.plate.shape", "{ box = { lower = [20e-3, 2e-3, 4e-3], upper = [24e-3, 4e-3, 6e-3] } }"),
        ("material.plate.displacement", "[[0, 0, 0, 0], [0.5e-3, 1e-3, 0, 0], [2e-3, -2e-3, 1e-3, 0]]"),
        ("material.plate.angular-velocity", "[0, 0, 785.3981633974483]"),
        ("material.plate.center", "[20e-3, 2e-3, 4e-3]"),
        ("material.plate.visible", "true"),
    ];
    let mut simulation = start(scene(BLOCK, tables));
    until(&mut simulation, 0.5e-3);
    let late = simulation.clock().time;
    let x = 20e-3 + 1e-3 - 3e-3 * (late - 0.5e-3) / 1.5e-3;
    assert!((common::body(&simulation, 1).center[0] - x).abs() < 1e-12);
    let report = finish(&mut simulation).expect("runs");
    let center = [18e-3, 3e-3, 4e-3];
    let [gone, turn] = report.materials[1].rigid.expect("it is rigid");
    assert!(gone.iter().zip([-2e-3, 1e-3, 0.0]).all(|(x, wanted)| (x - wanted).abs() < 1e-12), "{gone:?}");
    assert!((turn[2] - 785.3981633974483).abs() < 1e-9, "{turn:?}");
    assert!(report.materials[1].center.iter().zip(center).all(|(x, wanted)| (x - wanted).abs() < 1e-12));
    // a quarter turn about its corner: what went along x and y goes along y and −x
    let here = |x: &[f64]| {
        (0..3).all(|a| x[a] > center[a] + [-2e-3, 0.0, 0.0][a] && x[a] < center[a] + [0.0, 4e-3, 2e-3][a])
    };
    let all = common::numbers(&simulation, tasks::labels::Position::ID);
    assert_eq!(all.iter().filter(|x| here(x)).count(), 4 * 2 * 2 * 8);
}
