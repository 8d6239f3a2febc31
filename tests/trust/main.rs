//! What a user must be able to rely on: a folder that is one run's, a run that no screen ends.
#[path = "../common/command.rs"]
mod command;
mod end;
mod files;
mod folder;
mod scenes;
mod screen;
#[path = "../common/splitmix.rs"]
mod splitmix;
#[path = "../common/told.rs"]
mod told;
mod two;
mod warnings;

use command::{ok, sinew, text, words};
use sinew::output::checkpoint;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

fn temporary() -> tempfile::TempDir {
    ok(tempfile::tempdir())
}

/// `sinew run` of two balls on a coarse grid.
fn run(arguments: &[&str]) -> Command {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/two-spheres");
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
    command.arg("run").arg(scene).args(["--set", "domain.cell=4 mm", "--set", "output.frames=2"]);
    command.args(["--threads", "1"]).args(arguments);
    command
}

/// A run that lasts until it is killed: of many small steps.
fn endless(out: &Path) -> Child {
    let mut command = run(&["-q", "--set", "run.cfl=1e-4", "--set", "output.checkpoint.steps=10", "--out"]);
    let child = ok(command.arg(out).stdout(Stdio::null()).stderr(Stdio::null()).spawn());
    until(|| !checkpoint::list(out).is_empty());
    child
}

fn until(done: impl Fn() -> bool) {
    let began = Instant::now();
    while !done() {
        assert!(began.elapsed() < Duration::from_secs(60), "it does not happen");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn restart(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
    ok(command.args(["run", "-q", "--restart"]).arg(folder).args(arguments).output())
}

/// All files below a folder, with what they hold. Links are not followed.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    for entry in ok(std::fs::read_dir(folder)) {
        let path = ok(entry).path();
        if path.is_symlink() {
            found.push((path.clone(), text(&ok(std::fs::read_link(&path))).into()));
        } else if path.is_dir() {
            found.extend(contents(&path));
        } else {
            found.push((path.clone(), ok(std::fs::read(path))));
        }
    }
    found.sort();
    found
}

#[track_caller]
fn refused(output: &Output, facts: &[&str]) {
    let said = words(output);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(facts.iter().all(|fact| said.contains(fact)), "{said}");
}

#[track_caller]
fn completed(output: &Output) {
    assert!(output.status.success(), "{:?}: {}", output.status, words(output));
}
