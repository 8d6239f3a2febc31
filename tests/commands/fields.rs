//! What frames show: each field against a closed form; what a scene may ask for; the same state whatever is shown.

use crate::common::command::{ok, sinew, text, words};
use crate::common::rubber::{RUBBER, pulled, stress_of};
use crate::common::{Overrides, finish, scene, start};
use sinew::input::read_text;
use sinew::output::frame::{Columns, Piece};
use sinew::output::vtkhdf::Reader;
use sinew::simulation::Simulation;
use std::path::Path;

const TISSUE: Overrides<'_> = &[
    ("material.rubber.law", "tissue"),
    ("material.rubber.shear-modulus", ""),
    ("material.rubber.c1", "2 kPa"),
    ("material.rubber.c3", "1 kPa"),
    ("material.rubber.c4", "10"),
    ("material.rubber.c5", "10 kPa"),
    ("material.rubber.lambda-star", "1.4"),
    ("body.block.fibers", "{ uniform = [0.6, 0.8, 0] }"),
];

/// All particles of a simulation, as a frame shows them.
fn shown(simulation: &Simulation) -> (Columns, Piece) {
    let snapshot = simulation.snapshot();
    let mut all = vec![];
    snapshot.pieces(0, |piece| all.push(piece));
    assert_eq!(all.len(), 1, "few particles");
    (snapshot.columns(), all.remove(0))
}

/// The numbers of a field, particle by particle.
#[track_caller]
fn field<'a>((columns, piece): &'a (Columns, Piece), name: &str) -> Vec<&'a [f32]> {
    let number = columns.fields.iter().position(|field| field.name == name).expect("it is shown");
    piece.columns[number].chunks(columns.fields[number].components).collect()
}

/// Whether every particle shows these numbers, to single precision of the largest.
#[track_caller]
fn all_are(frame: &(Columns, Piece), name: &str, expected: &[f64]) {
    let largest = expected.iter().fold(0.0, |most: f64, x| most.max(x.abs())).max(f64::MIN_POSITIVE);
    for numbers in field(frame, name) {
        assert_eq!(numbers.len(), expected.len(), "{name}");
        let far = numbers.iter().zip(expected).map(|(x, y)| (f64::from(*x) - y).abs()).fold(0.0, f64::max);
        assert!(far <= 2e-6 * largest, "{name}: {numbers:?} for {expected:?}");
    }
}

#[test]
fn a_stretched_block_shows_its_closed_form() {
    let fields = "[\"stress\", \"kirchhoff_stress\", \"pressure\", \"von_mises\", \"deformation_gradient\", \"strain\", \
                  \"shear_strain\", \"volume_ratio\", \"mass\", \"volume\", \"radius\"]";
    let mut simulation = start(scene(RUBBER, &[&pulled()[..], &[("output.fields", fields)]].concat()));
    finish(&mut simulation).expect("runs");
    let frame = shown(&simulation);
    let l = 1.2;
    let [along, across] = stress_of(l);
    let stress = [along, across, across, 0.0, 0.0, 0.0];
    all_are(&frame, "stress", &stress);
    all_are(&frame, "kirchhoff_stress", &stress.map(|s| l * s));
    all_are(&frame, "pressure", &[-(along + 2.0 * across) / 3.0]);
    all_are(&frame, "von_mises", &[along - across]);
    all_are(&frame, "deformation_gradient", &[l, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    all_are(&frame, "strain", &[0.22, 0.0, 0.0, 0.0, 0.0, 0.0]);
    all_are(&frame, "shear_strain", &[0.11]);
    all_are(&frame, "volume_ratio", &[l]);
    let volume = 1e-9 / 8.0;
    all_are(&frame, "volume", &[volume]);
    all_are(&frame, "mass", &[1e3 * volume / l]);
    all_are(&frame, "radius", &[(volume * 0.75 / std::f64::consts::PI).cbrt()]);
}

#[test]
fn what_moves_as_one_is_displaced_by_its_way() {
    let moving = [
        ("domain.upper", "[\"30 mm\", \"12 mm\", \"4 mm\"]"),
        ("body.block.velocity", "[20, 10, 0]"),
        ("run.until", "0.4 ms"),
        ("output.fields", "[\"displacement\", \"reference_position\", \"velocity\"]"),
    ];
    let rigid = [
        ("material.rubber.law", "rigid"),
        ("material.rubber.bulk-modulus", ""),
        ("material.rubber.shear-modulus", ""),
        ("material.rubber.motion", "free"),
    ];
    for law in [&[][..], &rigid] {
        let mut simulation = start(scene(RUBBER, &[&moving[..], law].concat()));
        let before = shown(&simulation);
        // a rigid body's particles are where its center and its turn say, to rounding
        let still = field(&before, "displacement").concat();
        assert!(still.iter().all(|x| x.abs() < 1e-17), "{still:?}");
        assert_eq!(field(&before, "reference_position").concat(), before.1.positions.concat());
        finish(&mut simulation).expect("runs");
        let after = shown(&simulation);
        all_are(&after, "displacement", &[8e-3, 4e-3, 0.0]);
        let start = field(&after, "reference_position");
        for (i, id) in after.1.identities.iter().enumerate() {
            let row = before.1.identities.iter().position(|other| other == id).expect("it was there");
            assert_eq!(start[i], before.1.positions[row], "particle {id}");
        }
    }
}

#[test]
fn fibers_turn_and_stretch_with_the_matter() {
    let fields = "[\"fiber_direction\", \"fiber_stretch\", \"fiber_y\", \"failure\"]";
    let simulation = start(scene(RUBBER, &[&pulled()[..], TISSUE, &[("output.fields", fields)]].concat()));
    let frame = shown(&simulation);
    // F a₀ = (1.2 · 0.6, 0.8, 0)
    let stretch = 0.72f64.hypot(0.8);
    all_are(&frame, "fiber_direction", &[0.72 / stretch, 0.8 / stretch, 0.0]);
    all_are(&frame, "fiber_stretch", &[stretch]);
    all_are(&frame, "fiber_y", &[0.8]);
    all_are(&frame, "failure", &[0.0]);
    let failure = frame.0.fields.iter().find(|field| field.name == "failure").expect("it is shown");
    assert_eq!(failure.codes[..2], ["intact", "matrix failed"]);
    assert_eq!(frame.0.materials, ["rubber"]);
}

#[test]
fn what_a_scene_does_not_say_is_what_is_usual() {
    let names = |overrides: Overrides<'_>| -> Vec<&str> {
        scene(RUBBER, overrides).output.fields.iter().map(|shown| shown.name).collect()
    };
    let usual = ["displacement", "velocity", "volume_ratio", "pressure", "von_mises"];
    assert_eq!(names(&[]), usual);
    assert_eq!(names(TISSUE), [&usual[..], &["failure"]].concat());
    let metal: Overrides<'_> = &[("material.rubber.law", "j2"), ("material.rubber.yield-stress", "1 GPa")];
    assert_eq!(names(metal), [&usual[..], &["plastic_strain"]].concat());
    assert_eq!(names(&[("output.fields", "[]")]), [""; 0]);
    assert_eq!(names(&[("output.fields", "[\"mass\", \"velocity\"]")]), ["mass", "velocity"]);
}

#[test]
fn what_nobody_has_is_refused_with_what_there_is() {
    for (fields, expected) in [
        ("[\"stres\"]", "did you mean `stress`"),
        ("[\"fiber_direction\"]", "something of the law \"tissue\""),
        ("[\"mass\", \"mass\"]", "is there twice"),
        ("[\"id\"]", "is in every frame"),
        ("\"stress\"", "must be an array"),
        ("[\"one\", \"two\"]", "no material of this scene has \"two\""),
    ] {
        let overrides = [("output.fields".to_owned(), fields.to_owned())];
        let error = read_text("test", RUBBER, &overrides, None).expect_err(fields);
        let words = format!("{:?}", miette::Report::new(error)).replace('│', " ");
        let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains(expected), "{fields}: {words}");
    }
}

/// What is known from the start is in no checkpoint, and there again after a restart; frames may come and go, their fields stay.
#[test]
fn a_restart_shows_what_the_run_has_shown() {
    let folder = ok(tempfile::tempdir());
    let file = folder.path().join("scene.toml");
    ok(std::fs::write(&file, RUBBER));
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    let run = |out: &Path, steps: &str, more: &[&str]| {
        let moving =
            ["--set", "body.block.velocity=[1, 0, 0]", "--set", "run.leaving=delete", "-q", "--steps", steps];
        let output = sinew(&[&["run", text(&file), "--out", text(out)], &moving[..], more].concat());
        assert!(output.status.success(), "{}", words(&output));
    };
    run(&whole, "9", &[]);
    run(&parts, "4", &["--set", "output.frames=0"]);
    let again =
        |more: &[&str]| sinew(&[&["run", "--restart", text(&parts), "-q", "--steps", "9"], more].concat());
    let other = again(&["--set", "output.fields=[\"mass\"]"]);
    assert!(other.status.code() == Some(2) && words(&other).contains("output.fields"), "{}", words(&other));
    let ended = again(&["--set", "output.frames=1"]);
    assert!(ended.status.success(), "{}", words(&ended));
    let last = |out: &Path| {
        let reader = ok(Reader::open(&out.join("particles.vtkhdf")));
        let frame = ok(reader.frame(reader.frames() - 1));
        let way = frame
            .columns
            .iter()
            .find(|(field, _)| field.name == "displacement")
            .expect("it is shown")
            .1
            .clone();
        let mut rows: Vec<_> = frame.identities.into_iter().zip(way.as_chunks::<3>().0.to_vec()).collect();
        rows.sort_by_key(|(id, _)| *id);
        rows
    };
    let way = last(&whole);
    assert_eq!(way, last(&parts));
    assert!(way.iter().all(|(_, way)| way[0] > 0.0));
}

#[test]
fn the_state_is_the_same_whatever_is_shown() {
    let hash = |overrides: Overrides<'_>| {
        let mut simulation = start(scene(
            RUBBER,
            &[&pulled()[..], overrides, &[("body.block.velocity", "[1, 0, 0]")]].concat(),
        ));
        finish(&mut simulation).expect("runs");
        let bytes = simulation.bytes().0;
        (simulation.state_hash(), bytes)
    };
    let (without, few) = hash(&[("output.fields", "[\"velocity\"]")]);
    let (with, more) = hash(&[]);
    assert_eq!(without, with);
    // where nobody looks, nothing is kept
    assert!(few < more, "{few} B, {more} B");
    assert_eq!(hash(&[("output.frames", "0")]), (without, few));
}
