//! The account of energy closes: to a part of a thousand of what is turned over, and four times better with half the step.

use crate::common::{Overrides, scene, start};

/// A soft bar in a slim domain.
const BAR: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["24 mm", "8 mm", "8 mm"]
cell = "1 mm"
[material.bar]
law = "neo-hookean"
density = 1000
bulk-modulus = "20 kPa"
shear-modulus = "10 kPa"
[[body]]
name = "bar"
material = "bar"
shape = { box = { lower = [0, 0, 0], upper = ["12 mm", "4 mm", "4 mm"] } }
[boundary]
y-min = "symmetric"
z-min = "symmetric"
[run]
until = "8 ms"
cfl = 0.4
"#;

/// The largest residual that the run ever had, as a part of the energy turned over by its end.
fn residual(overrides: Overrides<'_>) -> f64 {
    let mut simulation = start(scene(BAR, overrides));
    let mut worst = 0.0f64;
    while simulation.step().expect("steps") {
        if simulation.steps().is_multiple_of(7) {
            worst = worst.max(simulation.report().expect("one rank").residual.abs());
        }
    }
    let report = simulation.report().expect("one rank");
    worst.max(report.residual.abs()) / report.turnover
}

/// The residual at CFL .4, with a look at half of it.
fn closes(name: &str, most: f64, overrides: Overrides<'_>) {
    let at = |cfl: &str| residual(&[overrides, &[("run.cfl", cfl)]].concat());
    let [whole, half] = [at("0.4"), at("0.2")];
    println!(
        "{name:<28} {whole:.1e} of what is turned over, with half the step {half:.1e}: {:.1} times less",
        whole / half
    );
    assert!(whole < most, "{name}: {whole:.1e}");
    assert!(whole > 3.4 * half, "{name}: {whole:.1e}, {half:.1e}");
}

#[test]
fn a_bar_that_hits_a_mirror() {
    closes("mirror", 1e-3, &[("body.bar.velocity", "[-0.5, 0, 0]"), ("boundary.x-min", "symmetric")]);
}

#[test]
fn a_bar_with_viscosity_that_hits_a_mirror() {
    let slow = ("body.bar.velocity", "[-0.5, 0, 0]");
    closes("viscosity", 1e-3, &[slow, ("boundary.x-min", "symmetric"), ("run.viscosity", "{}")]);
}

#[test]
fn a_bar_that_loads_and_forces_pull() {
    let force = "[{ material = \"bar\", pressure = 2000, side = \"+x\" }]";
    let damped = [("load.damping", "100"), ("load.local-damping", "0.2"), ("load.gravity", "[0, -20, 0]")];
    let all = [&[("boundary.x-min", "fixed"), ("force", force)][..], &damped].concat();
    closes("loads and forces", 1e-3, &all);
}

#[test]
fn a_bar_that_gravity_pulls_at_a_fixed_face() {
    closes("gravity, fixed face", 1e-3, &[("load.gravity", "[100, 0, 0]"), ("boundary.x-min", "fixed")]);
}

#[test]
fn a_bar_that_a_drive_accelerates() {
    let drive = "[{ material = \"bar\", region = { box = { lower = [0, 0, 0], upper = [0.003, 0.004, 0.004] } }, \
                 velocity = [[0, 0, 0, 0], [0.008, 1, 0, 0]] }]";
    closes("drive", 1e-3, &[("drive", drive)]);
}

#[test]
fn a_tool_that_indents() {
    let bodies = "[{ name = \"bar\", material = \"bar\", shape = { box = { lower = [0, 0, 0], upper = [0.012, 0.004, 0.004] } } }, \
                  { name = \"ball\", material = \"tool\", shape = { sphere = { center = [0.018, 0, 0], radius = 0.006 } } }]";
    let tool = "{ law = \"rigid\", motion = \"prescribed\", density = 1000, velocity = [-0.4, 0, 0] }";
    for friction in ["0", "0.4"] {
        let contact =
            format!("[{{ between = [\"bar\", \"tool\"], law = \"friction\", friction = {friction} }}]");
        closes(
            "tool",
            1e-3,
            &[("boundary.x-min", "fixed"), ("material.tool", tool), ("body", bodies), ("contact", &contact)],
        );
    }
}

#[test]
fn two_balls_that_bounce_obliquely_with_friction() {
    let bodies = "[{ name = \"bar\", material = \"bar\", shape = { sphere = { center = [0.007, 0.008, 0.009], radius = 0.004 } }, velocity = [1, 0, 0] }, \
                  { name = \"ball\", material = \"other\", shape = { sphere = { center = [0.0155, 0.011, 0.009], radius = 0.004 } }, velocity = [-1, 0, 0] }]";
    let other = "{ law = \"neo-hookean\", density = 1500, bulk-modulus = 40e3, shear-modulus = 15e3 }";
    let contact = "[{ between = [\"bar\", \"other\"], law = \"friction\", friction = 0.3 }]";
    closes(
        "oblique bounce",
        1e-2,
        &[
            ("domain.upper", "[0.024, 0.020, 0.018]"),
            ("boundary.y-min", "free"),
            ("boundary.z-min", "free"),
            ("material.other", other),
            ("body", bodies),
            ("contact", contact),
        ],
    );
}
