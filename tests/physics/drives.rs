//! Drives: what they hold is held, and what is next to them is strained by the whole of their motion.

use crate::common::{Overrides, finish, giver, norm, numbers, scene, start, until};
use engine::schema::Label;
use sinew::simulation::{Report, Simulation};
use tasks::labels;

/// A bar between mirrors, 8 cells between two grips: the left one holds, the right one pulls by 2.4 cells in 2 ms.
const BAR: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["16 mm", "2 mm", "2 mm"]
cell = "1 mm"
[material.rubber]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "0.5 MPa"
[[body]]
name = "bar"
material = "rubber"
shape = { box = { lower = [0, 0, 0], upper = ["12 mm", "2 mm", "2 mm"] } }
[[drive]]
name = "left"
material = "rubber"
region = { box = { lower = [0, 0, 0], upper = ["2 mm", "2 mm", "2 mm"] } }
[[drive]]
name = "right"
material = "rubber"
region = { box = { lower = ["10 mm", 0, 0], upper = ["12 mm", "2 mm", "2 mm"] } }
displacement = [[0, 0, 0, 0], ["2 ms", "2.4 mm", 0, 0]]
[boundary]
y-min = "symmetric"
y-max = "symmetric"
z-min = "symmetric"
z-max = "symmetric"
[load]
damping = 2000
[run]
until = "10 ms"
cfl = 0.4
"#;

const AREA: f64 = 4e-6;

/// Nominal stress of the rubber under uniaxial strain λ, from W = μ/2 (λ^(4/3) + 2 λ^(−2/3) − 3) + K/2 (½ (λ² − 1) − ln λ).
fn nominal(stretch: f64) -> f64 {
    let (bulk, shear) = (1e6, 0.5e6);
    let isochoric = 0.5 * shear * (4.0 / 3.0) * (stretch.powf(1.0 / 3.0) - stretch.powf(-5.0 / 3.0));
    isochoric + 0.5 * bulk * (stretch - 1.0 / stretch)
}

/// Mean nominal stress of the particles that began within a cell of the middle.
fn stress(simulation: &Simulation) -> f64 {
    let stresses = numbers(simulation, labels::KirchhoffStress::ID);
    let (f, x) = (numbers(simulation, labels::Deformation::ID), numbers(simulation, labels::Position::ID));
    let middle = x.iter().map(|x| x[0]).fold((f64::INFINITY, 0.0f64), |(a, b), x| (a.min(x), b.max(x)));
    let middle = 0.5 * (middle.0 + middle.1);
    let near = stresses.iter().zip(&f).zip(&x).filter(|(_, x)| (x[0] - middle).abs() < 1.3e-3);
    let all: Vec<f64> = near.map(|((tau, f), _)| tau[0] / f[0]).collect();
    all.iter().sum::<f64>() / all.len() as f64
}

fn force(report: &Report, name: &str) -> [f64; 3] {
    giver(report, name).force
}

/// Mean forces of two grips along x from now on to the end of the run.
fn forces(simulation: &mut Simulation, names: [&str; 2]) -> [f64; 2] {
    simulation.mark_row();
    let report = finish(simulation).expect("runs");
    names.map(|name| force(&report, name)[0])
}

#[test]
fn a_bar_between_grips_is_stretched_and_held() {
    // a wave needs 0.2 ms from grip to grip
    for (cfl, end) in [("0.4", "52 ms"), ("0.05", "14 ms")] {
        let mut simulation = start(scene(BAR, &[("run.cfl", cfl), ("run.until", end)]));
        until(&mut simulation, 12e-3);
        let first = stress(&simulation);
        let [left, right] = forces(&mut simulation, ["drive.left", "drive.right"]).map(|f| f / AREA);
        let last = stress(&simulation);
        let [a, b, c] = [last, -left, right].map(|s| s / nominal(1.3));
        println!("CFL {cfl}: stress {a:.4}, grips {b:.4} {c:.4} of {:.1} kPa", nominal(1.3) / 1e3);
        assert!([a, b, c].iter().all(|part| (part - 1.0).abs() < 0.03));
        assert!((left + right).abs() < 1e-3 * right, "the bar rests between its grips");
        assert!((last / first - 1.0).abs() < 1e-3, "it creeps out of its grip");
    }
}

/// A grip that starts with a velocity sends a wave: F = A ρ c V; one that lets go is left with σ/(ρ c).
#[test]
fn a_wave_leaves_a_grip_with_its_impedance() {
    let speed = (1e6f64 + 4.0 / 3.0 * 0.5e6).sqrt() / 1e3f64.sqrt();
    let overrides: Overrides<'_> = &[
        ("load.damping", "0"),
        ("drive.right.displacement", ""),
        ("drive.right.velocity", "[0.1, 0, 0]"),
        ("run.until", "0.18 ms"),
    ];
    let mut simulation = start(scene(BAR, overrides));
    until(&mut simulation, 0.02e-3);
    let [_, pull] = forces(&mut simulation, ["drive.left", "drive.right"]);
    let right = pull / (AREA * 1e3 * speed * 0.1);
    println!("F/(A rho c V) = {right:.4}");
    assert!((right - 1.0).abs() < 0.03, "{right}");

    // a hundredth of stretch, at rest, and then the right grip lets go
    let overrides: Overrides<'_> = &[
        ("drive.right.displacement", "[[0, 0, 0, 0], [0.002, 0.00008, 0, 0]]"),
        ("drive.right.until", "6 ms"),
        ("run.until", "6.15 ms"),
    ];
    let mut simulation = start(scene(BAR, overrides));
    until(&mut simulation, 6e-3);
    let before = simulation.report().expect("a report");
    let stress = stress(&simulation);
    let after = finish(&mut simulation).expect("runs");
    let impulse = |report: &Report| giver(report, "drive.right").impulse[0];
    assert_eq!(impulse(&before), impulse(&after), "who has let go gives nothing");
    // the left grip goes on to hold the stress, until the wave is there; damping takes its part
    let time = (1.0 - f64::exp(-2000.0 * 0.15e-3)) / 2000.0;
    let part = -after.materials[0].momentum[0] / (AREA * stress * time);
    println!("momentum / (sigma A t) = {part:.4}");
    assert!((part - 1.0).abs() < 0.03, "{part}");
}

/// Along the axes that a grip leaves free the matter contracts: uniaxial stress.
#[test]
fn a_grip_may_leave_axes_free() {
    let free: Overrides<'_> = &[
        ("domain.upper", "[0.016, 0.004, 0.004]"),
        ("boundary.y-max", "free"),
        ("boundary.z-max", "free"),
        ("drive.left.components", "x"),
        ("drive.right.components", "x"),
    ];
    let mut simulation = start(scene(BAR, free));
    finish(&mut simulation).expect("runs");
    let (f, x) = (numbers(&simulation, labels::Deformation::ID), numbers(&simulation, labels::Position::ID));
    let middle = f.iter().zip(&x).filter(|(_, x)| (x[0] - 7.2e-3).abs() < 1.3e-3).map(|(f, _)| f);
    let middle: Vec<&Vec<f64>> = middle.collect();
    let mean = |c: usize| middle.iter().map(|f| f[c]).sum::<f64>() / middle.len() as f64;
    // dW/dλ_t = 0 of W = μ/2 (J^(-2/3) (λ² + 2 λ_t²) − 3) + K/2 (½ (J² − 1) − ln J), J = λ λ_t²
    let slope = |l: f64, t: f64| {
        let j = l * t * t;
        let isochoric = 0.5e6 * j.powf(-2.0 / 3.0) * (t * t - (l * l + 2.0 * t * t) / 3.0);
        isochoric + 0.5e6 * (j * j - 1.0)
    };
    let (mut low, mut high) = (0.5, 1.2);
    while high - low > 1e-12 {
        let t = 0.5 * (low + high);
        if slope(mean(0), t) < 0.0 { low = t } else { high = t }
    }
    println!("stretch {:.4}, across {:.4} {:.4}, exact {low:.4}", mean(0), mean(4), mean(8));
    for across in [mean(4), mean(8)] {
        assert!(((1.0 - across) / (1.0 - low) - 1.0).abs() < 0.05);
    }
}

/// A block that a drive turns by a quarter is as it was, a quarter turned; what turns it gives it its angular momentum.
#[test]
fn what_a_drive_turns_is_not_strained() {
    let turn: Overrides<'_> = &[
        ("domain.lower", "[-0.01, -0.01, -0.002]"),
        ("domain.upper", "[0.01, 0.01, 0.002]"),
        ("boundary", "{}"),
        ("load.damping", "0"),
        ("body.bar.shape", "{ box = { lower = [1e-3, -2e-3, -1e-3], upper = [5e-3, 2e-3, 1e-3] } }"),
        (
            "drive",
            "[{ material = \"rubber\", body = \"bar\", center = [1e-3, 0, 0], angular-velocity = \
             [[0, 0, 0, 0], [1e-3, 0, 0, 3141.592653589793]] }]",
        ),
        ("run.until", "1 ms"),
    ];
    let mut simulation = start(scene(BAR, turn));
    let before = numbers(&simulation, labels::Position::ID);
    let identities = numbers(&simulation, labels::Identity::ID);
    finish(&mut simulation).expect("runs");
    let f = numbers(&simulation, labels::Deformation::ID);
    let j = |f: &Vec<f64>| {
        f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6])
            + f[2] * (f[3] * f[7] - f[4] * f[6])
    };
    let worst = f.iter().map(|f| (j(f) - 1.0).abs()).fold(0.0, f64::max);
    let after = numbers(&simulation, labels::Position::ID);
    let who = numbers(&simulation, labels::Identity::ID);
    let mut apart = 0.0f64;
    for (x, id) in before.iter().zip(&identities) {
        let now =
            who.iter().position(|other| other[0].to_bits() == id[0].to_bits()).expect("the same particles");
        let wanted = [1e-3 - x[1], x[0] - 1e-3, x[2]];
        apart = apart.max(norm([0, 1, 2].map(|a| after[now][a] - wanted[a])) / 1e-3);
    }
    println!("largest |J - 1| {worst:.1e}, positions {apart:.1e} cells");
    assert!(worst < 1e-9 && apart < 1e-9);
    // What the drive gives is what the block has gained, no more with shorter steps; but for the inertia of nodes, which reach half a
    // cell beyond the particles.
    let given = ["0.4", "0.1"].map(|cfl| {
        let mut simulation = start(scene(BAR, &[turn, &[("run.cfl", cfl)]].concat()));
        let report = finish(&mut simulation).expect("runs");
        let drive = &report.givers[0];
        assert_eq!(drive.name, "drive.0");
        let torque = drive.torque_impulse[2] / report.materials[0].angular_momentum[2];
        let work = drive.work / report.energy().kinetic;
        println!(
            "CFL {cfl}: torque impulse over angular momentum {torque:.4}, work over kinetic energy {work:.4}"
        );
        assert!((torque - 1.0).abs() < 0.06 && (work - 1.0).abs() < 0.06);
        torque
    });
    assert!((given[0] / given[1] - 1.0).abs() < 0.01);
}

/// A square bar between a grip that rests and one that turns: T = 0.1406 μ a⁴ θ/L (Saint-Venant).
#[test]
fn a_twisted_bar_resists_with_its_torque() {
    let twist: Overrides<'_> = &[
        ("domain.lower", "[0, -0.005, -0.005]"),
        ("domain.upper", "[0.028, 0.005, 0.005]"),
        ("boundary", "{}"),
        ("body.bar.shape", "{ box = { lower = [0, -3e-3, -3e-3], upper = [28e-3, 3e-3, 3e-3] } }"),
        ("drive.left.region", "{ box = { lower = [0, -3e-3, -3e-3], upper = [2e-3, 3e-3, 3e-3] } }"),
        ("drive.right.region", "{ box = { lower = [26e-3, -3e-3, -3e-3], upper = [28e-3, 3e-3, 3e-3] } }"),
        ("drive.right.displacement", ""),
        ("drive.right.angular-velocity", "[[0, 20, 0, 0], [5e-3, 20, 0, 0], [5.001e-3, 0, 0, 0]]"),
        ("run.until", "12 ms"),
    ];
    let mut simulation = start(scene(BAR, twist));
    until(&mut simulation, 10e-3);
    simulation.mark_row();
    let report = finish(&mut simulation).expect("runs");
    let [left, right] = [0, 1].map(|n| report.givers[1 + n].torque[0]);
    let exact = 0.1406 * 0.5e6 * 6e-3f64.powi(4) * 0.1 / 24e-3;
    println!("torques {left:.4e} {right:.4e}, exact {exact:.4e} N m");
    assert!((left + right).abs() < 0.01 * right);
    assert!((right / exact - 1.0).abs() < 0.1);
}

/// A column between mirrors under a block that a drive presses down and along: σ(λ) whatever the step, and friction μ times that.
#[test]
fn a_driven_block_presses_what_it_meets() {
    let pressed = |drive: &str, more: Overrides<'_>| {
        let drive = format!("[{{ name = \"press\", material = \"block\", body = \"block\", {drive} }}]");
        let column: Overrides<'_> = &[
            ("domain.upper", "[2e-3, 2e-3, 16e-3]"),
            (
                "boundary",
                "{ z-min = \"fixed\", x-min = \"symmetric\", x-max = \"symmetric\", y-min = \"symmetric\", y-max = \"symmetric\" }",
            ),
            (
                "body",
                "[{ name = \"bar\", material = \"rubber\", shape = { box = { lower = [0, 0, 0], upper = [2e-3, 2e-3, 8e-3] } } }, \
              { name = \"block\", material = \"block\", shape = { box = { lower = [0, 0, 8e-3], upper = [2e-3, 2e-3, 11e-3] } } }]",
            ),
            (
                "material.block",
                "{ law = \"neo-hookean\", density = 1000, bulk-modulus = 1e6, shear-modulus = 5e5 }",
            ),
            ("contact", "[{ between = [\"rubber\", \"block\"], law = \"friction\", friction = 0.2 }]"),
            ("drive", &drive),
        ];
        let mut simulation = start(scene(BAR, &[column, more].concat()));
        until(&mut simulation, 6e-3);
        simulation.mark_row();
        let report = finish(&mut simulation).expect("runs");
        force(&report, "contact.rubber.block").map(|f| f / AREA)
    };
    let down = "displacement = [[0, 0, 0, 0], [5e-3, 0, 0, -1.6e-3]]";
    for more in [
        &[("run.cfl", "0.4")][..],
        &[("run.cfl", "0.1")],
        &[("run.rates", "per-material"), ("material.block.bulk-modulus", "16e6")],
    ] {
        for components in ["xyz", "z"] {
            let drive = format!("{down}, components = \"{components}\"");
            let [_, _, z] = pressed(&drive, &[more, &[("run.until", "8 ms")]].concat());
            let part = z / nominal(0.8);
            println!("{more:?}, {components}: {part:.4} of {:.1} kPa", nominal(0.8) / 1e3);
            assert!((part - 1.0).abs() < 0.04, "{more:?}: {part}");
        }
    }
}

/// A block that a drive presses onto a slab and draws along rubs with μ times what it presses with, wherever the surface lies between nodes. It is as
/// wide as the slab: a leading edge would plough, too.
#[test]
fn a_driven_block_rubs_by_coulomb() {
    let slab: Overrides<'_> = &[
        ("domain.lower", "[-14e-3, 0, 0]"),
        ("domain.upper", "[18e-3, 8e-3, 1e-3]"),
        ("boundary", "{ y-min = \"fixed\", z-min = \"symmetric\", z-max = \"symmetric\" }"),
        (
            "body",
            "[{ name = \"bar\", material = \"rubber\", particles-per-cell = [2, 2, 1], \
                shape = { box = { lower = [-12e-3, 0, 0], upper = [12e-3, 4e-3, 1e-3] } } }, \
              { name = \"block\", material = \"block\", particles-per-cell = [2, 2, 1], \
                shape = { box = { lower = [-12e-3, 4e-3, 0], upper = [12e-3, 6e-3, 1e-3] } } }]",
        ),
        (
            "material.block",
            "{ law = \"neo-hookean\", density = 1000, bulk-modulus = 1e6, shear-modulus = 5e5 }",
        ),
        ("contact", "[{ between = [\"rubber\", \"block\"], law = \"friction\", friction = 0.5 }]"),
        (
            "drive",
            "[{ material = \"block\", body = \"block\", displacement = [[0, 0, 0, 0], [8e-3, 0.8e-3, -0.2e-3, 0]] }]",
        ),
        ("load.damping", "1000"),
        ("run.until", "8 ms"),
    ];
    let mut simulation = start(scene(BAR, slab));
    for time in [3e-3, 5e-3, 8e-3] {
        simulation.mark_row();
        until(&mut simulation, time - 1e-9);
        let [along, down, _] = force(&simulation.report().expect("one rank"), "contact.rubber.block");
        println!("until {time} s: pressed with {:.4} N, friction {:.4} of it", -down, along / -down);
        assert!(down < 0.0 && (along / -down / 0.5 - 1.0).abs() < 0.02);
    }
}
