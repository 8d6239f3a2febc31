//! Scenes with random faults, from those that are right: each is refused in words that help, or runs.
//!
//! The same 500 each time; `SINEW_TEST_CASES=20` makes it 10 000. A failure names the scene and the seeds of its mutations, and
//! prints it.
mod grammar;
#[path = "../common/random.rs"]
mod random;
#[path = "../common/told.rs"]
mod told;

use grammar::mutate;
use proptest::prelude::*;
use scene::{Scene, sampling};
use sinew::input::{SceneError, identity, read, read_text};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};
use toml::Table;

/// Memory that a scene may ask for [B], and particles of a scene that is run.
const MEMORY: usize = 64 << 20;
const PARTICLES: usize = 14_000;
/// The longest that reading, or a run of two steps, may take on a busy machine.
const LONGEST: Duration = Duration::from_secs(60);

/// A scene to begin with: its name and text.
struct Base {
    name: String,
    text: String,
}

#[track_caller]
fn ok<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

/// All scenes that there are, on cells so coarse that they have few particles.
fn bases() -> Vec<Base> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files = |folder: &str| ok(std::fs::read_dir(root.join(folder))).map(|entry| ok(entry).path());
    let problems = files("problems").map(|folder| folder.join("scene.toml"));
    let mut found: Vec<PathBuf> =
        problems.chain(files("tests/scenes")).filter(|path| path.is_file()).collect();
    found.sort();
    assert!(found.len() > 10, "{found:?}");
    found.iter().map(|path| coarse(path)).collect()
}

fn coarse(path: &Path) -> Base {
    let name = ok(path.strip_prefix(env!("CARGO_MANIFEST_DIR"))).display().to_string();
    let text = ok(std::fs::read_to_string(path));
    let scene = ok(read(path, &[]).map_err(|error| format!("{:?}", miette::Report::new(error))));
    let line =
        text.lines().find(|line| line.starts_with("cell = ")).unwrap_or_else(|| panic!("{name} has no cell"));
    for factor in 1..200 {
        let cell = format!("cell = {}", f64::from(factor) * scene.domain.cell);
        let text = text.replacen(line, &cell, 1);
        if read_text(&name, &text, &[], Some(MEMORY)).is_ok_and(|scene| is_small(&scene)) {
            return Base { name, text };
        }
    }
    panic!("{name} has no coarse cells")
}

fn is_small(scene: &Scene) -> bool {
    let filled = scene.bodies.iter().filter(|body| scene.materials[body.material].has_particles());
    filled.map(|body| sampling::count(scene, body)).sum::<usize>() <= PARTICLES
}

#[test]
fn every_mutant_is_refused_in_words_or_runs() {
    let bases = bases();
    let tables: Vec<Table> = bases.iter().map(|base| ok(base.text.parse::<Table>())).collect();
    let folder = ok(tempfile::tempdir());
    let counts = RefCell::new(BTreeMap::new());
    let case = (0..bases.len(), proptest::collection::vec(any::<u64>().no_shrink(), 1..=3));
    let result = random::runner(500).run(&case, |(base, seeds)| {
        let scene = seeds
            .iter()
            .fold(bases[base].text.clone().into_bytes(), |scene, seed| mutate(&scene, *seed, &tables));
        // an abort prints nothing: what it was about is in this file
        let file = folder.path().join("scene.toml");
        ok(std::fs::write(&file, &scene));
        let began = Instant::now();
        let outcome = judge(&file, &scene).and_then(|outcome| match began.elapsed() {
            took if took > 2 * LONGEST => Err(format!("it takes {took:?}")),
            _ => Ok(outcome),
        });
        let text = String::from_utf8_lossy(&scene);
        let outcome = outcome
            .map_err(|why| TestCaseError::fail(format!("{}, {seeds:?}: {why}\n{text}", bases[base].name)))?;
        *counts.borrow_mut().entry(outcome).or_insert(0) += 1;
        Ok(())
    });
    for (outcome, count) in counts.borrow().iter() {
        println!("{count:>6} {outcome}");
    }
    if let Err(error) = result {
        std::mem::forget(folder);
        panic!("{error}");
    }
}

/// What becomes of a scene, or what must not.
fn judge(file: &Path, scene: &[u8]) -> Result<&'static str, String> {
    let Ok(text) = std::str::from_utf8(scene) else {
        let error = read(file, &[]).map(|_| ()).expect_err("no text").to_string();
        return if error.contains("UTF-8") { Ok("refused: no text") } else { Err(error) };
    };
    match read_text("scene.toml", text, &[], Some(MEMORY)) {
        Err(error) => told::told(&error).map(|_| class(&error)),
        Ok(scene) => {
            resolved(&scene)?;
            if is_small(&scene) { two_steps(file) } else { Ok("accepted, not run") }
        }
    }
}

/// What a restart reads is the same scene.
fn resolved(scene: &Scene) -> Result<(), String> {
    let again = read_text("resolved", &scene.resolved, &[], Some(MEMORY));
    let again =
        again.map_err(|error| format!("resolved, it is refused: {:?}", miette::Report::new(error)))?;
    identity::first_difference(&scene.resolved, &again.resolved).map_or(Ok(()), Err)
}

/// Which part of the reader has refused a scene.
fn class(error: &SceneError) -> &'static str {
    const WHOLE: [&str; 13] = [
        "outside of the domain",
        " overlap at ",
        "do not fit into memory",
        "has no particles",
        "has no body",
        "meets nothing",
        "two bodies named",
        "is unbounded",
        "lies in this region",
        "the scene has ",
        "what does it turn",
        "is locked a",
        "lies on the surface",
    ];
    let message = error.to_string();
    let has = |words: &[&str]| words.iter().any(|words| message.contains(words));
    match () {
        () if has(&["this is not TOML"]) => "refused: syntax",
        () if has(&["unknown key", "is missing", "exactly one key"]) => "refused: keys",
        () if has(&WHOLE) => "refused: whole",
        () => "refused: values",
    }
}

/// Runs two steps in a process of its own, with limits on time and memory.
fn two_steps(file: &Path) -> Result<&'static str, String> {
    let folder = file.parent().unwrap_or(Path::new("."));
    let [out, said] = ["run", "said"].map(|name| folder.join(name));
    let log = ok(File::create(&said));
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v 6000000; exec \"$0\" \"$@\""]).arg(assert_cmd::cargo::cargo_bin!("sinew"));
    command.arg("run").arg(file).args(["-q", "--force", "--steps", "2", "--threads", "1"]);
    command.args(["--set", "output.frames=0", "--out"]).arg(&out).current_dir(folder);
    let mut child = ok(command.stdout(ok(log.try_clone())).stderr(log).spawn());
    let began = Instant::now();
    let status = loop {
        match ok(child.try_wait()) {
            Some(status) => break status,
            None if began.elapsed() > LONGEST => {
                ok(child.kill());
                ok(child.wait());
                return Err(format!("two steps take more than {LONGEST:?}"));
            }
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    let said = String::from_utf8_lossy(&ok(std::fs::read(&said))).into_owned();
    let odd =
        said.contains("panicked") || said.len() > 20_000 || said.chars().any(|c| c.is_control() && c != '\n');
    match status.code().filter(|_| !odd) {
        Some(0) => Ok("run: 0"),
        Some(1) => Ok("run: 1, it failed"),
        Some(2) => Ok("run: 2, refused"),
        _ => Err(format!("two steps end with {status}:\n{said}")),
    }
}
