//! Frames that ranks write beside the steps, each its own rows.
use crate::ranks::together;
use crate::*;
use sinew::output::vtkhdf;
use std::collections::BTreeSet;
use std::time::Duration;

/// Frames after each step, a checkpoint after every fifth.
const EVERY: Overrides<'static> = &[
    ("output.checkpoint.steps", "5"),
    ("output.frames", "1"),
    ("output.period", "[{ frames-every = 1e-12, to = 1 }]"),
    ("run.steps", "40"),
];

fn cloud() -> Scene {
    laid_out(scene(CLOUD, EVERY), ([3, 2, 2], 1))
}

/// What became of a run on a rank, up to the first file that cannot be written.
fn record(network: Box<dyn Network>, out: &Path, stop: Option<u64>, obstacle: &Path) -> Option<String> {
    let again = !checkpoint::list(out).is_empty();
    let mut network = network;
    let (mut simulation, mut recorder) = if again {
        let (reader, found) = ok(last_checkpoint(&mut *network, out));
        let mut simulation = ok(Simulation::restore(network, cloud(), Isa::detect(), &reader));
        let (recorder, warnings) = ok(Recorder::resume(out, &mut simulation, &reader.head, &found));
        assert_eq!(warnings, Vec::<String>::new());
        (simulation, recorder)
    } else {
        let mut simulation = ok(Simulation::on(network, cloud(), Isa::detect()));
        let recorder = ok(Recorder::create(out, &mut simulation));
        (simulation, recorder)
    };
    let hindered = obstacle.parent().is_some();
    if simulation.network().rank() == 0 && hindered {
        ok(std::fs::create_dir(obstacle));
    }
    while ok(simulation.step()) {
        if hindered && simulation.steps() == 8 {
            // so that a state is kept, as now and then, while the frame that fails is on its way
            std::thread::sleep(Duration::from_millis(300));
        }
        let stops = stop == Some(simulation.steps());
        match recorder.step(&mut simulation, stops) {
            Ok(Next::Go) => {}
            Ok(Next::Stop) => {
                ok(recorder.finish(&mut simulation, End::Interrupted));
                return None;
            }
            Err(error) => {
                ok(recorder.finish(&mut simulation, End::Failed(error.to_string())));
                return Some(error.to_string());
            }
        }
    }
    ok(recorder.finish(&mut simulation, End::Completed));
    None
}

fn on(ranks: usize, out: &Path, stop: Option<u64>) {
    let ends = together(ranks, |network| record(network, out, stop, Path::new("")));
    assert_eq!(ends, vec![None; ranks]);
}

/// Names of the files of frames.
fn files(out: &Path) -> BTreeSet<String> {
    let entries = ok(std::fs::read_dir(out.join("particles")));
    entries.map(|entry| ok(entry).file_name().to_string_lossy().into_owned()).collect()
}

#[track_caller]
fn same_particles(one: &Path, other: &Path) {
    let output = sinew(&["compare", text(one), text(other)]);
    assert!(output.status.success(), "{}", words(&output));
    let times = |out: &Path| ok(vtkhdf::Reader::open(&out.join(vtkhdf::INDEX))).times().to_vec();
    assert_eq!(times(one), times(other));
}

#[test]
fn each_rank_writes_its_own_rows_and_a_restart_on_others_goes_on() {
    let folder = folder();
    let [one, several] = ["one", "several"].map(|name| folder.path().join(name));
    on(1, &one, None);
    on(3, &several, Some(11));
    on(2, &several, Some(23));
    on(1, &several, None);
    same_particles(&one, &several);
    let name = |number: u64, parts: usize| vtkhdf::FileId::of_frame(number, parts).map(vtkhdf::FileId::name);
    let wanted = |number: u64| match number {
        0..=11 => name(number, 3),
        12..=23 => name(number, 2),
        _ => name(number, 1),
    };
    let cells = ["cells.h5".to_owned()];
    let all: BTreeSet<String> = (0..=40).flat_map(wanted).chain(cells).collect();
    assert_eq!(files(&several), all);
    let rows = |file: String| -> u64 {
        let file = ok(unlocked().open(several.join("particles").join(file)));
        ok(ok(file.attr("particles")).read_scalar())
    };
    let particles = ok(Summary::read(&one.join("summary.json"))).particles;
    let parts: Vec<u64> = name(5, 3).map(rows).collect();
    assert!(parts.iter().sum::<u64>() == particles && parts.iter().all(|&rows| rows > 0), "{parts:?}");
}

/// What one rank cannot write ends the run on all of them, and leaves all frames before.
#[test]
fn a_part_that_cannot_be_written_is_told_by_all_ranks() {
    let folder = folder();
    let [one, several] = ["one", "several"].map(|name| folder.path().join(name));
    on(1, &one, None);
    let obstacle = several.join("particles/000008-2of3.h5.part");
    let ends = together(3, |network| record(network, &several, None, &obstacle));
    let said: Vec<String> = ends.into_iter().flatten().collect();
    assert_eq!(said.len(), 3, "{said:?}");
    assert!(said[1].starts_with("cannot") && said[1].contains(text(&obstacle)), "{said:?}");
    let others = format!("rank 1: {}", said[1]);
    assert!(said[0] == others && said[2] == others, "{said:?}");
    assert!(ok(std::fs::read_to_string(several.join("summary.json"))).contains("\"failed\""));
    // of the frame nothing is left, and after it comes what a run leaves that fails
    let left: Vec<String> = files(&several).into_iter().filter(|file| file.starts_with("000008")).collect();
    assert_eq!(left, ["000008-2of3.h5.part"]);
    let reader = ok(vtkhdf::Reader::open(&several.join(vtkhdf::INDEX)));
    assert_eq!(reader.frames(), 9);
    assert!((0..9).all(|k| ok(reader.frame(k)).identities.len() == reader.particles(k)));
    ok(std::fs::remove_dir(&obstacle));
    on(2, &several, None);
    same_particles(&one, &several);
}
