//! `sinew compare`: what differs is found and named, and what may differ does not count.

use crate::common::command::{sinew, text, words};
use sinew::output::compare::{Column, Particles, Tolerances, compare, component_name, history};
use std::path::Path;

fn particles(identities: &[u64], stress: impl Fn(u64) -> [f64; 6]) -> Particles {
    let values = identities.iter().flat_map(|&id| stress(id)).collect();
    Particles {
        identities: identities.to_vec(),
        materials: identities.iter().map(|id| (id % 2) as usize).collect(),
        positions: identities.iter().map(|&id| [id as f64, 0.0, 0.0]).collect(),
        columns: vec![Column { label: "stress".into(), components: 6, values }],
    }
}

fn tolerances(texts: &[&str]) -> Tolerances {
    let texts: Vec<String> = texts.iter().map(|&text| text.into()).collect();
    Tolerances::parse(&texts).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn particles_are_paired_by_identity_whatever_their_order() {
    let stress = |id: u64| [id as f64; 6];
    let found = compare(&particles(&[3, 1, 2], stress), &particles(&[1, 2, 3], stress), &tolerances(&[]));
    assert!(found.same(), "{found:?}");
    let found =
        compare(&particles(&[3, 1, 5], stress), &particles(&[1, 2, 3, 4], stress), &tolerances(&["1"]));
    assert_eq!(found.only, [vec![5], vec![2, 4]]);
    assert!(!found.same());
}

#[test]
fn a_turned_stress_differs_although_its_norm_is_the_same() {
    let (x, y) = ([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let found = compare(&particles(&[1, 2], |_| x), &particles(&[1, 2], |_| y), &tolerances(&["0.5"]));
    let first = found.first.clone().unwrap_or_else(|| panic!("a difference"));
    assert_eq!((first.identity, component_name(&first.label, first.component).as_str()), (1, "stress.xx"));
    assert_eq!(first.values, [1.0, 0.0]);
    let most: Vec<f64> = found.norms.iter().map(|norms| norms.most).collect();
    assert_eq!(most, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
}

#[test]
fn norms_are_those_of_the_differences() {
    let one = particles(&[1, 2, 3, 4], |_| [10.0; 6]);
    let other = particles(&[1, 2, 3, 4], |id| [if id == 3 { 12.0 } else { 10.0 }; 6]);
    let found = compare(&one, &other, &tolerances(&["stress=2"]));
    assert!(found.same());
    assert_eq!((found.norms[0].most, found.norms[0].rms), (2.0, 1.0));
    let found = compare(&one, &other, &tolerances(&["0.1"]));
    assert_eq!(found.norms[0].allowed, Some(1.0));
    assert_eq!(found.norms[0].differing, 1);
    assert_eq!(found.first.map(|first| first.identity), Some(3));
}

#[test]
fn every_bit_counts_unless_a_tolerance_says_otherwise() {
    let with = |value: f64| particles(&[1], |_| [value; 6]);
    for (a, b) in [(0.0, -0.0), (1.0, 1.0 + f64::EPSILON), (1.0, f64::NAN)] {
        assert!(!compare(&with(a), &with(b), &tolerances(&[])).same(), "{a} {b}");
        assert!(!compare(&with(a), &with(b), &tolerances(&["other=1"])).same(), "{a} {b}");
    }
    assert!(compare(&with(0.0), &with(-0.0), &tolerances(&["1e-9"])).same());
    assert!(compare(&with(f64::NAN), &with(f64::NAN), &tolerances(&[])).same());
    assert!(!compare(&with(1.0), &with(f64::NAN), &tolerances(&["1e9"])).same(), "a number and none");
}

#[test]
fn the_first_cell_of_a_history_that_differs_is_named() {
    let one = "time_s,step,energy_j\n0,0,1\n1e-3,10,0.5\n";
    let found = history::compare(one, one, &tolerances(&[]));
    assert_eq!((found.rows, found.first), (2, None));
    let other = one.replace("0.5", "0.6");
    let first =
        history::compare(one, &other, &tolerances(&[])).first.unwrap_or_else(|| panic!("a difference"));
    assert_eq!((first.row, first.step.as_str(), first.column.as_str()), (2, "10", "energy_j"));
    assert_eq!(first.values, ["0.5", "0.6"]);
    assert_eq!(history::compare(one, &other, &tolerances(&["0.2"])).first, None);
    assert_eq!(history::compare(one, &other, &tolerances(&["energy_j=0.11"])).first, None);
    assert_eq!(history::compare(one, &other, &tolerances(&["history=0.11"])).first, None);
    let first = history::compare(one, "time_s,step,energy_j\n0,0,1\n", &tolerances(&["1"])).first;
    assert_eq!(first.map(|cell| (cell.row, cell.column)), Some((2, String::new())));
}

/// Compares, and looks at status and words.
#[track_caller]
fn says(sides: [&Path; 2], more: &[&str], status: i32, facts: &[&str]) {
    let output = sinew(&[&["compare", text(sides[0]), text(sides[1])], more].concat());
    let said = words(&output);
    assert_eq!(output.status.code(), Some(status), "{said}");
    assert!(facts.iter().all(|fact| said.contains(fact)), "{facts:?} in: {said}");
}

#[test]
fn the_command_compares_runs_and_files() {
    let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
    let run = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        let begin = ["run", "problems/two-spheres", "-q", "--steps", "12", "--out", text(&out)];
        let every =
            ["--set", "output.checkpoint.steps=4", "--set", "output.frames=200", "--set", "domain.cell=4 mm"];
        let output = sinew(&[&begin[..], &every, more].concat());
        assert!(output.status.success(), "{}", words(&output));
        out
    };
    let one = run("one", &[]);
    let same = run("same", &["--patches", "2x1x1", "--threads", "2"]);
    let other = run("other", &["--set", "body.left ball.velocity.1=0.001 mm/s"]);
    says([&one, &same], &[], 0, &["frames", "checkpoints", "history", "the same, bit for bit"]);
    let facts = [
        "differs first in row 0",
        "differ first in frame 0 (step 0",
        "first particle 0 of left",
        "velocity.y",
    ];
    says([&one, &other], &[], 1, &facts[1..]);
    says([&one, &other], &["--tolerance", "velocity=1e-9"], 1, &["velocity.y is 0e0 and"]);
    let loose = [
        "velocity=1e-2",
        "position=1e-6",
        "displacement=1e-6",
        "pressure=10",
        "von_mises=10",
        "volume_ratio=1e-3",
        "history=inf",
    ];
    let loose: Vec<&str> = loose.iter().flat_map(|text| ["--tolerance", text]).collect();
    let only_frames = [&one.join("particles.vtkhdf"), &other.join("particles.vtkhdf")];
    says(
        only_frames.map(|p| p.as_path()),
        &loose[..10],
        0,
        &["the same within the tolerances", "velocity.y"],
    );
    says([&one, &other], &[&loose[..], &["--tolerance", "velocty=1"]].concat(), 2, &["velocty", "velocity"]);
    let [a, b] = [&one, &same].map(|folder| folder.join("checkpoint-00000012.h5"));
    says([&a, &b], &[], 0, &["of step 12 and 12", "bit for bit"]);
    says(
        [&a, &one.join("checkpoint-00000008.h5")],
        &[],
        1,
        &["of step 12 and 8 differ in left", "Position.x"],
    );
    says([&one, &folder.path().join("none")], &[], 2, &["does not exist"]);
    says([&a, &one.join("history.csv")], &[], 2, &["nothing that both have"]);
    says([&one, &same], &["--tolerance", "much"], 2, &["write a number"]);
    std::fs::write(&a, b"nothing").unwrap_or_else(|error| panic!("{error}"));
    says([&one, &same], &[], 2, &["checkpoint-00000012.h5", "cut off"]);
}
