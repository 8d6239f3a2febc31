//! What drives hold meets others: it goes as they say, takes and gives energy as it should, and carries what lies on it.

use crate::common::{finish, giver, scene, start, until};
use sinew::simulation::Report;

/// A block lies flat on a slab; a drive presses it down.
const PRESSED: &str = r#"
[domain]
lower = ["-14 mm", 0, 0]
upper = ["18 mm", "8 mm", "1 mm"]
cell = "1 mm"
[material.slab]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "0.5 MPa"
[material.block]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "0.5 MPa"
[[body]]
name = "slab"
material = "slab"
shape = { box = { lower = ["-12 mm", 0, 0], upper = ["12 mm", "4 mm", "1 mm"] } }
[[body]]
name = "block"
material = "block"
shape = { box = { lower = ["-12 mm", "4 mm", 0], upper = ["12 mm", "6 mm", "1 mm"] } }
[[contact]]
between = ["slab", "block"]
law = "friction"
friction = 0.5
[[drive]]
name = "press"
material = "block"
body = "block"
displacement = [[0, 0, 0, 0], ["8 ms", 0, "-0.2 mm", 0]]
[boundary]
y-min = "fixed"
z-min = "symmetric"
z-max = "symmetric"
[load]
damping = 1000
[run]
until = "8 ms"
cfl = 0.4
"#;

fn strain(report: &Report) -> f64 {
    report.materials.iter().map(|material| material.energies.strain).sum()
}

/// Where a drive leaves an axis free, stopping an approach makes surfaces slip, and friction acts on that slip: it takes energy and gives none.
#[test]
fn friction_takes_energy_of_what_is_held_along_some_axes() {
    let pressed = |more: &[(&str, &str)]| {
        let mut simulation = start(scene(PRESSED, more));
        finish(&mut simulation).expect("runs")
    };
    let whole = pressed(&[]);
    for more in [&[][..], &[("run.cfl", "0.2")], &[("contact.0.friction", "0")]] {
        let report = pressed(&[&[("drive.0.components", "y")], more].concat());
        let (work, stored) = (report.boundary_work, strain(&report));
        println!(
            "{more:?}: friction {:.2e}, impact {:.2e}, strain {stored:.3e}, residual {:.1e} of {:.2e} J",
            report.friction, report.impact, report.residual, report.turnover
        );
        assert!(report.friction > -1e-3 * report.turnover, "friction gives {}", report.friction);
        assert!(report.impact.abs() < 0.02 * report.turnover, "impact takes {}", report.impact);
        assert!((stored / strain(&whole) - 1.0).abs() < 0.05, "{stored} of {}", strain(&whole));
        assert!(work > 0.0 && report.residual.abs() < 2e-3 * report.turnover);
    }
}

/// A free plate, pressed with a force, rests on matter that a drive holds: it neither sinks nor slides, and gives the drive what presses it.
#[test]
fn a_rigid_body_rests_on_what_is_held() {
    const RESTS: &str = r#"
[domain]
lower = [0, 0, 0]
upper = ["10 mm", "10 mm", "12 mm"]
cell = "1 mm"
[material.block]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "0.5 MPa"
[material.plate]
law = "rigid"
motion = "free"
density = 1000
force = [0.1, 0, -0.5]
[[body]]
name = "block"
material = "block"
shape = { box = { lower = ["1 mm", "1 mm", "2 mm"], upper = ["9 mm", "9 mm", "6 mm"] } }
[[body]]
name = "plate"
material = "plate"
shape = { box = { lower = ["2 mm", "2 mm", "6 mm"], upper = ["8 mm", "8 mm", "8 mm"] } }
[[contact]]
between = ["block", "plate"]
law = "friction"
friction = 0.3
[[drive]]
name = "hold"
material = "block"
body = "block"
[run]
until = "4 ms"
cfl = 0.4
"#;
    let bond = "[{ between = [\"block\", \"plate\"], law = \"bonded\" }]";
    for (more, name) in [
        (&[][..], "friction"),
        (&[("run.cfl", "0.1")], "friction, short steps"),
        (&[("contact", bond)], "bonded"),
    ] {
        let mut simulation = start(scene(RESTS, more));
        until(&mut simulation, 2e-3);
        simulation.mark_row();
        let report = finish(&mut simulation).expect("runs");
        let plate = &report.materials[1];
        let speed = plate.momentum.map(|p| p / plate.mass);
        let fallen = plate.center[2] - 7e-3;
        let [contact, drive] = ["contact.block.plate", "drive.hold"].map(|name| giver(&report, name).force);
        println!(
            "{name}: fallen {fallen:.1e} m, speed {speed:?} m/s, contact {contact:.4?}, drive {drive:.4?} N, residual {:.1e} of {:.1e} J",
            report.residual, report.turnover
        );
        assert!(fallen.abs() < 1e-7 && speed[2].abs() < 1e-5, "{name}");
        assert!((contact[2].abs() / 0.5 - 1.0).abs() < 1e-3 && (drive[2] / 0.5 - 1.0).abs() < 1e-3, "{name}");
        assert!(speed[0].abs() < 1e-5 && (drive[0] / -0.1 - 1.0).abs() < 1e-3, "{name}: it sticks");
        assert!(report.residual.abs() < 0.01 * report.turnover, "{name}");
    }
}

/// A block that a drive presses and one that is bonded to its side press a column: what the drive gives is ∫F dz, in whatever order the scene lists
/// its contacts.
#[test]
fn what_is_bonded_to_a_driven_block_takes_no_energy_from_nowhere() {
    let boxes = |x: [f64; 2], z: [f64; 2]| {
        format!(
            "{{ box = {{ lower = [{}e-3, 0, {}e-3], upper = [{}e-3, 4e-3, {}e-3] }} }}",
            x[0], z[0], x[1], z[1]
        )
    };
    let soft = "{ law = \"neo-hookean\", density = 1000, bulk-modulus = 1e6, shear-modulus = 5e5 }";
    let bodies = format!(
        "[{{ name = \"bar\", material = \"slab\", shape = {} }}, {{ name = \"block\", material = \"block\", shape = {} }}, \
         {{ name = \"side\", material = \"side\", shape = {} }}]",
        boxes([0.0, 4.0], [0.0, 8.0]),
        boxes([0.0, 2.0], [8.0, 11.0]),
        boxes([2.0, 4.0], [8.0, 11.0])
    );
    let rubs = |a: &str| format!("{{ between = [\"slab\", \"{a}\"], law = \"friction\", friction = 0.2 }}");
    let bond = "{ between = [\"block\", \"side\"], law = \"bonded\" }";
    let mut found = Vec::new();
    for contacts in [
        format!("[{}, {}, {bond}]", rubs("block"), rubs("side")),
        format!("[{bond}, {}, {}]", rubs("side"), rubs("block")),
    ] {
        let overrides: [(&str, &str); 11] = [
            ("domain.lower", "[0, 0, 0]"),
            ("domain.upper", "[4e-3, 4e-3, 16e-3]"),
            ("material.side", soft),
            ("body", &bodies),
            ("contact", &contacts),
            ("drive.0.displacement", "[[0, 0, 0, 0], [5e-3, 0, 0, -1.6e-3]]"),
            (
                "boundary",
                "{ z-min = \"fixed\", x-min = \"symmetric\", x-max = \"symmetric\", y-min = \"symmetric\", y-max = \"symmetric\" }",
            ),
            ("load.damping", "2000"),
            ("run.until", "5 ms"),
            ("run.cfl", "0.4"),
            ("title", "pressed"),
        ];
        let mut simulation = start(scene(PRESSED, &overrides));
        let mut by_force = 0.0;
        simulation.mark_row();
        while simulation.step().expect("runs") {
            let report = simulation.report().expect("one rank");
            by_force -= giver(&report, "drive.press").force[2] * report.step * 1.6e-3 / 5e-3;
            simulation.mark_row();
        }
        let report = simulation.report().expect("one rank");
        let work = giver(&report, "drive.press").work;
        println!(
            "drive {work:.4e}, ∫F dz {by_force:.4e}, impact {:.1e}, transfer {:.1e} J",
            report.impact, report.transfer
        );
        assert!((work / by_force - 1.0).abs() < 0.02, "{work} {by_force}");
        assert!(report.impact.abs() < 0.05 * work && report.transfer.abs() < 0.05 * work);
        found.push(work);
    }
    assert!((found[0] / found[1] - 1.0).abs() < 1e-3, "{found:?}");
}
