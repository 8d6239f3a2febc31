//! Ranks on two hosts that are far from one another: with a folder that both see and without, and what is told when a host
//! sees less than it needs, has another build, or is gone. `pair.rs` makes the hosts of namespaces, for which it must be root.
#![cfg(all(feature = "mpi", target_os = "linux"))]
#[path = "../common/mod.rs"]
mod common;
mod pair;

use common::command::{ok, sinew, text, words};
use pair::{HANGS, Pair};
use sinew::output::checkpoint;
use sinew::output::summary::Summary;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Output, Stdio};
use std::time::{Duration, Instant};

const SPHERES: &str = "problems/two-spheres";
/// Within this time a job ends that cannot begin, or go on.
const SOON: Duration = Duration::from_secs(60);

/// The words of a short run.
fn short<'a>(scene: &'a str, steps: &'a str, out: &'a Path) -> Vec<&'a str> {
    let run = ["run", scene, "-q", "--threads", "1", "--force", "--set", "domain.cell=4 mm"];
    [&run[..], &["--steps", steps, "--out", text(out)]].concat()
}

/// The words of a restart.
fn go_on<'a>(steps: &'a str, from: &'a Path) -> Vec<&'a str> {
    vec!["run", "--restart", text(from), "-q", "--threads", "1", "--steps", steps]
}

fn hash(folder: &Path) -> String {
    ok(Summary::read(&folder.join("summary.json"))).state_hash
}

/// The hash of a short run on one rank.
fn alone(pair: &Pair) -> String {
    let out = pair.path("alone");
    succeeds(&sinew(&short(SPHERES, "20", &out)));
    hash(&out)
}

#[track_caller]
fn succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", words(output));
    words(output)
}

/// Ends with status 2, and says each fact once.
#[track_caller]
fn refuses(pair: &Pair, run: &[&str], facts: &[&str]) {
    let began = Instant::now();
    let output = pair.output(run);
    let said = words(&output);
    println!("{:.1} s: {said}", began.elapsed().as_secs_f64());
    assert_eq!(output.status.code(), Some(2), "{run:?}: {said}");
    facts.iter().for_each(|fact| assert_eq!(said.matches(fact).count(), 1, "{fact}: {said}"));
}

/// The files of a folder with what they hold.
fn content(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let all = ok(fs::read_dir(folder)).map(|entry| ok(entry).path());
    let one = |path: PathBuf| match path.is_dir() {
        true => content(&path),
        false => BTreeMap::from([(path.clone(), ok(fs::read(&path)))]),
    };
    all.flat_map(one).collect()
}

#[test]
fn hosts_with_one_folder_give_the_bits_of_one_rank_also_over_a_restart() {
    let Some(pair) = Pair::start() else { return };
    let (wanted, out) = (alone(&pair), pair.path("run"));
    let said = succeeds(&pair.output(&short(SPHERES, "20", &out)));
    assert!(said.contains(&format!("results a:{} ", text(&out))), "{said}");
    let summary = ok(Summary::read(&out.join("summary.json")));
    assert_eq!((summary.ranks, &summary.state_hash), (4, &wanted));
    let half = [&short(SPHERES, "10", &out)[..], &["--set", "output.checkpoint.steps=10"]].concat();
    succeeds(&pair.output(&half));
    assert_ne!(hash(&out), wanted);
    succeeds(&pair.output(&go_on("20", &out)));
    assert_eq!(hash(&out), wanted);
}

#[test]
fn a_host_that_sees_neither_scene_nor_results_takes_part_but_for_a_restart() {
    let Some(pair) = Pair::start() else { return };
    let (wanted, [scene, parts]) = (alone(&pair), ["scene", "parts"].map(|name| pair.path(name)));
    ok(fs::create_dir(&scene));
    ok(fs::copy(format!("{SPHERES}/scene.toml"), scene.join("scene.toml")));
    pair.b.hide(&pair.path(""));
    let out = pair.path("run");
    succeeds(&pair.output(&[&short(text(&scene), "20", &out)[..], &["--trace"]].concat()));
    assert_eq!(hash(&out), wanted);
    assert!(out.join("trace.json").is_file());
    let half = [&short(text(&scene), "10", &parts)[..], &["--set", "output.checkpoint.steps=10"]].concat();
    succeeds(&pair.output(&half));
    assert_eq!(pair.b.run(&["ls", "-A", text(&pair.path(""))]), "", "nothing is written on the other host");

    let (before, again) = (content(&parts), go_on("20", &parts));
    let last = ok(checkpoint::last_whole(&parts)).path;
    refuses(&pair, &again, &["rank 2", "host b does not see", text(&last), "where all hosts see it"]);
    pair.b.run(&["mkdir", text(&parts)]);
    pair.b.run(&["cp", "Cargo.toml", text(&last)]);
    refuses(&pair, &again, &["rank 2", "host b sees another file", text(&last), "where all hosts see it"]);
    assert_eq!(content(&parts), before, "a restart that cannot begin changes nothing");
    pair.b.run(&["umount", text(&pair.path(""))]);
    succeeds(&pair.output(&again));
    assert_eq!(hash(&parts), wanted);
}

/// A tetrahedron of 8 mm in place of a ball.
const MESH: &str = "solid t\n\
    facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 8 0\nvertex 8 0 0\nendloop\nendfacet\n\
    facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 8 0 0\nvertex 0 0 8\nendloop\nendfacet\n\
    facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 8\nvertex 0 8 0\nendloop\nendfacet\n\
    facet normal 0 0 0\nouter loop\nvertex 8 0 0\nvertex 0 8 0\nvertex 0 0 8\nendloop\nendfacet\n\
    endsolid t\n";

#[test]
fn a_mesh_that_a_host_does_not_see_is_named() {
    let Some(pair) = Pair::start() else { return };
    let [meshes, scene, out] = ["meshes", "scene.toml", "run"].map(|name| pair.path(name));
    ok(fs::create_dir(&meshes));
    let mesh = meshes.join("tetrahedron.stl");
    ok(fs::write(&mesh, MESH));
    let shape = format!("{{ mesh = {{ file = {:?}, unit = \"mm\" }} }}", text(&mesh));
    let ball = "{ sphere = { center = [\"14 mm\", 0, 0], radius = \"10 mm\" } }";
    let spheres = ok(fs::read_to_string(format!("{SPHERES}/scene.toml")));
    assert!(spheres.contains(ball));
    ok(fs::write(&scene, spheres.replace(ball, &shape)));
    let run = short(text(&scene), "5", &out);
    pair.b.hide(&meshes);
    refuses(&pair, &run, &["rank 2 (host b)", "No such file", "must see it there"]);
    let other = MESH.replace("0 0 8", "0 0 9");
    pair.b.run(&["sh", "-c", "printf %s \"$1\" >\"$2\"", "sh", &other, text(&mesh)]);
    refuses(&pair, &run, &["rank 2 (host b)", "mesh.digest", "the same ones under one path"]);
    assert!(!out.exists(), "nothing is begun");
    pair.b.run(&["umount", text(&meshes)]);
    succeeds(&pair.output(&run));
}

#[test]
fn a_host_with_another_build_is_named() {
    let Some(pair) = Pair::start() else { return };
    let [other, out] = ["other-build", "run"].map(|name| pair.path(name));
    let build = assert_cmd::cargo::cargo_bin!("sinew");
    pair.b.run(&["sh", "-c", "cp \"$1\" \"$2\" && echo >>\"$2\"", "sh", text(build), text(&other)]);
    pair.b.run(&["mount", "--bind", text(&other), text(build)]);
    refuses(&pair, &short(SPHERES, "20", &out), &["rank 2 (host b) is another build"]);
    assert!(!out.exists(), "nothing is begun");
}

/// What makes a run endless, with a checkpoint every step.
const ENDLESS: [&str; 6] =
    ["--set", "run.until=100 s", "--set", "output.frames=0", "--set", "output.checkpoint.steps=1"];

/// Begins a run over both hosts, does harm to it, and waits until nothing of it is left.
#[track_caller]
fn harm(pair: &Pair, out: &Path, harm: impl FnOnce()) {
    let mut job = pair.mpirun(&[&short(SPHERES, "100000", out)[..], &ENDLESS].concat());
    let mut job = ok(job.stdout(Stdio::null()).stderr(Stdio::null()).spawn());
    let began = Instant::now();
    while checkpoint::list(out).len() < 2 {
        assert!(began.elapsed() < SOON && ok(job.try_wait()).is_none(), "it does not begin");
        std::thread::sleep(Duration::from_millis(10));
    }
    harm();
    let harmed = Instant::now();
    while ok(job.try_wait()).is_none() || pair.b.ranks() != 0 {
        assert!(harmed.elapsed() < SOON, "it goes on, with {} ranks on the other host", pair.b.ranks());
        std::thread::sleep(Duration::from_millis(50));
    }
    let status = ok(job.wait());
    println!("ended after {:.1} s: {status}", harmed.elapsed().as_secs_f64());
    assert!(!status.success() && began.elapsed() < HANGS);
}

/// The other host says who left the lock; then a restart by `go_on` has the bits of a run that was never stopped.
#[track_caller]
fn mends(pair: &Pair, out: &Path, go_on: impl FnOnce(&[&str]) -> Output) {
    let last = ok(checkpoint::Reader::open(&ok(checkpoint::last_whole(out)).path)).head.steps;
    let (steps, whole) = ((last + 5).to_string(), pair.path("whole"));
    succeeds(&sinew(&[&short(SPHERES, &steps, &whole)[..], &ENDLESS].concat()));
    let again = self::go_on(&steps, out);
    let lock = out.join("run.lock");
    let refused = pair.b.sinew(&again);
    let said = words(&refused);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    for fact in [" on a (", "nobody can tell from b", &format!("remove {}", text(&lock))] {
        assert!(said.contains(fact), "{fact}: {said}");
    }
    succeeds(&go_on(&again));
    assert_eq!(hash(out), hash(&whole), "after step {last}");
    assert!(!lock.exists());
}

#[test]
fn a_rank_that_is_killed_and_a_host_that_is_gone_end_the_job_and_a_restart_goes_on() {
    let Some(pair) = Pair::start() else { return };
    let out = pair.path("killed");
    harm(&pair, &out, || pair.b.kill_a_rank());
    mends(&pair, &out, |again| pair.output(again));

    let out = pair.path("cut");
    harm(&pair, &out, || drop(pair.b.run(&["ip", "link", "set", "eth0", "down"])));
    pair.b.run(&["ip", "link", "set", "eth0", "up"]);
    mends(&pair, &out, |again| pair.output(again));

    let out = pair.path("lost");
    harm(&pair, &out, || pair.a.end());
    mends(&pair, &out, |again| {
        ok(fs::remove_file(out.join("run.lock")));
        pair.b.sinew(again)
    });
}
