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

const DENSE: &str = r#"
[output]
frames = 2
history-every = 1000
[[output.period]]
from = "50 us"
to = "100 us"
frames-every = "10 us"
[[output.period]]
from = "70 us"
history-every = 2
to = "90 us"
"#;

/// Time between two steps of a run, at most [s].
const STEP: f64 = 2.5e-5;

/// The times of rows in which a column has a number.
fn times(table: &Table, column: &str) -> Vec<f64> {
    let (time, column) = (table.column("time_s"), table.column(column));
    let (time, column) = (time.unwrap_or_default(), column.unwrap_or_default());
    time.into_iter().zip(column).filter(|(_, x)| x.is_finite()).map(|(t, _)| t).collect()
}

#[test]
fn a_probe_has_its_interval_and_output_its_periods_also_over_a_restart() {
    let folder = ok(tempfile::tempdir());
    let file = folder.path().join("scene.toml");
    ok(std::fs::write(&file, format!("{}{DENSE}", block())));
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    let run = |out: &Path, end: [&str; 2]| {
        let set = [
            "probe.0.interval=4 us",
            "probe.1.interval=30 us",
            "run.cfl=0.02",
            "body.block.velocity=[20, 0, 0]",
        ];
        let room = format!("domain.upper={ROOM}");
        let set = set.iter().flat_map(|pair| ["--set", pair]);
        let words_: Vec<&str> =
            ["run", text(&file), "-q", end[0], end[1], "--out", text(out), "--set", &room]
                .into_iter()
                .chain(set)
                .collect();
        let output = sinew(&words_);
        assert!(output.status.success(), "{}", words(&output));
    };
    run(&whole, ["--until", "200 us"]);
    // in the middle of both periods
    run(&parts, ["--steps", "245"]);
    let again = sinew(&["run", "--restart", text(&parts), "-q", "--steps", "100000", "--until", "200 us"]);
    assert!(again.status.success(), "{}", words(&again));
    assert!(history(&whole) == history(&parts), "a restart writes the same rows");

    let table = ok(Table::read(&whole.join("history.csv")));
    let step = table.column("step_size_s").unwrap_or_default().into_iter().fold(0.0, f64::max);
    assert!(step > 0.0 && step < 1e-6 && STEP > step, "steps are short against the intervals: {step}");
    // the first step that ends after each interval, and the rows of all columns
    let all = times(&table, "rubber.kinetic_j");
    for (probe, every) in [("corner.displacement_x_m", 4e-6), ("right.reference_position_x_m", 3e-5)] {
        let own: Vec<f64> =
            times(&table, &format!("probe.{probe}")).into_iter().filter(|t| !all.contains(t)).collect();
        let due: Vec<f64> = (1..).map(|k| f64::from(k) * every).take_while(|t| *t < 2e-4 - step).collect();
        let missed =
            due.iter().filter(|due| !own.iter().chain(&all).any(|t| (-1e-12..=step).contains(&(t - **due))));
        assert_eq!(missed.count(), 0, "{probe}: {own:?}");
        assert!(own.len() <= due.len(), "{probe}: {own:?}");
    }
    // what a row of its own says is what the particle does: it flies
    let way = table.column("probe.corner.displacement_x_m").unwrap_or_default();
    let time = table.column("time_s").unwrap_or_default();
    for (t, x) in time.iter().zip(way).filter(|(_, x)| x.is_finite()) {
        assert!((x - 20.0 * t).abs() < 1e-9, "{x} at {t}");
    }
    // rows of all columns: the first and the last, and every other step of the period
    let dense = all.iter().filter(|t| (7e-5..9e-5).contains(*t)).count() as f64;
    assert!((dense - 2e-5 / (2.0 * step)).abs() < 0.2 * dense, "{dense} rows in the period");
    assert_eq!(all.len() as f64, dense + 2.0);

    let frames = |folder: &Path| {
        ok(sinew::output::vtkhdf::Reader::open(&folder.join("particles.vtkhdf"))).times().to_vec()
    };
    let due = [0.0, 5e-5, 6e-5, 7e-5, 8e-5, 9e-5, 1e-4, 2e-4];
    let found = frames(&whole);
    assert_eq!(found.len(), due.len(), "{found:?}");
    assert!(found.iter().zip(due).all(|(t, due)| (-1e-12..=step).contains(&(t - due))), "{found:?}");
    assert_eq!(frames(&parts), found);
}

#[test]
fn periods_that_say_nothing_are_refused() {
    for (value, expected) in [
        ("[{ from = 1, to = 0.5, history-every = 1 }]", "the period ends at 0.5 s, and begins at 1 s"),
        ("[{ from = 0.5 }]", "the period changes nothing"),
        ("[{ frames-every = 0 }]", "output.period.0.frames-every"),
    ] {
        let overrides = [("output.period".to_owned(), value.to_owned())];
        let error = read_text("test", &block(), &overrides, None).expect_err(expected);
        let words = format!("{:?}", miette::Report::new(error)).replace('│', " ");
        assert!(words.split_whitespace().collect::<Vec<_>>().join(" ").contains(expected), "{words}");
    }
    let none = [("output.frames", "0"), ("output.period", "[{ frames-every = 1 }]")];
    let error = read_text("test", &block(), &none.map(|(k, v)| (k.to_owned(), v.to_owned())), None);
    let words = format!("{:?}", miette::Report::new(error.expect_err("no frames")));
    assert!(words.contains("there are no frames at all"), "{words}");
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
        ("probe.corner.at", "[11.9, 0, 0]", "outside of the domain"),
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
