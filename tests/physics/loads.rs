//! What acts on all matter: gravity in time, damping by mass, local damping; and the steps that heed them.

use crate::common;
use crate::common::{Overrides, numbers, run, scene, start};
use engine::schema::Label;
use tasks::labels;

/// A block that flies.
const BLOCK: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["8 mm", "8 mm", "40 mm"]
cell = "1 mm"
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "100 kPa"
shear-modulus = "50 kPa"
[[body]]
name = "block"
material = "soft"
shape = { box = { lower = ["2 mm", "2 mm", "20 mm"], upper = ["6 mm", "6 mm", "24 mm"] } }
[run]
until = "20 ms"
cfl = 0.4
"#;

fn speed(overrides: Overrides<'_>) -> f64 {
    run(scene(BLOCK, overrides)).materials[0].velocity()[2]
}

#[test]
fn gravity_in_time_gives_its_integral() {
    let table = "[[0, 0, 0, 0], [0.01, 0, 0, -20], [0.011, 0, 0, 10], [1, 0, 0, 10]]";
    let exact = -0.5 * 0.01 * 20.0 - 0.5 * 0.001 * 10.0 + 10.0 * 0.009;
    let found = speed(&[("load.gravity", table)]);
    assert!((found / exact - 1.0).abs() < 1e-12, "{found}, not {exact}");
}

#[test]
fn damping_is_an_exponential_however_strong_it_is() {
    // a step is about 0.03 ms: the second is far beyond the limit of an explicit rule
    for rate in [50.0, 3e5] {
        let value = format!("{rate}");
        let start = [("load.damping", &*value), ("body.block.velocity", "[0, 0, 0.5]")];
        let found = speed(&start);
        let exact = 0.5 * f64::exp(-rate * 0.02);
        assert!((found - exact).abs() < 1e-13, "{found}, not {exact}");
        let falling = speed(&[("load.damping", &value), ("load.gravity", "[0, 0, -10]")]);
        let exact = -10.0 * (1.0 - f64::exp(-rate * 0.02)) / rate;
        assert!((falling / exact - 1.0).abs() < 1e-11, "{falling}, not {exact}");
    }
}

#[test]
fn local_damping_takes_its_share_of_what_is_out_of_balance() {
    let falling = [("load.local-damping", "0.3"), ("load.gravity", "[0, 0, -10]")];
    let found = speed(&[&falling[..], &[("body.block.velocity", "[0, 0, -0.1]")]].concat());
    assert!((found + 0.1 + 0.7 * 0.2).abs() < 1e-12, "{found}");
    // upwards it brakes, too: a body that rises comes to rest sooner
    let found = speed(&[&falling[..], &[("body.block.velocity", "[0, 0, 0.5]")]].concat());
    assert!((found - (0.5 - 1.3 * 0.2)).abs() < 1e-12, "{found}");
}

#[test]
fn a_lone_ball_does_not_fall_in_one_step() {
    let rigid = "{ law = \"rigid\", motion = \"free\", density = 1000 }";
    let fall: Overrides<'_> =
        &[("material.soft", rigid), ("load.gravity", "[0, 0, -10]"), ("run.until", "50 ms")];
    let mut simulation = start(scene(BLOCK, fall));
    simulation.step().expect("steps");
    let (first, limit) = (simulation.clock().tick, (0.4 * 1e-3 / 10.0f64).sqrt());
    assert!((first / limit - 1.0).abs() < 1e-12, "{first}, not {limit}");
    let report = common::finish(&mut simulation).expect("runs");
    assert!((report.materials[0].velocity()[2] + 0.5).abs() < 1e-12 && simulation.steps() > 10);
    // no step is longer than what it falls through is worth: a part of a cell
    assert!(simulation.steps() as f64 >= 0.5 * 10.0 * 0.05 * 0.05 / (0.4 * 1e-3));
}

/// A column under its own weight, between mirrors and on a mirror: P = −ρ₀ g (L − Z), whatever the law.
#[test]
fn a_column_under_its_own_weight_bears_it() {
    let column: Overrides<'_> = &[
        ("domain.upper", "[0.002, 0.002, 0.014]"),
        ("body.block.shape.box.lower", "[0, 0, 0]"),
        ("body.block.shape.box.upper", "[0.002, 0.002, 0.012]"),
        ("boundary.x-min", "symmetric"),
        ("boundary.x-max", "symmetric"),
        ("boundary.y-min", "symmetric"),
        ("boundary.y-max", "symmetric"),
        ("boundary.z-min", "symmetric"),
        ("load.gravity", "[[0, 0, 0, 0], [0.02, 0, 0, -1000]]"),
        ("run.until", "60 ms"),
    ];
    for damping in [("load.damping", "500"), ("load.local-damping", "0.8")] {
        let mut simulation = start(scene(BLOCK, &[column, &[damping]].concat()));
        let height: Vec<(u64, f64)> = {
            let who = numbers(&simulation, labels::Identity::ID).into_iter();
            who.zip(numbers(&simulation, labels::Position::ID))
                .map(|(id, x)| (id[0].to_bits(), x[2]))
                .collect()
        };
        common::finish(&mut simulation).expect("runs");
        let who = numbers(&simulation, labels::Identity::ID);
        let (f, tau) = (
            numbers(&simulation, labels::Deformation::ID),
            numbers(&simulation, labels::KirchhoffStress::ID),
        );
        // by layers of cells: the stress of a cell is that of its middle
        let mut layers = [(0.0, 0.0); 12];
        for ((id, f), tau) in who.iter().zip(&f).zip(&tau) {
            let z = height.iter().find(|(other, _)| *other == id[0].to_bits()).expect("the particle").1;
            let layer = &mut layers[(z / 1e-3) as usize];
            *layer = (layer.0 + tau[5] / f[8], layer.1 + 1.0);
        }
        let wanted = |layer: usize| -1e3 * 1e3 * 1e-3 * (11.5 - layer as f64);
        let error = |(layer, (sum, count)): (usize, &(f64, f64))| (sum / count - wanted(layer)).abs() / 12e3;
        let worst = layers.iter().enumerate().map(error).fold(0.0, f64::max);
        println!("{damping:?}: stresses are off by {:.2} % of the largest", 100.0 * worst);
        assert!(worst < 0.02, "{worst}");
    }
}

/// What a tool gives is what the floor gets: local damping takes its share of what is out of balance after both.
#[test]
fn local_damping_does_not_falsify_what_a_tool_gives() {
    let pressed: Overrides<'_> = &[
        ("domain.upper", "[0.002, 0.002, 0.016]"),
        (
            "boundary",
            "{ x-min = 'symmetric', x-max = 'symmetric', y-min = 'symmetric', y-max = 'symmetric', z-min = 'symmetric' }",
        ),
        (
            "material.plate",
            "{ law = 'rigid', motion = 'prescribed', density = 1000, velocity = [0, 0, -0.02] }",
        ),
        (
            "body",
            "[{ name = 'block', material = 'soft', shape = { box = { lower = [0, 0, 0], upper = [0.002, 0.002, 0.012] } } }, \
              { name = 'plate', material = 'plate', shape = { half-space = { point = [0, 0, 0.012], normal = [0, 0, -1] } } }]",
        ),
        ("contact", "[{ between = ['soft', 'plate'], law = 'friction', friction = 0 }]"),
        ("run.until", "50 ms"),
    ];
    let forces = ["0", "0.5"].map(|share| {
        let mut simulation = start(scene(BLOCK, &[pressed, &[("load.local-damping", share)]].concat()));
        while simulation.clock().time < 40e-3 {
            simulation.step().expect("steps");
        }
        simulation.mark_row();
        let report = common::finish(&mut simulation).expect("runs");
        let force =
            |name: &str| report.givers.iter().find(|giver| giver.name == name).expect("it gives").force[2];
        println!(
            "local damping {share}: plate {:.5} N, floor {:.5} N",
            force("rigid.plate"),
            force("face.z-min")
        );
        [force("rigid.plate"), force("face.z-min")]
    });
    for [plate, floor] in forces {
        assert!(
            (plate / floor + 1.0).abs() < 0.01 && (floor / forces[0][1] - 1.0).abs() < 0.01,
            "{forces:?}"
        );
    }
}
