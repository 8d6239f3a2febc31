//! One run, one folder.
use crate::*;
use sinew::output::claim::Claim;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;

#[test]
fn a_second_process_is_refused_before_it_changes_a_byte() {
    let folder = temporary();
    let out = folder.path().join("run");
    completed(&ok(run(&["-q", "--steps", "6", "--set", "output.checkpoint.steps=3", "--out"])
        .arg(&out)
        .output()));
    let claim = ok(Claim::take(&out));
    let before = contents(&out);
    let mine = std::process::id().to_string();
    refused(
        &ok(run(&["-q", "--force", "--out"]).arg(&out).output()),
        &["another run is writing", &mine, "--out"],
    );
    refused(&restart(&out, &["--steps", "9"]), &["another run is writing", &mine]);
    assert_eq!(contents(&out), before);
    drop(claim);
    completed(&restart(&out, &["--steps", "9"]));
    assert!(!out.join("run.lock").exists());
}

#[test]
fn of_many_that_start_at_once_one_has_the_folder() {
    let folder = temporary();
    let out = folder.path().join("run");
    for round in 0..3 {
        let start = |_| {
            let mut command = run(&["-q", "--steps", "200", "--out"]);
            ok(command.arg(&out).stdout(Stdio::null()).stderr(Stdio::piped()).spawn())
        };
        let children: Vec<_> = (0..5).map(start).collect();
        let outputs: Vec<_> = children.into_iter().map(|child| ok(child.wait_with_output())).collect();
        let won = outputs.iter().filter(|output| output.status.success()).count();
        assert_eq!(won, 1, "round {round}: {:?}", outputs.iter().map(words).collect::<Vec<_>>());
        for loser in outputs.iter().filter(|output| !output.status.success()) {
            let said = words(loser);
            assert!(
                said.contains("another run is writing") || said.contains("already holds a run"),
                "{said}"
            );
        }
        ok(std::fs::remove_dir_all(&out));
    }
    // without a name each finds a folder of its own
    let start =
        |_| ok(run(&["-q", "--steps", "20"]).current_dir(folder.path()).stdout(Stdio::null()).spawn());
    let children: Vec<_> = (0..4).map(start).collect();
    children.into_iter().for_each(|mut child| assert!(ok(child.wait()).success()));
    let names = ["two-spheres", "two-spheres-2", "two-spheres-3", "two-spheres-4"];
    assert!(names.iter().all(|name| folder.path().join("runs").join(name).join("summary.json").exists()));
}

#[test]
fn the_folder_of_a_run_that_was_killed_is_free() {
    let folder = temporary();
    let out = folder.path().join("run");
    let mut child = endless(&out);
    refused(&restart(&out, &["--steps", "30"]), &["another run is writing", &child.id().to_string()]);
    refused(&ok(run(&["--force", "--out"]).arg(&out).output()), &[&child.id().to_string()]);
    ok(child.kill());
    // not yet waited for, it is dead all the same
    until(|| restart(&out, &["--steps", "30"]).status.success());
    ok(child.wait());
    assert!(!out.join("run.lock").exists());
    completed(&ok(run(&["-q", "--force", "--steps", "3", "--out"]).arg(&out).output()));
}

#[test]
fn nothing_is_written_through_links() {
    let folder = temporary();
    let [out, other] = ["run", "other"].map(|name| folder.path().join(name));
    ok(std::fs::create_dir_all(&other));
    ok(std::fs::create_dir_all(other.join("particles")));
    ok(std::fs::write(other.join("particles/000000.h5"), b"mine"));
    ok(std::fs::write(other.join("letter"), b"mine"));
    let before = contents(&other);
    ok(std::fs::create_dir_all(&out));
    let link = |name: &str, to: &str| ok(symlink(other.join(to), out.join(name)));
    let files =
        ["history.csv", "summary.json", "particles.vtkhdf", "scene.toml", "trace.json", "section.png"];
    for name in files {
        link(name, "letter");
        // where a link points to nothing, writing through it would make a file there
        link(&format!("{name}.part"), "nothing");
    }
    link("checkpoint-00000003.h5.part", "nothing");
    link("run.lock.part", "nothing");
    link("particles", "particles");
    let arguments =
        ["-q", "--force", "--trace", "--steps", "3", "--set", "output.checkpoint.steps=3", "--out"];
    completed(&ok(run(&arguments).arg(&out).output()));
    link("plot.svg", "letter");
    completed(&sinew(&["plot", text(&out), "--y", "time_s"]));
    assert_eq!(contents(&other), before);
    assert!(!contents(&out).is_empty() && out.join("particles").is_dir());
    assert!(files.iter().all(|name| out.join(name).is_file() && !out.join(name).is_symlink()));
    // a run that goes on: what others have under the same names stays as it was
    let copy = folder.path().join("copy");
    assert!(ok(Command::new("cp").arg("-al").args([&out, &copy]).status()).success());
    let frozen = contents(&copy);
    completed(&restart(&out, &["--steps", "6"]));
    assert_eq!(
        contents(&copy).into_iter().map(|(_, bytes)| bytes).collect::<Vec<_>>(),
        frozen.into_iter().map(|(_, bytes)| bytes).collect::<Vec<_>>()
    );
    ok(std::fs::rename(out.join("particles"), folder.path().join("moved")));
    ok(symlink(folder.path().join("moved"), out.join("particles")));
    let before = contents(&out);
    refused(&restart(&out, &["--steps", "9"]), &["link to another folder"]);
    assert_eq!(contents(&out), before);
}

#[test]
fn the_folder_of_a_scene_is_never_one_of_results() {
    let folder = temporary();
    let [mine, theirs, link] = ["mine", "theirs", "link"].map(|name| folder.path().join(name));
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/two-spheres/scene.toml");
    for folder in [&mine, &theirs] {
        ok(std::fs::create_dir(folder));
        ok(std::fs::copy(&scene, folder.join("scene.toml")));
    }
    ok(symlink(&mine, &link));
    let run = |scene: &Path, out: &Path, more: &[&str]| {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
        let command = command.arg("run").arg(scene).args(["-q", "--steps", "1", "--out"]).arg(out).args(more);
        ok(command.current_dir(folder.path()).output())
    };
    let before = contents(folder.path());
    for more in [&[][..], &["--force"]] {
        for out in [&mine, &link, Path::new("mine"), Path::new("./theirs/../mine/")] {
            refused(&run(&mine, out, more), &["is the folder of the scene", "--out"]);
            refused(&run(&mine.join("scene.toml"), out, more), &["is the folder of the scene"]);
        }
        refused(&run(&mine, &theirs, more), &["a scene.toml that no run has left there"]);
    }
    assert_eq!(contents(folder.path()), before);
}

#[test]
fn paths_are_bytes() {
    let folder = temporary();
    let name = |bytes: &[u8]| folder.path().join(std::ffi::OsStr::from_bytes(bytes));
    let [one, other] = [name(b"run-\xff"), name(b"run-\xfe")];
    for (out, steps) in [(&one, "3"), (&other, "4")] {
        let arguments = ["-q", "--steps", steps, "--set", "output.checkpoint.steps=1", "--out"];
        completed(&ok(run(&arguments).arg(out).output()));
    }
    for (out, steps) in [(&one, 3), (&other, 4)] {
        assert!(out.join(format!("checkpoint-0000000{steps}.h5")).exists());
        completed(&restart(out, &["--steps", "9"]));
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
        completed(&ok(command.arg("picture").arg(out).output()));
    }
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
    completed(&ok(command.arg("compare").args([&one, &other]).output()));
}
