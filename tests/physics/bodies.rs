//! Free rigid bodies in contact: they rest, bounce and roll as they should.

use crate::common;
use crate::common::{Overrides, finish, scene, start};
use sinew::simulation::Report;

/// A rigid brick on a column between mirrors.
const COLUMN: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["2 mm", "2 mm", "12 mm"]
cell = "1 mm"
[material.bed]
law = "neo-hookean"
density = 1000
bulk-modulus = "20 kPa"
shear-modulus = "10 kPa"
[material.brick]
law = "rigid"
motion = "free"
density = 2000
locked = "xy"
locked-turns = "xyz"
[[body]]
name = "bed"
material = "bed"
shape = { box = { lower = [0, 0, 0], upper = ["2 mm", "2 mm", "6 mm"] } }
[[body]]
name = "brick"
material = "brick"
shape = { box = { lower = [0, 0, "6 mm"], upper = ["2 mm", "2 mm", "10 mm"] } }
[[contact]]
between = ["bed", "brick"]
law = "friction"
friction = 0.3
[boundary]
x-min = "symmetric"
x-max = "symmetric"
y-min = "symmetric"
y-max = "symmetric"
z-min = "symmetric"
[load]
gravity = [0, 0, -9.81]
damping = 80
[run]
until = "200 ms"
cfl = 0.4
"#;

/// A rigid ball hits a soft one, head on: a quarter of both.
const BALLS: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["26 mm", "6 mm", "6 mm"]
cell = "0.5 mm"
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "100 kPa"
shear-modulus = "50 kPa"
[material.hard]
law = "rigid"
motion = "free"
density = 1000
locked = "yz"
locked-turns = "xyz"
[[body]]
name = "soft"
material = "soft"
shape = { intersection = [{ sphere = { center = ["16 mm", 0, 0], radius = "4 mm" } }, { box = { lower = [0, 0, 0], upper = [1, 1, 1] } }] }
[[body]]
name = "hard"
material = "hard"
shape = { sphere = { center = ["7.5 mm", 0, 0], radius = "4 mm" } }
velocity = [1, 0, 0]
[[contact]]
between = ["soft", "hard"]
law = "friction"
friction = 0
[boundary]
y-min = "symmetric"
z-min = "symmetric"
[run]
until = "5.5 ms"
cfl = 0.4
"#;

/// Something rigid on a bed that leans by 20 degrees; gravity grows within 80 ms, so gently that little bounces.
fn roll(shape: &str, width: &str, deep: &str, until: &str) -> String {
    let (sin, cos) = 20.0f64.to_radians().sin_cos();
    let grown = |n: i32| 0.5 * (1.0 - (std::f64::consts::PI * f64::from(n) / 24.0).cos());
    let row = |n: i32| {
        let g = 9.81 * grown(n);
        format!("[{}, {}, {}, 0]", 0.08 / 24.0 * f64::from(n), g * sin, -g * cos)
    };
    let gravity: Vec<String> = (0..=24).map(row).collect();
    let gravity = gravity.join(", ");
    format!(
        r#"
[domain]
lower = [0, 0, 0]
upper = ["50 mm", "38 mm", "{width}"]
cell = "1 mm"
[material.bed]
law = "neo-hookean"
density = 1000
bulk-modulus = "100 kPa"
shear-modulus = "10 kPa"
[material.roll]
law = "rigid"
motion = "free"
density = 4000
locked = "z"
locked-turns = "xy"
[[body]]
name = "bed"
material = "bed"
shape = {{ box = {{ lower = [0, 0, 0], upper = ["50 mm", "{deep}", "{width}"] }} }}
[[body]]
name = "roll"
material = "roll"
shape = {{ {shape} }}
[[contact]]
between = ["bed", "roll"]
law = "friction"
friction = 0.8
[boundary]
y-min = "fixed"
x-min = "symmetric"
x-max = "symmetric"
z-min = "symmetric"
z-max = "symmetric"
[load]
gravity = [{gravity}]
[run]
until = "{until}"
cfl = 0.4
"#
    )
}

#[test]
fn a_brick_that_rests_weighs_what_it_weighs_and_sinks_no_further() {
    let mut simulation = start(scene(COLUMN, &[]));
    let center = |simulation: &sinew::simulation::Simulation| common::body(simulation, 1).center[2];
    let (mut heights, mut times) = (Vec::new(), [0.1, 0.15].into_iter().peekable());
    while simulation.step().expect("steps") {
        if times.next_if(|time| simulation.clock().time >= *time).is_some() {
            heights.push(center(&simulation));
        }
    }
    heights.push(center(&simulation));
    // σ = ρ g H / (K + 4/3 μ) of the brick, and half of that of the column
    let modulus = 20e3 + 4.0 / 3.0 * 10e3;
    let sunk = (2000.0 * 4e-3 + 0.5 * 1000.0 * 6e-3) * 9.81 * 6e-3 / modulus;
    println!("centers at 100, 150 and 200 ms {heights:.7?}, wanted {:.7}", 8e-3 - sunk);
    assert!(heights.iter().all(|z| (z - (8e-3 - sunk)).abs() < 1e-6), "within .001 mm");
    let report = simulation.report().expect("one rank");
    let weight = 2000.0 * 2e-3 * 2e-3 * 4e-3 * 9.81;
    let pushed = report.givers.iter().find(|giver| giver.name == "contact.bed.brick").expect("the contact");
    let mean = -pushed.impulse[2] / 0.2;
    println!("mean force {mean:.6} N, weight {weight:.6} N");
    assert!((mean / weight - 1.0).abs() < 0.01);
}

/// A plate that a force presses down: the contact bears it, and the column gives way as it should.
#[test]
fn a_plate_that_a_force_pushes_presses_with_it() {
    let pressed: Overrides<'_> =
        &[("load.gravity", "[0, 0, 0]"), ("material.brick.force", "[[0, 0, 0, 0], [0.02, 0, 0, -1e-3]]")];
    let mut simulation = start(scene(COLUMN, pressed));
    while simulation.clock().time < 0.15 {
        simulation.step().expect("steps");
    }
    simulation.mark_row();
    let report = finish(&mut simulation).expect("runs");
    let modulus = 20e3 + 4.0 / 3.0 * 10e3;
    let (sunk, wanted) = (8e-3 - common::body(&simulation, 1).center[2], 1e-3 / 4e-6 * 6e-3 / modulus);
    let force =
        |name: &str| report.givers.iter().find(|giver| giver.name == name).expect("it gives").force[2];
    println!("sunk {sunk:.4e} m, linear {wanted:.4e} m; contact {:.4e} N", force("contact.bed.brick"));
    // 250 Pa on 33 kPa: 0.75 % of strain, and the law is not linear
    assert!((sunk / wanted - 1.0).abs() < 0.02);
    assert!(
        (force("contact.bed.brick") / -1e-3 - 1.0).abs() < 0.01
            && (force("rigid.brick") / -1e-3 - 1.0).abs() < 0.01
    );
}

/// Relative velocity after by that before.
fn restitution(overrides: Overrides<'_>) -> f64 {
    let mut simulation = start(scene(BALLS, overrides));
    let before = simulation.report().expect("one rank");
    let after = finish(&mut simulation).expect("runs");
    let relative = |report: &Report| {
        let of = |name: &str| {
            let index = simulation.scene.materials.iter().position(|m| m.name == name).expect("a material");
            report.materials[index].velocity()[0]
        };
        of("soft") - of("hard")
    };
    let momentum = |report: &Report| report.materials.iter().map(|m| m.momentum[0]).sum::<f64>();
    let drift = (momentum(&after) / momentum(&before) - 1.0).abs();
    let rigid = simulation.scene.materials.iter().any(|m| matches!(m.behavior, scene::Behavior::Rigid(_)));
    // forces in a hundredfold stiffer ball are rounded that much more coarsely
    assert!(drift < if rigid { 1e-13 } else { 1e-11 }, "momentum drifts by {drift:.0e}");
    -relative(&after) / relative(&before)
}

#[test]
fn a_rigid_ball_bounces_like_one_of_a_hundredfold_stiffness() {
    let material =
        "{ law = \"neo-hookean\", density = 1000, bulk-modulus = \"10 MPa\", shear-modulus = \"5 MPa\" }";
    for (place, most) in [("0.0075", 0.02), ("0.007625", 0.05)] {
        let shape = format!("{{ sphere = {{ center = [{place}, 0, 0], radius = 0.004 }} }}");
        let cut =
            format!("{{ intersection = [{shape}, {{ box = {{ lower = [0, 0, 0], upper = [1, 1, 1] }} }}] }}");
        let rigid = restitution(&[("body.hard.shape", &shape)]);
        let stiff = restitution(&[("body.hard.shape", &cut), ("material.hard", material)]);
        println!("center at {place} m: rigid {rigid:.4}, stiff {stiff:.4}");
        assert!((rigid / stiff - 1.0).abs() < most);
    }
}

/// How a roll of 12 mm accelerates from a time on, as a part of g sin 20°, and how its circumference does, as a part of that.
fn rolling(scene: scene::Scene, from: f64) -> [f64; 2] {
    let mut simulation = start(scene);
    let mut track = Vec::new();
    while simulation.step().expect("steps") {
        if simulation.clock().time > from {
            let body = common::body(&simulation, 1);
            track.push([simulation.clock().time, body.velocity[0], body.angular[2]]);
        }
    }
    let acceleration = common::slope(track.iter().map(|[t, v, _]| [*t, *v]));
    let turning = -common::slope(track.iter().map(|[t, _, w]| [*t, *w])) * 12e-3;
    let slides = 9.81 * 20.0f64.to_radians().sin();
    println!("acceleration {:.4} of g sin θ, its circumference {turning:.4} m/s²", acceleration / slides);
    [acceleration / slides, turning / acceleration]
}

#[test]
fn a_cylinder_rolls_down_with_two_thirds_of_what_slides() {
    let shape = r#"cylinder = { start = ["17 mm", "22 mm", "-1 mm"], end = ["17 mm", "22 mm", "2 mm"], radius = "12 mm" }"#;
    let [acceleration, turning] = rolling(scene(&roll(shape, "1 mm", "10 mm", "150 ms"), &[]), 0.09);
    assert!((1.5 * acceleration - 1.0).abs() < 0.02, "{acceleration}");
    // the bed is pressed together where it rolls
    assert!((turning - 1.0).abs() < 0.05, "{turning}");
}

/// Half of it, and over two of its bounces.
#[test]
#[ignore = "long"]
fn a_ball_rolls_down_with_five_sevenths_of_what_slides() {
    let shape = r#"sphere = { center = ["17 mm", "20 mm", 0], radius = "12 mm" }"#;
    let [acceleration, turning] = rolling(scene(&roll(shape, "13 mm", "8 mm", "170 ms"), &[]), 0.09);
    assert!((1.4 * acceleration - 1.0).abs() < 0.02, "{acceleration}");
    assert!((turning - 1.0).abs() < 0.05, "{turning}");
}
