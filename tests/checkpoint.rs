//! Runs that are stopped and go on: the same bits as if nothing had happened, and no damaged checkpoint is ever used.
mod common;

use common::command::{ok, sinew, text, words};
use common::{Overrides, Random, finish, scene, soft_shot};
use engine::exec::ranks::local::Local;
use engine::exec::ranks::{Alone, Network};
use scene::Scene;
use simd::Isa;
use sinew::output::checkpoint::{self, Reader, Recorded, last_whole};
use sinew::output::summary::Summary;
use sinew::simulation::recorder::{End, Next, Recorder, last_checkpoint};
use sinew::simulation::{Report, RunError, Simulation};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

type Layout = ([usize; 3], usize);

fn laid_out(mut scene: Scene, (patches, threads): Layout) -> Scene {
    (scene.run.patches, scene.run.threads) = (Some(patches), Some(threads));
    scene
}

fn folder() -> tempfile::TempDir {
    ok(tempfile::tempdir())
}

/// Takes `steps` steps and writes a checkpoint.
fn stopped(scene: Scene, layout: Layout, steps: u64, folder: &Path) -> PathBuf {
    let mut simulation = ok(Simulation::new(laid_out(scene, layout), Isa::detect()));
    while simulation.steps() < steps {
        assert!(ok(simulation.step()), "the run ends before step {steps}");
    }
    ok(simulation.write_checkpoint(folder, Recorded::default()));
    checkpoint::path(folder, steps)
}

fn restored(scene: Scene, layout: Layout, path: &Path) -> Simulation {
    let reader = ok(Reader::open(path));
    ok(Simulation::restore(Box::new(Alone), laid_out(scene, layout), Isa::detect(), &reader))
}

/// What a run is compared by: the hash, and every number of the accounts with every bit.
fn end(simulation: &mut Simulation) -> (u64, String, u64, u64) {
    let report: Report = ok(finish(simulation));
    // as text, every number has its shortest exact form, and -0 is not 0
    (simulation.state_hash(), format!("{report:?}"), simulation.updates(), simulation.ticks())
}

const LAYOUTS: [Layout; 4] = [([1, 1, 1], 1), ([2, 1, 2], 2), ([3, 2, 1], 1), ([5, 5, 4], 2)];

/// A run that stops at random steps goes on on other patches and threads as if it had not stopped.
#[track_caller]
fn goes_on(scene: &Scene, random: &mut Random) {
    let steps = scene.run.steps.unwrap_or(100);
    let mut whole = ok(Simulation::new(laid_out(scene.clone(), LAYOUTS[1]), Isa::detect()));
    let wanted = end(&mut whole);
    for round in 0..3 {
        let at = 1 + ((steps - 1) as f64 * random.unit()) as u64;
        let folder = folder();
        let path = stopped(scene.clone(), LAYOUTS[round], at, folder.path());
        let mut simulation = restored(scene.clone(), LAYOUTS[round + 1], &path);
        assert_eq!(simulation.steps(), at);
        assert_eq!(end(&mut simulation), wanted, "from step {at} on, {:?}", LAYOUTS[round + 1]);
    }
}

fn shot(overrides: Overrides<'_>) -> Scene {
    soft_shot("40", overrides)
}

#[test]
fn a_shot_goes_on_with_the_same_bits() {
    goes_on(&shot(&[]), &mut Random(2));
}

#[test]
fn so_does_one_with_rates_of_their_own() {
    let hard = [("material.lead.bulk-modulus", "46 GPa"), ("material.lead.shear-modulus", "5.6 GPa")];
    goes_on(&shot(&[&[("run.rates", "per-material")][..], &hard].concat()), &mut Random(3));
}

/// Two bodies that fly apart so fast that particles leave the domain, and a free rigid one.
const CLOUD: &str = include_str!("scenes/cloud.toml");

#[test]
fn rigid_bodies_and_particles_that_left_are_remembered() {
    for rates in ["common", "per-material"] {
        let scene = scene(CLOUD, &[("run.rates", rates)]);
        let mut whole = ok(Simulation::new(scene.clone(), Isa::detect()));
        assert!(ok(finish(&mut whole)).deleted > 10, "particles must leave to test that they are counted");
        goes_on(&scene, &mut Random(4));
    }
    let scene = scene(CLOUD, &[("run.leaving", "reflect")]);
    let mut whole = ok(Simulation::new(scene.clone(), Isa::detect()));
    assert!(ok(finish(&mut whole)).reflected > 10, "particles must come back to test that they are counted");
    goes_on(&scene, &mut Random(5));
}

#[test]
fn a_restart_may_go_further_than_the_run_that_was_stopped() {
    let folder = folder();
    let (short, long) = (shot(&[("run.steps", "20")]), shot(&[("run.steps", "30")]));
    let path = stopped(short, LAYOUTS[0], 20, folder.path());
    let wanted = end(&mut ok(Simulation::new(long.clone(), Isa::detect())));
    assert_eq!(end(&mut restored(long, LAYOUTS[1], &path)), wanted);
}

#[test]
fn a_file_that_is_cut_or_has_a_flipped_bit_anywhere_is_refused_by_name() {
    let folder = folder();
    let path = stopped(shot(&[]), LAYOUTS[1], 2, folder.path());
    let bytes = ok(std::fs::read(&path));
    let mut random = Random(5);
    let mut any = |end: usize| (random.unit() * end as f64) as usize;
    let refused = |bytes: &[u8], what: &str| {
        ok(std::fs::write(&path, bytes));
        let error = Reader::open(&path).map(|_| ()).expect_err(what).to_string();
        let reason = error.contains("cut off") || error.contains("damaged");
        assert!(reason && error.contains("checkpoint-00000002.h5"), "{what}: {error}");
    };
    let ends = [0, 1, 31, 32, 33, bytes.len() - 33, bytes.len() - 32, bytes.len() - 31, bytes.len() - 1];
    for length in ends.into_iter().chain((0..12).map(|_| any(bytes.len())).collect::<Vec<_>>()) {
        refused(&bytes[..length], &format!("cut to {length}"));
    }
    // everywhere, and often where HDF5 and the seal keep what they know
    for round in 0..200 {
        let mut flipped = bytes.clone();
        let at = match round % 4 {
            0 => any(4096),
            1 => bytes.len() - 1 - any(64),
            _ => any(bytes.len()),
        };
        flipped[at] ^= 1 << (round % 8);
        refused(&flipped, &format!("bit {} of byte {at}", round % 8));
    }
    refused(&[&bytes[..], b"more"].concat(), "longer");
    ok(std::fs::write(&path, &bytes));
    ok(Reader::open(&path));
}

#[test]
fn the_last_whole_checkpoint_is_the_one_that_is_used() {
    let folder = folder();
    let mut simulation = ok(Simulation::new(shot(&[]), Isa::detect()));
    for _ in 0..3 {
        ok(simulation.step());
        ok(simulation.write_checkpoint(folder.path(), Recorded::default()));
    }
    let [one, two, three] = [1, 2, 3].map(|steps| checkpoint::path(folder.path(), steps));
    assert_eq!(checkpoint::list(folder.path()), [three.clone(), two.clone(), one.clone()]);
    let bytes = ok(std::fs::read(&three));
    ok(std::fs::write(&three, &bytes[..bytes.len() / 2]));
    let found = ok(last_whole(folder.path()));
    assert_eq!((found.path, found.damaged), (two.clone(), vec![three.clone()]));
    assert!(found.warnings[0].contains("checkpoint-00000003.h5"), "{:?}", found.warnings);
    for file in [&one, &two] {
        ok(std::fs::write(file, b"nothing"));
    }
    let error = last_whole(folder.path()).expect_err("none is whole").to_string();
    assert!(["00000001", "00000002", "00000003"].iter().all(|name| error.contains(name)), "{error}");
    ok(checkpoint::prune(folder.path(), 2));
    assert_eq!(checkpoint::list(folder.path()), [three, two]);
}

/// Runs `work` on each of `size` ranks.
fn together<T: Send>(size: usize, work: impl Fn(Box<dyn Network>) -> T + Sync) -> Vec<T> {
    std::thread::scope(|scope| {
        let crew = Local::crew(size).into_iter();
        let ranks: Vec<_> = crew.map(|rank| scope.spawn(|| work(Box::new(rank)))).collect();
        ranks.into_iter().map(|rank| rank.join().expect("a rank ends")).collect()
    })
}

#[test]
fn any_number_of_ranks_takes_over_the_state_and_writes_it_again() {
    let (folder, scene) = (folder(), laid_out(scene(CLOUD, &[]), ([3, 2, 2], 1)));
    let path = stopped(scene.clone(), LAYOUTS[3], 40, folder.path());
    let hash = restored(scene.clone(), LAYOUTS[0], &path).state_hash();
    let records = |path: &Path| {
        let reader = ok(Reader::open(path));
        let mut records = Vec::new();
        for (m, material) in reader.head.materials.iter().enumerate() {
            let columns = ok(reader.columns(m, &(0..material.rows)));
            let mut row = 0;
            for block in ok(reader.blocks(m)) {
                let rows = row..row + block.count as usize;
                row = rows.end;
                let columns = columns.iter().zip(&material.labels);
                let bits = columns
                    .map(|(c, (_, w))| c[rows.start * w..rows.end * w].iter().map(|x| x.to_bits()).collect());
                records.push((
                    m,
                    block.index,
                    block.extent.map(f64::to_bits),
                    bits.collect::<Vec<Vec<u64>>>(),
                ));
            }
        }
        records.sort();
        (reader.head.shared, reader.head.ledger.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), records)
    };
    for ranks in [1, 2, 3, 5] {
        let out = self::folder();
        let hashes = together(ranks, |mut network| {
            let (reader, _) = ok(last_checkpoint(&mut *network, folder.path()));
            let mut simulation = ok(Simulation::restore(network, scene.clone(), Isa::detect(), &reader));
            ok(simulation.write_checkpoint(out.path(), reader.head.recorded));
            (simulation.state_hash(), simulation.steps())
        });
        assert_eq!(hashes, vec![(hash, 40); ranks]);
        assert_eq!(records(&checkpoint::path(out.path(), 40)), records(&path), "{ranks} ranks");
    }
}

#[test]
fn frames_and_checkpoints_of_several_ranks_hold_every_particle_once() {
    let (folder, scene) = (folder(), laid_out(scene(CLOUD, &[]), ([3, 2, 2], 1)));
    let path = stopped(scene.clone(), LAYOUTS[0], 40, folder.path());
    let frames = [1, 3].map(|ranks| {
        let out = self::folder();
        let summaries = together(ranks, |mut network| {
            let (reader, _) = ok(last_checkpoint(&mut *network, folder.path()));
            let mut simulation = ok(Simulation::restore(network, scene.clone(), Isa::detect(), &reader));
            let recorder = ok(Recorder::create(out.path(), &mut simulation));
            ok(recorder.finish(&mut simulation, End::Completed))
        });
        let read = ok(Summary::read(&out.path().join("summary.json")));
        assert!(summaries.iter().all(|summary| summary.state_hash == read.state_hash));
        assert_eq!(read.ranks, ranks);
        let reader = ok(sinew::output::vtkhdf::Reader::open(&out.path().join("particles.vtkhdf")));
        let frame = ok(reader.frame(0));
        assert_eq!(read.particles, frame.identities.len() as u64);
        let mut rows: Vec<_> = (0..frame.identities.len())
            .map(|i| {
                let numbers = frame.columns.iter().flat_map(|(field, values)| {
                    values[i * field.components..][..field.components].iter().map(|x| x.to_bits())
                });
                let place = frame.positions[i].map(f32::to_bits);
                (frame.identities[i], frame.materials[i], place, numbers.collect::<Vec<u32>>())
            })
            .collect();
        rows.sort();
        (read.state_hash, read.more["updates"].clone(), rows)
    });
    assert_eq!(frames[0], frames[1]);
    assert!(path.exists());
}

#[test]
fn rank_0_that_cannot_write_stops_all_ranks() {
    let (folder, scene) = (folder(), laid_out(scene(CLOUD, &[]), ([3, 2, 2], 1)));
    let path = stopped(scene.clone(), LAYOUTS[0], 1, folder.path());
    let nowhere = folder.path().join("no/such/folder");
    let errors = together(3, |network| {
        let reader = ok(Reader::open_verified(&path));
        let mut simulation = ok(Simulation::restore(network, scene.clone(), Isa::detect(), &reader));
        simulation.write_checkpoint(&nowhere, Recorded::default()).expect_err("nowhere to write").to_string()
    });
    assert!(errors[0].starts_with("cannot create") && errors[0].contains("no/such/folder"), "{errors:?}");
    assert!(errors[1..].iter().all(|error| error.starts_with("rank 0: cannot create")), "{errors:?}");
    let errors = together(3, |network| {
        let reader = ok(Reader::open_verified(&path));
        let mut simulation = ok(Simulation::restore(network, scene.clone(), Isa::detect(), &reader));
        let created = Recorder::create(&path.join("below a file"), &mut simulation);
        created.map(|_| ()).expect_err("nowhere to write").to_string()
    });
    assert!(errors.iter().all(|error| error.contains("below a file")), "{errors:?}");
}

#[test]
fn a_checkpoint_of_other_materials_is_refused() {
    let folder = folder();
    let path = stopped(shot(&[]), LAYOUTS[0], 1, folder.path());
    let reader = ok(Reader::open(&path));
    let other = scene(CLOUD, &[]);
    let error = Simulation::restore(Box::new(Alone), other, Isa::detect(), &reader).map(|_| ());
    assert!(matches!(error, Err(RunError::Checkpoint(_))), "{:?}", error.err().map(|e| e.to_string()));
}

/// A run of the two spheres with a checkpoint after every step.
fn run(out: &Path, steps: &str, more: &[&str]) -> Output {
    let every =
        ["--set", "output.checkpoint.steps=1", "--set", "output.frames=200", "--set", "domain.cell=4 mm"];
    let begin = ["run", "problems/two-spheres", "-q", "--steps", steps, "--out", text(out)];
    sinew(&[&begin[..], &every, more].concat())
}

/// The summary without what a clock says.
fn timeless(folder: &Path) -> Summary {
    let mut summary = ok(Summary::read(&folder.join("summary.json")));
    (summary.wall_s, summary.updates_per_s, summary.updates_per_s_per_core) = (0.0, 0.0, 0.0);
    (summary.threads, summary.patches) = (0, [0; 3]);
    let ours = ["stepping_s", "memory_bytes", "peak_bytes", "balance"];
    summary.more.retain(|key, _| !ours.contains(&key.as_str()));
    summary
}

/// Summary, history and frames of two folders are the same.
#[track_caller]
fn same_results(one: &Path, other: &Path) {
    assert_eq!(timeless(one), timeless(other));
    let history = |folder: &Path| ok(std::fs::read_to_string(folder.join("history.csv")));
    assert_eq!(history(one), history(other));
    let output = sinew(&["compare", text(one), text(other)]);
    assert!(output.status.success(), "{}", words(&output));
}

#[test]
fn a_restart_continues_the_files_of_the_run() {
    let folder = folder();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    assert!(run(&whole, "30", &["--set", "output.frames=20"]).status.success());
    // the row and the frame of the end are not those of a run that goes on
    assert!(run(&parts, "12", &["--patches", "2x1x1", "--set", "output.frames=20"]).status.success());
    let again =
        ["run", "--restart", text(&parts), "--steps", "30", "--threads", "2", "--patches", "1x2x2", "-q"];
    let output = sinew(&again);
    assert!(output.status.success(), "{}", words(&output));
    same_results(&whole, &parts);
    assert_eq!(checkpoint::list(&parts).len(), 2, "only the last ones are kept");
    // once more, from the end
    assert!(sinew(&again).status.success());
    same_results(&whole, &parts);
}

#[test]
fn a_damaged_checkpoint_is_named_and_the_one_before_is_used() {
    let folder = folder();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    assert!(run(&whole, "20", &[]).status.success());
    assert!(run(&parts, "10", &[]).status.success());
    let last = checkpoint::path(&parts, 10);
    let mut bytes = ok(std::fs::read(&last));
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    ok(std::fs::write(&last, bytes));
    let output = sinew(&["run", "--restart", text(&parts), "--steps", "20"]);
    let said = words(&output);
    assert!(output.status.success(), "{said}");
    assert!(
        said.contains("warning: ") && said.contains("checkpoint-00000010.h5") && said.contains("damaged"),
        "{said}"
    );
    assert!(said.contains("checkpoint-00000009.h5"), "{said}");
    same_results(&whole, &parts);
    for file in checkpoint::list(&parts) {
        ok(std::fs::write(file, b"nothing"));
    }
    let output = sinew(&["run", "--restart", text(&parts)]);
    assert_eq!(output.status.code(), Some(2));
    assert!(words(&output).contains("holds no whole checkpoint"), "{}", words(&output));
}

#[test]
fn output_that_is_missing_damaged_or_asked_for_anew_is_said_and_begins_anew() {
    let folder = folder();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    assert!(run(&whole, "20", &[]).status.success());
    assert!(run(&parts, "10", &[]).status.success());
    let particles = parts.join("particles.vtkhdf");
    let bytes = ok(std::fs::read(&particles));
    ok(std::fs::write(&particles, &bytes[..bytes.len() / 2]));
    ok(std::fs::remove_file(parts.join("history.csv")));
    let output = sinew(&["run", "--restart", text(&parts), "--steps", "15", "--set", "output.frames=100"]);
    let said = words(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("history.csv is missing") && said.contains("particles.vtkhdf.damaged"), "{said}");
    let frames = |k| ok(ok(sinew::output::vtkhdf::Reader::open(&particles)).frame(k));
    assert!(frames(0).step > 10, "only new frames: {}", frames(0).step);
    let before = ok(sinew::output::vtkhdf::Reader::open(&particles)).frames();
    let output = sinew(&["run", "--restart", text(&parts), "--steps", "20", "-q"]);
    assert!(output.status.success(), "{}", words(&output));
    assert!(ok(sinew::output::vtkhdf::Reader::open(&particles)).frames() > before);
    assert_eq!(timeless(&whole), timeless(&parts));
    let scene = ok(std::fs::read_to_string(parts.join("scene.toml")));
    assert!(scene.contains("frames = 100"), "the scene as it was run: {scene}");
    // without a scene the checkpoint's own is used
    ok(std::fs::remove_file(parts.join("scene.toml")));
    assert!(sinew(&["run", "--restart", text(&parts), "-q"]).status.success());
    assert_eq!(timeless(&whole), timeless(&parts));
}

#[test]
fn a_restart_of_something_else_is_bad_usage() {
    let folder = folder();
    let out = folder.path().join("run");
    assert!(run(&out, "3", &[]).status.success());
    let refused = |arguments: &[&str], remedies: &[&str]| {
        let output = sinew(&[&["run", "--restart", text(&out), "-q"], arguments].concat());
        let said = words(&output);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(remedies.iter().all(|remedy| said.contains(remedy)), "{said}");
    };
    refused(&["--set", "run.cfl=0.2"], &["run.cfl is 0.4 there and 0.2 here", "another scene"]);
    refused(&["--set", "material.left.density=900"], &["material.left.density"]);
    refused(&["problems/slab-quick"], &["another scene"]);
    refused(&["--out", "elsewhere"], &["--out"]);
    let none = folder.path().join("none");
    let output = sinew(&["run", "--restart", text(&none)]);
    assert_eq!(output.status.code(), Some(2));
    assert!(words(&output).contains("holds no checkpoint"), "{}", words(&output));
    if Isa::available().len() > 1 {
        let other = |more: &[&str]| {
            let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
            command.args(["run", "--restart", text(&out), "-q", "--steps", "5"]).args(more);
            ok(command.env("SINEW_ISA", "baseline").output())
        };
        let output = other(&[]);
        assert_eq!(output.status.code(), Some(2));
        let said = words(&output);
        assert!(said.contains("instruction set") && said.contains("--force"), "{said}");
        assert!(other(&["--force"]).status.success());
    }
}

#[test]
fn a_signal_ends_a_run_with_a_checkpoint() {
    let folder = folder();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    let arguments = |out| {
        let quick = ["--set", "output.frames=4", "--set", "domain.cell=4 mm", "--set", "run.cfl=0.01"];
        let begin = ["run", "problems/two-spheres", "-q", "--out", out];
        [&begin[..], &quick].concat()
    };
    let binary = assert_cmd::cargo::cargo_bin!("sinew");
    let mut child =
        ok(Command::new(binary).args(arguments(text(&parts))).stderr(std::process::Stdio::piped()).spawn());
    let history = parts.join("history.csv");
    while std::fs::read_to_string(&history).map_or(0, |text| text.lines().count()) < 4 {
        assert_eq!(ok(child.try_wait()), None, "the run must last longer");
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    assert!(ok(Command::new("kill").args(["-TERM", &child.id().to_string()]).status()).success());
    let output = ok(child.wait_with_output());
    assert_eq!(output.status.code(), Some(143), "{}", words(&output));
    assert!(words(&output).contains("go on with: sinew run --restart"), "{}", words(&output));
    let summary = ok(std::fs::read_to_string(parts.join("summary.json")));
    assert!(summary.contains("\"status\": \"interrupted\""), "{summary}");
    assert_eq!(checkpoint::list(&parts).len(), 1);
    let output = sinew(&["run", "--restart", text(&parts), "-q"]);
    assert!(output.status.success(), "{}", words(&output));
    assert!(sinew(&arguments(text(&whole))).status.success());
    same_results(&whole, &parts);
}

#[test]
fn a_full_disk_ends_the_run_and_the_last_checkpoint_stays() {
    let folder = folder();
    let out = folder.path().join("run");
    assert!(run(&out, "5", &[]).status.success());
    let last = checkpoint::path(&out, 5);
    let most = ok(std::fs::metadata(&last)).len() / 1024 / 2;
    let script = format!("ulimit -f {most}; trap '' XFSZ; exec \"$0\" run --restart \"$1\" --steps 9 -q");
    let binary = assert_cmd::cargo::cargo_bin!("sinew");
    let output = ok(Command::new("bash").args(["-c", &script]).arg(binary).arg(&out).output());
    let said = words(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("cannot write") && said.contains("free some space"), "{said}");
    assert_eq!(ok(last_whole(&out)).path, last);
    let names = ok(std::fs::read_dir(&out)).map(|entry| ok(entry).file_name());
    assert!(names.into_iter().all(|name| !name.to_string_lossy().ends_with(".part")), "nothing half is left");
    assert!(ok(std::fs::read_to_string(out.join("summary.json"))).contains("failed"));
    // there is room again
    let output = sinew(&["run", "--restart", text(&out), "--steps", "9", "-q"]);
    assert!(output.status.success(), "{}", words(&output));
    let whole = folder.path().join("whole");
    assert!(run(&whole, "9", &[]).status.success());
    same_results(&whole, &out);
}

/// Runs to the end on some ranks, from a checkpoint if there is one, and writes one after `stop` steps.
fn on_ranks(ranks: usize, scene: &Scene, folder: &Path, stop: Option<u64>) -> Vec<(u64, String, u64, u64)> {
    together(ranks, |mut network| {
        let mut simulation = match stop {
            Some(_) => ok(Simulation::on(network, scene.clone(), Isa::detect())),
            None => {
                let (reader, _) = ok(last_checkpoint(&mut *network, folder));
                ok(Simulation::restore(network, scene.clone(), Isa::detect(), &reader))
            }
        };
        while stop.is_some_and(|stop| simulation.steps() < stop) {
            assert!(ok(simulation.step()), "the run ends too early");
        }
        if stop.is_some() {
            ok(simulation.write_checkpoint(folder, Recorded::default()));
        }
        let (hash, report, _, ticks) = end(&mut simulation);
        (hash, report, 0, ticks)
    })
}

#[test]
fn runs_on_other_numbers_of_ranks_go_on_with_the_same_bits() {
    for rates in ["common", "per-material"] {
        let scene = laid_out(scene(CLOUD, &[("run.rates", rates)]), ([3, 2, 2], 1));
        let (hash, report, _, ticks) = end(&mut ok(Simulation::new(scene.clone(), Isa::detect())));
        for (before, after) in [(1, 3), (3, 1), (2, 5), (5, 2)] {
            let folder = folder();
            for result in [
                on_ranks(before, &scene, folder.path(), Some(37)),
                on_ranks(after, &scene, folder.path(), None),
            ] {
                assert!(
                    result.iter().all(|r| *r == (hash, report.clone(), 0, ticks)),
                    "{before} and {after}"
                );
            }
        }
    }
}

#[test]
fn the_files_of_several_ranks_are_those_of_one() {
    let every = [("output.checkpoint.steps", "30"), ("output.frames", "4000")];
    let scene = laid_out(scene(CLOUD, &every), ([3, 2, 2], 1));
    let folder = folder();
    let folders = [1, 3].map(|ranks| {
        let out = folder.path().join(ranks.to_string());
        together(ranks, |network| {
            let mut simulation = ok(Simulation::on(network, scene.clone(), Isa::detect()));
            let mut recorder = ok(Recorder::create(&out, &mut simulation));
            while ok(simulation.step()) {
                assert_eq!(ok(recorder.step(&mut simulation, false)), Next::Go);
            }
            ok(recorder.finish(&mut simulation, End::Completed));
        });
        out
    });
    let [one, several] = folders.each_ref().map(|folder| Summary { ranks: 0, ..timeless(folder) });
    assert_eq!(one, several);
    let output = sinew(&["compare", text(&folders[0]), text(&folders[1])]);
    assert!(output.status.success(), "{}", words(&output));
    assert_eq!(checkpoint::list(&folders[1]).len(), 2);
}

#[test]
fn a_signal_on_any_rank_stops_all_of_them() {
    let scene = laid_out(scene(CLOUD, &[]), ([3, 2, 2], 1));
    let folder = folder();
    let summaries = together(3, |network| {
        let mut simulation = ok(Simulation::on(network, scene.clone(), Isa::detect()));
        let mut recorder = ok(Recorder::create(folder.path(), &mut simulation));
        let mut next = Next::Go;
        while next == Next::Go && ok(simulation.step()) {
            let caught = simulation.network().rank() == 2 && simulation.steps() == 7;
            next = ok(recorder.step(&mut simulation, caught));
        }
        ok(recorder.finish(&mut simulation, End::Interrupted)).steps
    });
    assert_eq!(summaries, [7, 7, 7]);
    assert_eq!(ok(last_whole(folder.path())).path, checkpoint::path(folder.path(), 7));
}

/// Kills the command at random moments, again and again, until the run is done. `SINEW_TEST_KILLS` sets how often at least.
#[test]
fn a_run_that_is_killed_at_any_moment_goes_on() {
    let least: usize = std::env::var("SINEW_TEST_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(15);
    let mut random = Random(std::process::id().into());
    let folder = folder();
    let whole = folder.path().join("whole");
    assert!(run(&whole, "40", &[]).status.success());
    let binary = assert_cmd::cargo::cargo_bin!("sinew");
    let (mut kills, mut rounds) = (0, 0);
    while kills < least {
        rounds += 1;
        let parts = folder.path().join(format!("parts-{rounds}"));
        let begin = ["run", "problems/two-spheres", "-q", "--steps", "40", "--out", text(&parts)];
        let every =
            ["--set", "output.checkpoint.steps=1", "--set", "output.frames=200", "--set", "domain.cell=4 mm"];
        let mut done = false;
        while !done {
            let any = !checkpoint::list(&parts).is_empty();
            let arguments = match any {
                true => vec!["run", "--restart", text(&parts), "-q"],
                false => [&begin[..], &every, &["--force"]].concat(),
            };
            let mut child =
                ok(Command::new(binary).args(&arguments).stdout(std::process::Stdio::null()).spawn());
            std::thread::sleep(std::time::Duration::from_micros(2_000 + (random.unit() * 400_000.0) as u64));
            done = match ok(child.try_wait()) {
                Some(status) => {
                    assert!(status.success(), "it ended by itself with {status}: {arguments:?}");
                    true
                }
                None => {
                    ok(child.kill());
                    ok(child.wait());
                    kills += 1;
                    false
                }
            };
        }
        // frames that were being written down when the run was killed are set aside, with those before
        if parts.join("particles.vtkhdf.damaged").exists() {
            println!("frames began anew");
            assert_eq!(timeless(&whole), timeless(&parts));
        } else {
            same_results(&whole, &parts);
        }
    }
    println!("killed {kills} times in {rounds} runs");
}
