//! What is followed in time: against closed forms, the same on any patches, threads and over a restart.

use crate::common::command::{ok, sinew, text, words};
use crate::common::rubber::{RUBBER, pulled, stress_of};
use crate::common::{Overrides, run, scene, start};
use sinew::input::read_text;
use sinew::output::history::Table;
use std::path::Path;

const PROBES: &str = r#"
[[probe]]
name = "corner"
material = "rubber"
field = "displacement"
at = ["11.9 mm", "3.9 mm", "0.1 mm"]
[[probe]]
name = "right"
material = "rubber"
field = "reference_position"
region = { box = { lower = ["6 mm", 0, 0], upper = ["12 mm", "4 mm", "4 mm"] } }
[[probe]]
name = "most"
material = "rubber"
field = "reference_position"
value = "largest"
[[probe]]
name = "least"
material = "rubber"
field = "reference_position"
value = "smallest"
body = "block"
[[probe]]
material = "rubber"
field = "stress"
"#;

/// The block with its probes.
fn block() -> String {
    format!("{RUBBER}{PROBES}")
}

/// Room around it.
const ROOM: &str = "[\"30 mm\", \"12 mm\", \"4 mm\"]";

#[track_caller]
fn close(found: &[f64], expected: &[f64], scale: f64) {
    assert_eq!(found.len(), expected.len());
    for (x, y) in found.iter().zip(expected) {
        assert!((x - y).abs() <= 1e-9 * scale, "{found:?} {expected:?}");
    }
}

#[test]
fn probes_show_what_is_known() {
    let report = run(scene(
        &block(),
        &[("body.block.velocity", "[20, 10, 0]"), ("domain.upper", ROOM), ("run.until", "0.4 ms")],
    ));
    let [way, right, most, least] = [0, 3, 6, 9].map(|i| &report.probes[i..i + 3]);
    close(way, &[8e-3, 4e-3, 0.0], 1e-2);
    close(right, &[9e-3, 2e-3, 2e-3], 1e-2);
    close(most, &[11.75e-3, 3.75e-3, 3.75e-3], 1e-2);
    close(least, &[0.25e-3; 3], 1e-2);
    assert_eq!(report.probes.len(), 18);

    let report = run(scene(&block(), &pulled()));
    let [along, across] = stress_of(1.2);
    close(&report.probes[12..18], &[along, across, across, 0.0, 0.0, 0.0], 1e6);
}

#[test]
fn the_mean_is_by_mass_and_leaves_out_what_is_no_number() {
    // a second body, twice as heavy a particle: half the particles along z
    let two: Overrides<'_> = &[
        (
            "material.metal",
            "{ law = \"neo-hookean\", density = 3000, bulk-modulus = \"1 MPa\", shear-modulus = \"0.5 MPa\" }",
        ),
        ("probe.0.material", "metal"),
    ];
    let error = read_text(
        "test",
        &block(),
        &two.iter().map(|&(k, v)| (k.to_owned(), v.to_owned())).collect::<Vec<_>>(),
        None,
    );
    let words = format!("{:?}", miette::Report::new(error.expect_err("metal has no body")));
    assert!(words.contains("metal"), "{words}");
    // a free rigid body has no stress: not a number, an empty cell
    let rigid: Overrides<'_> = &[
        ("material.rubber", "{ law = \"rigid\", motion = \"free\", density = 1000 }"),
        ("probe.4.field", "velocity"),
        ("body.block.velocity", "[20, 10, 0]"),
    ];
    let report = start(scene(&block(), rigid)).report().expect("one rank");
    close(&report.probes[12..15], &[20.0, 10.0, 0.0], 1e2);
}

fn history(folder: &Path) -> String {
    ok(std::fs::read_to_string(folder.join("history.csv")))
}

#[test]
fn probes_are_the_same_on_any_layout_and_over_a_restart() {
    let folder = ok(tempfile::tempdir());
    let file = folder.path().join("scene.toml");
    ok(std::fs::write(&file, format!("{}[load]\ngravity = [0, -1e4, 0]\n", block())));
    let [whole, cut, parts] = ["whole", "cut", "parts"].map(|name| folder.path().join(name));
    let room = format!("domain.upper={ROOM}");
    let run = |out: &Path, more: &[&str]| {
        let output = sinew(
            &[
                &[
                    "run",
                    text(&file),
                    "-q",
                    "--out",
                    text(out),
                    "--set",
                    "boundary.y-min=fixed",
                    "--set",
                    &room,
                ],
                more,
            ]
            .concat(),
        );
        assert!(output.status.success(), "{}", words(&output));
    };
    run(&whole, &["--steps", "30", "--threads", "1", "--patches", "1x1x1"]);
    run(&cut, &["--steps", "30", "--threads", "2", "--patches", "4x2x1"]);
    run(&parts, &["--steps", "13"]);
    let again = sinew(&["run", "--restart", text(&parts), "-q", "--steps", "30"]);
    assert!(again.status.success(), "{}", words(&again));
    assert_eq!(history(&whole), history(&cut));
    assert_eq!(history(&whole), history(&parts));
    let table = ok(Table::read(&whole.join("history.csv")));
    let column = |name: &str| table.column(name).unwrap_or_else(|| panic!("no {name} in {:?}", table.header));
    assert!(column("probe.corner.displacement_y_m").last().is_some_and(|way| *way < -1e-6));
    assert!(column("probe.4.stress_yy_pa").iter().all(|s| s.is_finite()));
    let other = sinew(&["run", "--restart", text(&parts), "-q", "--steps", "40", "--set", "probe.0.at.0=0"]);
    assert!(other.status.code() == Some(2) && words(&other).contains("probe.0.at"), "{}", words(&other));
}

#[test]
fn probes_of_nothing_are_refused() {
    for (key, value, expected) in [
        (
            "probe.right.region",
            "{ sphere = { center = [\"25 mm\", 0, 0], radius = \"1 mm\" } }",
            "no particle of \"rubber\" lies in this region",
        ),
        ("probe.corner.field", "fiber_direction", "something of the law \"tissue\""),
        ("probe.corner.value", "mean", "`value` has no meaning for one particle"),
        ("probe.corner.body", "block", "a probe `at` a point has no region"),
        ("probe.right.name", "corner", "there are two probes named \"corner\""),
        ("probe.right.value", "median", "mean"),
        ("probe.right.material", "steel", "there is no material \"steel\""),
    ] {
        let overrides = [(key.to_owned(), value.to_owned())];
        let error = read_text("test", &block(), &overrides, None).expect_err(expected);
        let words = format!("{:?}", miette::Report::new(error)).replace('│', " ");
        let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(expected), "{key}: {words}");
    }
}
