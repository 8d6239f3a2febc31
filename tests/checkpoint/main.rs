//! Runs that are stopped and go on: the same bits as if nothing had happened, and no damaged checkpoint is ever used.
mod command;
#[path = "../common/mod.rs"]
mod common;
mod crafted;
mod frames;
mod ranks;
#[path = "../common/unlocked.rs"]
mod unlocked;

use common::command::{kills, ok, sinew, text, words};
use common::{Overrides, Random, finish, scene, soft_shot};
use engine::exec::ranks::local::Local;
use engine::exec::ranks::{Alone, Network};
use scene::Scene;
use simd::Isa;
use sinew::output::checkpoint::{self, Reader, Recorded, last_whole};
use sinew::output::history::Table;
use sinew::output::summary::Summary;
use sinew::simulation::recorder::{End, Next, Recorder, last_checkpoint};
use sinew::simulation::{Report, RunError, Simulation};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use unlocked::unlocked;

type Layout = ([usize; 3], usize);

fn laid_out(mut scene: Scene, (patches, threads): Layout) -> Scene {
    (scene.run.patches, scene.run.threads) = (Some(scene::Patches::Grid(patches)), Some(threads));
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
const CLOUD: &str = include_str!("../scenes/cloud.toml");

#[test]
fn so_does_one_with_all_that_holds_and_pushes() {
    for text in [
        include_str!("../scenes/held.toml"),
        include_str!("../scenes/afloat.toml"),
        include_str!("../scenes/carried.toml"),
    ] {
        goes_on(&scene(text, &[]), &mut Random(9));
    }
}

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
    // a pipe and a folder of such a name are none, and another file of such a name stays where it is
    let [pipe, inner, foreign] = [7, 8, 9].map(|steps| checkpoint::path(folder.path(), steps));
    assert!(ok(Command::new("mkfifo").arg(&pipe).status()).success());
    ok(std::fs::create_dir(&inner));
    ok(std::fs::write(&foreign, b"a letter"));
    ok(checkpoint::prune(folder.path(), 3));
    assert_eq!(checkpoint::list(folder.path()), [foreign.clone(), three.clone(), two.clone(), one.clone()]);
    assert_eq!(ok(last_whole(folder.path())).path, three);
    assert!(ok(last_whole(folder.path())).damaged.is_empty());
    ok(std::fs::remove_file(&foreign));
    let bytes = ok(std::fs::read(&three));
    ok(std::fs::write(&three, &bytes[..bytes.len() / 2]));
    let found = ok(last_whole(folder.path()));
    assert_eq!((found.path, found.damaged), (two.clone(), vec![three.clone()]));
    assert!(found.warnings[0].contains("checkpoint-00000003.h5"), "{:?}", found.warnings);
    ok(checkpoint::prune(folder.path(), 1));
    assert_eq!(checkpoint::list(folder.path()), [three.clone(), two.clone()], "the whole ones are counted");
    for file in [&one, &two] {
        ok(std::fs::write(file, b"nothing"));
    }
    let error = last_whole(folder.path()).expect_err("none is whole").to_string();
    assert!(["00000001", "00000002", "00000003"].iter().all(|name| error.contains(name)), "{error}");
}
/// Files with a good seal that say something else than they should: each is refused, or read as far as it makes sense, and none makes Sinew panic or
/// read what lies elsewhere.
#[test]
fn crafted_checkpoints_are_refused() {
    let folder = folder();
    let path = stopped(shot(&[]), LAYOUTS[0], 2, folder.path());
    let bytes = ok(std::fs::read(&path));
    let content = &bytes[..bytes.len() - 32];
    let mut names = Vec::new();
    {
        ok(std::fs::write(&path, content));
        let file = ok(unlocked().open(&path));
        datasets(&file, "", &mut names);
    }
    assert!(names.len() > 20, "{names:?}");
    let secret = folder.path().join("secret");
    ok(std::fs::write(&secret, [0u8; 4096]));
    let mut refused = 0;
    for (number, name) in names.iter().enumerate() {
        ok(std::fs::write(&path, content));
        {
            let file = ok(unlocked().open_rw(&path));
            let shape = ok(file.dataset(name)).shape();
            ok(file.unlink(name));
            let made = file.new_dataset::<f64>();
            let made = match number % 5 {
                0 => Ok(()),
                1 => made
                    .shape(shape.iter().map(|n| n + 1).collect::<Vec<_>>())
                    .create(name.as_str())
                    .map(drop),
                2 => made
                    .shape(shape.iter().map(|n| n / 2).collect::<Vec<_>>())
                    .create(name.as_str())
                    .map(drop),
                3 => file
                    .new_dataset::<hdf5::types::FixedAscii<4>>()
                    .shape(shape)
                    .create(name.as_str())
                    .map(drop),
                _ => {
                    let external = made.external(text(&secret), 0, 8 * shape.iter().product::<usize>());
                    external.shape(shape).create(name.as_str()).map(drop)
                }
            };
            ok(made);
        }
        ok(sinew::output::seal::seal(&path));
        let read = Reader::open(&path).map_err(RunError::from).and_then(|reader| {
            Simulation::restore(Box::new(Alone), laid_out(shot(&[]), LAYOUTS[0]), Isa::detect(), &reader)
        });
        refused += usize::from(read.is_err());
        println!("{name} {}: {}", number % 5, read.err().map_or("read".into(), |error| error.to_string()));
    }
    assert_eq!(refused, names.len(), "nothing of it is superfluous");
}

/// The names of all datasets below a group.
fn datasets(group: &hdf5::Group, path: &str, into: &mut Vec<String>) {
    for name in ok(group.member_names()) {
        let whole = if path.is_empty() { name.clone() } else { format!("{path}/{name}") };
        match group.group(&name) {
            Ok(inner) => datasets(&inner, &whole, into),
            Err(_) => into.push(whole),
        }
    }
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
