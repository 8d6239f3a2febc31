//! Every problem that has an `expect.toml` meets it: the command runs the scene, and its numbers are compared with references whose
//! source the file states. `docs/VALIDATION.md` has them all; it is written anew, with what is measured now, by
//!
//!     SINEW_WRITE_DOCS=1 cargo test --test problems -- --include-ignored
//!
//! and with the name of a test behind `problems` only the table of that problem is.
mod expect;
mod page;

use assert_cmd::Command;
use expect::{Metric, Run};
use std::collections::BTreeMap;

/// How far a number may be from the one in the page, as a part of its tolerance: room for an instruction set that rounds differently. With
/// AVX-512, with AVX2 alone and without either the digits of the page are the same, but for balances, which are rounding.
const DRIFT: f64 = 0.25;

fn meets_expectations(problem: &str) {
    let metrics = expect::metrics(problem);
    assert!(!metrics.is_empty(), "{problem} has an expect.toml");
    let mut runs: BTreeMap<Vec<String>, Run> = BTreeMap::new();
    for metric in &metrics {
        let sets = [Some(&metric.set), metric.plus.as_ref(), metric.minus.as_ref()];
        for set in sets.into_iter().flatten() {
            let wound = metrics.iter().any(|other| other.set == *set && other.of_wound());
            runs.entry(set.clone()).or_insert_with(|| expect::run(problem, set, wound));
        }
    }
    let second = |m: &Metric, set: &Option<Vec<String>>| set.as_ref().map_or(0.0, |set| m.value(&runs[set]));
    let value = |m: &Metric| m.value(&runs[&m.set]) + second(m, &m.plus) - second(m, &m.minus);
    let values: Vec<(Metric, f64)> = metrics.iter().map(|m| (m.clone(), value(m))).collect();
    page::note(problem, &values);
    let written = page::measured();
    let mut missed = Vec::new();
    for (m, value) in &values {
        let Metric { name, reference, tolerance, source, .. } = m;
        println!("{problem}: {name} = {value:.6} (reference {reference} ± {tolerance}, {source})");
        if m.meets(*value) == m.open.is_some() {
            let is = if m.open.is_some() { "open, and met" } else { "missed" };
            missed.push(format!("{name}: {value}, {reference} ± {tolerance}: {is}"));
        }
        let before = written.get(&page::key(problem, m)).and_then(|text| text.parse::<f64>().ok());
        let drift = before.map_or(f64::INFINITY, |before| (value - before).abs());
        if m.open.is_none() && (drift.is_nan() || drift > DRIFT * tolerance) {
            missed.push(format!("{name}: {value}, but docs/VALIDATION.md has {before:?}"));
        }
    }
    assert!(missed.is_empty(), "{problem}: {missed:#?}");
}

/// The page has every number of every `expect.toml`, with its present reference, tolerance and source; and what it says was measured is
/// within the tolerance.
#[test]
fn the_page_has_every_number() {
    if std::env::var_os("SINEW_WRITE_DOCS").is_some() {
        return; // the other tests are writing it
    }
    let measured = page::measured();
    assert!(
        page::page(&measured) == page::read(),
        "docs/VALIDATION.md is out of date: SINEW_WRITE_DOCS=1 cargo test --test problems -- --include-ignored"
    );
    for problem in page::problems() {
        for metric in expect::metrics(&problem) {
            let text = measured.get(&page::key(&problem, &metric)).expect("the page was made of this");
            let value: f64 = text.parse().unwrap_or_else(|_| panic!("{problem}, {}: {text}", metric.name));
            assert!(metric.meets(value) != metric.open.is_some(), "{problem}, {}: {value}", metric.name);
            assert!(!metric.source.ends_with('.') && !metric.source.contains('|'), "{}", metric.source);
        }
    }
}

/// Each problem has a page: a picture or a plot, the command, how long it takes, what is expected.
#[test]
fn every_problem_has_a_page_with_a_picture_and_its_command() {
    for folder in std::fs::read_dir("problems").expect("the problems") {
        let folder = folder.expect("a folder").path();
        let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
        let text = std::fs::read_to_string(folder.join("README.md")).expect("a page");
        assert!(text.contains(&format!("tools/run problems/{name}")), "{name}: no command");
        assert!(text.contains("!["), "{name}: no picture");
        for link in text.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
            let local = !link.contains("://") && !link.starts_with('#');
            let file = link.split('#').next().unwrap_or_default();
            assert!(!local || folder.join(file).exists(), "{name}: there is no {link}");
        }
        assert!(text.contains("Time"), "{name}: not how long it takes");
    }
}

#[test]
fn slab_quick() {
    meets_expectations("slab-quick");
}

#[test]
fn two_spheres() {
    meets_expectations("two-spheres");
}

#[test]
fn sliding_block() {
    meets_expectations("sliding-block");
}

#[test]
fn taylor_rod() {
    meets_expectations("taylor-rod");
}

#[test]
fn tension() {
    meets_expectations("tension");
}

#[test]
fn hertz() {
    meets_expectations("hertz");
}

#[test]
#[ignore = "long"]
fn cantilever() {
    meets_expectations("cantilever");
}

#[test]
fn ball_on_plane() {
    meets_expectations("ball-on-plane");
}

#[test]
fn sliding() {
    meets_expectations("sliding");
}

#[test]
fn tension_failure() {
    meets_expectations("tension-failure");
}

#[test]
fn oblique_shot() {
    meets_expectations("oblique-shot");
}

#[test]
#[ignore = "long"]
fn slab_rigid() {
    meets_expectations("slab-rigid");
}

#[test]
#[ignore = "long"]
fn slab_coarse() {
    meets_expectations("slab-coarse");
}

#[test]
#[ignore = "long"]
fn slab() {
    meets_expectations("slab");
}

#[test]
#[ignore = "long"]
fn slab_150() {
    meets_expectations("slab-150");
}

/// Impulses come in opposite pairs and act only on surfaces that approach and touch: nothing can pull the ball, and only
/// tissue that flies faster can push it. What it gains once its tail has left the slab is below a ten-thousandth of its
/// speed.
#[test]
fn the_ball_does_not_gain_speed_after_it_has_left() {
    let out = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::cargo_bin("sinew").expect("the command is built");
    command.args(["run", "problems/slab-quick", "--quiet", "--set", "output.frames=0"]);
    command.args(["--set", "output.history-every=1", "--out"]).arg(out.path()).assert().success();
    let history = std::fs::read_to_string(out.path().join("history.csv")).expect("a history");
    let mut rows = history.lines();
    let header: Vec<&str> = rows.next().expect("a header").split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).expect("the column");
    let (speed, place) = (column("lead.mean_velocity_y_m_s"), column("lead.center_y_m"));
    let get =
        |row: &str, c: usize| row.split(',').nth(c).and_then(|x| x.parse::<f64>().ok()).expect("a number");
    // tail of the ball (radius 4.5 mm) behind the exit surface (−6 mm)
    let after: Vec<f64> =
        rows.filter(|row| get(row, place) + 4.5e-3 < -6e-3).map(|row| -get(row, speed)).collect();
    assert!(after.len() > 500, "the ball leaves the slab well before the end");
    let (first, fastest) = (after[0], after.iter().copied().fold(0.0, f64::max));
    println!(
        "speed when the tail leaves {first:.6} m/s, largest afterwards {fastest:.6}, at the end {:.6}",
        after[after.len() - 1]
    );
    assert!(fastest < first * (1.0 + 1e-4), "{first} m/s when it left, {fastest} m/s later");
}
