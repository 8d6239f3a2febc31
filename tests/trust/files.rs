//! Files of a run that something outside of it has touched.
use crate::*;
use sinew::output::vtkhdf;
use std::os::unix::fs::PermissionsExt;

/// A run that lasts, and writes only when it is asked to.
fn quiet(out: &Path) -> Child {
    let quiet = ["-q", "--set", "run.cfl=1e-4", "--set", "output.frames=0", "--out"];
    let child = ok(run(&quiet).arg(out).stdout(Stdio::null()).stderr(Stdio::piped()).spawn());
    let history = out.join("history.csv");
    until(|| std::fs::read_to_string(&history).is_ok_and(|rows| rows.lines().count() > 3));
    child
}

fn signal(name: &str, child: &Child) {
    assert!(ok(Command::new("kill").args([name, &child.id().to_string()]).status()).success());
}

#[test]
fn a_run_whose_folder_was_given_to_another_writes_nothing_more() {
    let folder = temporary();
    let out = folder.path().join("run");
    let child = quiet(&out);
    ok(std::fs::remove_file(out.join("run.lock")));
    let later = ["-q", "--force", "--steps", "6", "--set", "output.checkpoint.steps=3", "--out"];
    completed(&ok(run(&later).arg(&out).output()));
    let other = ok(sinew::output::claim::Claim::take(&out));
    let before = contents(&out);
    // it wants to leave a checkpoint and a summary
    signal("-TERM", &child);
    let output = ok(child.wait_with_output());
    let said = words(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    for fact in ["run.lock", &format!("process {}", std::process::id()), "has the folder now", "--out"] {
        assert!(said.contains(fact), "{fact}: {said}");
    }
    assert_eq!(contents(&out), before);
    drop(other);
    completed(&restart(&out, &["--steps", "9"]));
}

/// Whoever took it is done, and its lock is gone: a run that finds none does not take the folder for its own.
#[test]
fn a_run_whose_folder_another_has_had_writes_nothing_more() {
    let folder = temporary();
    for force in [true, false] {
        let out = folder.path().join("run");
        let child = quiet(&out);
        match force {
            true => ok(std::fs::remove_file(out.join("run.lock"))),
            false => ok(std::fs::remove_dir_all(&out)),
        }
        completed(&ok(run(&["-q", "--force", "--steps", "6", "--out"]).arg(&out).output()));
        let before = contents(&out);
        signal("-TERM", &child);
        let output = ok(child.wait_with_output());
        let said = words(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("another run has had the folder since"), "{said}");
        assert_eq!(contents(&out), before);
        ok(std::fs::remove_dir_all(&out));
    }
}

#[test]
fn a_lock_that_is_removed_comes_back() {
    let folder = temporary();
    let out = folder.path().join("run");
    let child = quiet(&out);
    ok(std::fs::remove_file(out.join("run.lock")));
    signal("-TERM", &child);
    let output = ok(child.wait_with_output());
    assert_eq!(output.status.code(), Some(143), "{}", words(&output));
    assert!(!out.join("run.lock").exists() && !checkpoint::list(&out).is_empty());
}

#[test]
fn frames_stay_while_a_run_goes_on_without_any() {
    let folder = temporary();
    let out = folder.path().join("run");
    let frames = || ok(vtkhdf::Reader::open(&out.join("particles.vtkhdf"))).times().to_vec();
    completed(&ok(run(&["-q", "--steps", "20", "--set", "output.frames=1000", "--out"]).arg(&out).output()));
    let before = frames();
    assert!(before.len() > 5, "{before:?}");
    for steps in ["30", "32", "34"] {
        completed(&restart(&out, &["--steps", steps, "--set", "output.frames=0"]));
    }
    completed(&restart(&out, &["--steps", "40", "--set", "output.frames=1000"]));
    let after = frames();
    // but for the one that was there because the run ended
    assert!(after.starts_with(&before[..before.len() - 1]), "{before:?}, {after:?}");
    assert!(after.len() > before.len(), "{before:?}, {after:?}");
}

#[test]
fn a_file_that_may_not_be_read_is_not_damaged() {
    let folder = temporary();
    let out = folder.path().join("run");
    let steps = ["--steps", "6", "--set", "output.checkpoint.steps=3", "--set", "output.frames=500"];
    completed(&ok(run(&["-q"]).args(steps).arg("--out").arg(&out).output()));
    // also where this is root, who may read all
    let program = folder.path().join("sinew");
    ok(std::fs::copy(assert_cmd::cargo::cargo_bin!("sinew"), &program));
    assert!(ok(Command::new("chmod").args(["-R", "a+rwX"]).arg(folder.path()).status()).success());
    let root = text_of(&ok(Command::new("id").arg("-u").output()).stdout) == "0";
    let restart = || {
        let mut command = match root {
            true => Command::new("setpriv"),
            false => Command::new(&program),
        };
        if root {
            command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]).arg(&program);
        }
        ok(command.args(["run", "-q", "--steps", "9", "--restart"]).arg(&out).output())
    };
    for file in ["particles/000001.h5", "particles.vtkhdf", "history.csv", "checkpoint-00000006.h5"] {
        let path = out.join(file);
        let permit = |mode| ok(std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)));
        permit(0o000);
        let before = root.then(|| contents(&out));
        refused(&restart(), &[file, "make it readable"]);
        assert_eq!(before, root.then(|| contents(&out)), "{file}");
        permit(0o666);
    }
    completed(&restart());
}

fn text_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).trim().into()
}

#[test]
fn pictures_do_not_replace_files_of_a_run() {
    let folder = temporary();
    let out = folder.path().join("run");
    completed(&ok(run(&["-q", "--steps", "3", "--out"]).arg(&out).output()));
    ok(std::os::unix::fs::symlink(out.join("summary.json"), folder.path().join("link")));
    let before = contents(folder.path());
    let plot = |to: &Path| sinew(&["plot", text(&out), "--y", "time_s", "--out", text(to)]);
    let claim = ok(sinew::output::claim::Claim::take(&out));
    refused(&plot(&out.join("run.lock")), &["is a file of a run"]);
    drop(claim);
    for name in ["history.csv", "particles.vtkhdf", "particles/000000.h5", "../link", "../run/scene.toml"] {
        refused(&plot(&out.join(name)), &["is a file of a run"]);
    }
    assert_eq!(contents(folder.path()), before);
    completed(&plot(&folder.path().join("section.png")));
    completed(&plot(&folder.path().join("section.png")));
}

#[test]
fn what_cannot_be_compared_is_neither_the_same_nor_different() {
    let folder = temporary();
    let [one, other] = ["one", "other"].map(|name| folder.path().join(name));
    for out in [&one, &other] {
        completed(&ok(run(&["-q", "--steps", "3", "--out"]).arg(out).output()));
    }
    let compare = || sinew(&["compare", text(&one), text(&other)]);
    completed(&compare());
    for file in ["particles.vtkhdf", "particles/000001.h5", "checkpoint-00000003.h5", "history.csv"] {
        let path = other.join(file);
        let bytes = ok(std::fs::read(&path));
        let mut damaged = bytes.clone();
        damaged[bytes.len() / 2] = 0xff;
        ok(std::fs::write(&path, damaged));
        refused(&compare(), &[file]);
        ok(std::fs::remove_file(&path));
        ok(std::fs::create_dir(&path));
        if file != "checkpoint-00000003.h5" {
            refused(&compare(), &[file, "no file"]);
        }
        ok(std::fs::remove_dir(&path));
        ok(std::fs::write(&path, bytes));
        completed(&compare());
    }
}

/// Refused is refused before anything is changed.
#[test]
fn a_restart_that_cannot_write_changes_nothing() {
    let folder = temporary();
    let whole = folder.path().join("whole");
    completed(&ok(run(&["-q", "--steps", "6", "--out"]).arg(&whole).output()));
    for (name, fact) in [
        ("scene.toml", "where a run writes a file"),
        ("summary.json", "where a run writes a file"),
        ("particles.vtkhdf", "where a run writes a file"),
        ("particles/000007.h5", "where a run writes a frame"),
        ("particles", "where a run has its frames"),
    ] {
        let out = folder.path().join("run");
        assert!(ok(Command::new("cp").arg("-r").args([&whole, &out]).status()).success());
        let path = out.join(name);
        if path.is_dir() {
            ok(std::fs::remove_dir_all(&path));
            ok(std::fs::write(&path, b"mine"));
        } else {
            // some are not there
            let _ = std::fs::remove_file(&path);
            ok(std::fs::create_dir(&path));
        }
        let before = contents(&out);
        refused(&restart(&out, &["--steps", "9"]), &[fact, "move it away"]);
        assert_eq!(contents(&out), before, "{name}");
        ok(std::fs::remove_dir_all(&out));
    }
}

/// A history and a checkpoint of another run of the same scene.
#[test]
fn what_another_run_wrote_is_told() {
    let folder = temporary();
    let [out, other] = ["run", "other"].map(|name| folder.path().join(name));
    let steps = |steps| ["-q", "--steps", steps, "--set", "output.checkpoint.steps=3"];
    completed(&ok(run(&steps("6")).arg("--out").arg(&out).output()));
    completed(&ok(run(&steps("9")).arg("--out").arg(&other).output()));
    let summary = || ok(std::fs::read_to_string(out.join("summary.json")));
    ok(std::fs::copy(other.join("checkpoint-00000009.h5"), out.join("checkpoint-00000009.h5")));
    let output = restart(&out, &["--steps", "12"]);
    completed(&output);
    assert!(
        words(&output).contains("checkpoint-00000009.h5: it is a checkpoint of another run"),
        "{}",
        words(&output)
    );
    assert!(out.join("checkpoint-00000009.h5.damaged").exists() && summary().contains("of another run"));
    assert_eq!(ok(vtkhdf::Reader::open(&out.join("particles.vtkhdf"))).frames(), 2);
    let rows = ok(std::fs::read_to_string(out.join("history.csv")));
    ok(std::fs::write(out.join("history.csv"), rows.replacen("left,", "right,", 1)));
    let output = restart(&out, &["--steps", "15"]);
    completed(&output);
    assert!(words(&output).contains("not those that this run has written"), "{}", words(&output));
    let output = restart(&out, &["--steps", "16"]);
    completed(&output);
    assert!(!words(&output).contains("warning: /"), "it was told: {}", words(&output));
    assert!(summary().contains("not those that this run has written"));
}
