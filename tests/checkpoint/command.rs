//! Runs of the command go on, and their files with them.
use crate::*;

/// A run of the two spheres with a checkpoint after every step.
fn run(out: &Path, steps: &str, more: &[&str]) -> Output {
    let every =
        ["--set", "output.checkpoint.steps=1", "--set", "output.frames=200", "--set", "domain.cell=4 mm"];
    let begin = ["run", "problems/two-spheres", "-q", "--steps", steps, "--out", text(out)];
    sinew(&[&begin[..], &every, more].concat())
}

/// The summary without what a clock says.
pub fn timeless(folder: &Path) -> Summary {
    let mut summary = ok(Summary::read(&folder.join("summary.json")));
    (summary.wall_s, summary.updates_per_s, summary.updates_per_s_per_core) = (0.0, 0.0, 0.0);
    summary.timing.clear();
    (summary.threads, summary.patches) = (0, [0; 3]);
    let ours = ["run", "warnings", "stepping_s", "memory_bytes", "peak_bytes", "balance"];
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
    // a load that grows: no two means are equal
    let gravity = "load.gravity=[[0, 0, 0, 0], [1, 0, 0, -1e4]]";
    let rows = ["--set", "output.frames=20", "--set", "output.history-every=10", "--set", gravity];
    assert!(run(&whole, "30", &rows).status.success());
    // the row and the frame of the end are not those of a run that goes on, and the next row has the means of all ten steps
    assert!(run(&parts, "12", &[&["--patches", "2x1x1"], &rows[..]].concat()).status.success());
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
    ok(std::fs::write(parts.join("particles/000003.h5"), b"nothing"));
    ok(std::fs::write(&particles, b"nothing"));
    ok(std::fs::remove_file(parts.join("history.csv")));
    let more = ["--steps", "15", "--set", "output.frames=100", "--set", "output.history-every=2"];
    let output = sinew(&[&["run", "--restart", text(&parts)], &more[..]].concat());
    let said = words(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("history.csv is missing") && said.contains("made anew of its frames"), "{said}");
    let reader = ok(sinew::output::vtkhdf::Reader::open(&particles));
    let steps: Vec<_> = (0..reader.frames()).map(|k| ok(reader.frame(k)).step).collect();
    assert!(
        steps.is_sorted() && !steps.contains(&3) && steps.contains(&4) && steps.contains(&15),
        "{steps:?}"
    );
    // rows that are lost are told, too
    let history = parts.join("history.csv");
    let rows = ok(std::fs::read_to_string(&history));
    ok(std::fs::write(&history, &rows[..rows.len() / 2]));
    let again = sinew(&["run", "--restart", text(&parts), "--steps", "16", "-q"]);
    assert!(again.status.success() && words(&again).contains("rows are missing"), "{}", words(&again));
    let output = sinew(&["run", "--restart", text(&parts), "--steps", "20", "-q"]);
    assert!(output.status.success(), "{}", words(&output));
    assert!(ok(sinew::output::vtkhdf::Reader::open(&particles)).frames() > steps.len());
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
    assert!(words(&output).contains("there is no folder"), "{}", words(&output));
    ok(std::fs::create_dir(&none));
    let output = sinew(&["run", "--restart", text(&none)]);
    assert_eq!(output.status.code(), Some(2));
    assert!(words(&output).contains("holds no checkpoint"), "{}", words(&output));
    assert_eq!(ok(std::fs::read_dir(&none)).count(), 0);
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
    let script = format!("ulimit -f {most}; exec \"$0\" run --restart \"$1\" --steps 9 -q");
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

/// The frame is written beside the steps: what becomes of it is told with the next one, or the checkpoint that counts it.
#[test]
fn a_full_disk_for_a_frame_ends_the_run_and_frames_before_stay() {
    let folder = folder();
    let [out, whole] = ["run", "whole"].map(|name| folder.path().join(name));
    assert!(run(&out, "5", &[]).status.success());
    let frames = |out: &Path| {
        let reader = ok(sinew::output::vtkhdf::Reader::open(&out.join("particles.vtkhdf")));
        (0..reader.frames()).map(|k| ok(reader.frame(k))).collect::<Vec<_>>()
    };
    let before = frames(&out);
    // room for rows of the history, and less than a frame asks for first
    let script = "ulimit -f 100; exec \"$0\" run --restart \"$1\" --steps 9 -q";
    let binary = assert_cmd::cargo::cargo_bin!("sinew");
    let output = ok(Command::new("bash").args(["-c", script]).arg(binary).arg(&out).output());
    let said = words(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let facts = ["cannot write", "/particles/0000", ".h5.part", "free some space"];
    assert!(facts.iter().all(|fact| said.contains(fact)), "{said}");
    assert!(ok(std::fs::read_to_string(out.join("summary.json"))).contains("failed"));
    assert!(before.len() > 2 && frames(&out) == before);
    let left = ok(std::fs::read_dir(out.join("particles"))).map(|entry| ok(entry).file_name());
    assert!(left.into_iter().all(|name| !name.to_string_lossy().ends_with(".part")), "nothing half is left");
    let output = sinew(&["run", "--restart", text(&out), "--steps", "9", "-q"]);
    assert!(output.status.success(), "{}", words(&output));
    assert!(run(&whole, "9", &[]).status.success());
    same_results(&whole, &out);
}

/// Kills the command at random moments, again and again, until the run is done. `SINEW_TEST_KILLS` sets how often at least.
#[test]
fn a_run_that_is_killed_at_any_moment_goes_on() {
    let least = kills(15);
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
        same_results(&whole, &parts);
    }
    println!("killed {kills} times in {rounds} runs");
}
