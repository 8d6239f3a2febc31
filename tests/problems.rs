//! Every problem that has an `expect.toml` and is quick enough meets it: the command runs the scene, and the numbers of
//! `summary.json` are compared with references whose source the file states.
use assert_cmd::Command;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

#[derive(Deserialize)]
struct Expectations {
    metric: Vec<Metric>,
}

#[derive(Deserialize)]
struct Metric {
    name: String,
    path: String,
    #[serde(default)]
    set: Vec<String>,
    reference: f64,
    tolerance: f64,
    source: String,
}

/// Runs a scene with overrides; the summary.
fn summary(problem: &str, set: &[String]) -> serde_json::Value {
    let out = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::cargo_bin("sinew").expect("the command is built");
    command.args(["run", &format!("problems/{problem}"), "--quiet", "--set", "output.frames=0"]);
    command.arg("--out").arg(out.path());
    set.iter().for_each(|pair| {
        command.args(["--set", pair]);
    });
    command.assert().success();
    let text = std::fs::read_to_string(out.path().join("summary.json")).expect("a summary");
    serde_json::from_str(&text).expect("valid JSON")
}

fn number(summary: &serde_json::Value, path: &str) -> f64 {
    let step = |value: &serde_json::Value, key: &str| match key.parse::<usize>() {
        Ok(index) => value.get(index).cloned(),
        Err(_) => value.get(key).cloned(),
    };
    // names of reactions have dots: with slashes between keys, dots are part of them
    let between = if path.contains('/') { '/' } else { '.' };
    let found = path.split(between).try_fold(summary.clone(), |value, key| step(&value, key));
    found.and_then(|value| value.as_f64()).unwrap_or_else(|| panic!("no number {path} in the summary"))
}

fn meets_expectations(problem: &str) {
    let file = Path::new("problems").join(problem).join("expect.toml");
    let text = std::fs::read_to_string(&file).expect("an expect.toml");
    let expectations: Expectations = toml::from_str(&text).expect("a valid expect.toml");
    let mut runs = BTreeMap::new();
    let mut missed = Vec::new();
    for m in &expectations.metric {
        let summary = runs.entry(m.set.clone()).or_insert_with(|| summary(problem, &m.set));
        let value = number(summary, &m.path);
        println!(
            "{problem}: {} = {value:.6} (reference {} ± {}, {})",
            m.name, m.reference, m.tolerance, m.source
        );
        if (value - m.reference).abs() > m.tolerance || value.is_nan() {
            missed.push(format!("{}: {value} instead of {} ± {}", m.name, m.reference, m.tolerance));
        }
    }
    assert!(missed.is_empty(), "{problem}: {missed:#?}");
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
