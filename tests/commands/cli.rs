//! The command as a user meets it: exit statuses, messages, and nothing overwritten.

use crate::common::command::{ok, sinew, text, words};
use assert_cmd::Command;
use std::path::Path;
use std::process::Output;
use std::time::Duration;

fn short_run(out: &Path, more: &[&str]) -> Output {
    let out = out.to_str().expect("a plain path");
    let mut arguments = vec!["run", "problems/two-spheres", "--steps", "3", "--out", out];
    arguments.extend(more);
    sinew(&arguments)
}

#[test]
fn a_run_leaves_scene_summary_history_particles_and_pictures() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = short_run(folder.path(), &[]);
    assert!(output.status.success(), "{}", words(&output));
    for file in ["scene.toml", "summary.json", "history.csv", "particles.vtkhdf", "section.png"] {
        assert!(folder.path().join(file).is_file(), "{file} is missing");
    }
    let again = sinew(&[
        "run",
        folder.path().join("scene.toml").to_str().expect("a path"),
        "--steps",
        "3",
        "-q",
        "--out",
        folder.path().join("again").to_str().expect("a path"),
    ]);
    assert!(again.status.success(), "{}", words(&again));
    let hash = |dir: &Path| {
        let text = std::fs::read_to_string(dir.join("summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        summary["state_hash"].as_str().expect("a hash").to_owned()
    };
    assert_eq!(
        hash(folder.path()),
        hash(&folder.path().join("again")),
        "the resolved scene is the same scene"
    );
}

#[test]
fn a_folder_that_holds_a_run_is_not_overwritten_unless_forced() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert!(short_run(folder.path(), &["-q"]).status.success());
    let before = std::fs::read(folder.path().join("history.csv")).expect("a history");
    let refused = short_run(folder.path(), &["-q"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(words(&refused).contains("--force"), "{}", words(&refused));
    assert_eq!(before, std::fs::read(folder.path().join("history.csv")).expect("a history"));
    assert!(short_run(folder.path(), &["-q", "--force"]).status.success());
}

#[test]
fn an_unwritable_output_folder_is_bad_usage() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("file");
    std::fs::write(&file, b"not a folder").expect("a file");
    let output = short_run(&file.join("run"), &["-q"]);
    assert_eq!(output.status.code(), Some(2), "{}", words(&output));
    assert!(words(&output).contains("--out"), "{}", words(&output));
}

#[test]
fn a_bad_scene_points_at_the_line_and_exits_with_2() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = std::fs::read_to_string("problems/two-spheres/scene.toml").expect("the scene");
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, scene.replace("cfl = 0.4", "clf = 0.4")).expect("a file");
    for command in ["run", "check", "graph"] {
        let output = sinew(&[command, path.to_str().expect("a path")]);
        assert_eq!(output.status.code(), Some(2));
        let words = words(&output);
        assert!(words.contains("clf") && words.contains("cfl") && words.contains("scene.toml:"), "{words}");
    }
}

#[test]
fn more_patches_than_blocks_is_bad_usage() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = short_run(folder.path(), &["-q", "--patches", "1000x1x1"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(words(&output).contains("1000 patches along x"), "{}", words(&output));
}

#[test]
fn more_threads_than_can_be_is_bad_usage_wherever_they_are_asked_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    assert!(short_run(folder.path(), &["-q", "--set", "output.checkpoint.steps=3"]).status.success());
    let run = folder.path().to_str().expect("a plain path");
    let shots: [&[&str]; 5] = [
        &["run", "problems/two-spheres", "-q", "--force", "--out", run],
        &["run", "--restart", run, "-q"],
        &["check", "problems/two-spheres", "--validate-only"],
        &["graph", "problems/two-spheres"],
        &["bench", "problems/two-spheres", "-q"],
    ];
    for shot in shots {
        for asked in [&["--threads", "1000000"][..], &["--set", "run.threads=1000000"]] {
            if shot[0] == "bench" && asked[0] == "--threads" {
                // the option is what counts, and what is checked
                let both = [shot, asked, &["--set", "run.threads=2"]].concat();
                refuses_a_million_threads(&both);
            }
            refuses_a_million_threads(&[shot, asked].concat());
        }
    }
    // a run of a larger machine can still be looked at
    let scene = folder.path().join("scene.toml");
    let text = std::fs::read_to_string(&scene).expect("a scene");
    std::fs::write(&scene, text.replace("[run]", "[run]\nthreads = 1000000")).expect("a file");
    let output = sinew(&["picture", run]);
    assert!(output.status.success(), "{}", words(&output));
}

#[track_caller]
fn refuses_a_million_threads(arguments: &[&str]) {
    let mut command = Command::cargo_bin("sinew").expect("the command is built");
    let output = command.args(arguments).timeout(Duration::from_secs(60)).output().expect("an end");
    let said = words(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    let cores = format!("may use {} core", sinew::simulation::available_threads());
    for fact in ["`run.threads` is 1000000", cores.as_str()] {
        assert!(said.contains(fact), "{arguments:?}: {said}");
    }
}

#[test]
fn a_collapsed_step_ends_the_run_with_1_and_a_summary() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = short_run(folder.path(), &["-q", "--set", "run.smallest-step=1"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(words(&output).contains("the time step collapsed"), "{}", words(&output));
    let summary = std::fs::read_to_string(folder.path().join("summary.json")).expect("a summary");
    assert!(summary.contains("\"status\": \"failed\""));
}

#[test]
fn the_graph_prints_in_every_form_and_says_why() {
    let graph = |more: &[&str]| sinew(&[&["graph", "problems/slab-quick"], more].concat());
    let text = graph(&["--ranks", "2"]);
    assert!(text.status.success());
    for word in [
        "Scatter",
        "messages a step",
        "0 -> 1: 4 messages",
        "critical path of a step",
        "estimated",
        "loop until StepOver, once",
    ] {
        assert!(words(&text).contains(word), "{}", words(&text));
    }
    assert!(words(&graph(&["--format", "dot"])).starts_with("digraph"));
    let json: serde_json::Value =
        serde_json::from_slice(&graph(&["--format", "json", "--expanded", "--patches", "2x1x2"]).stdout)
            .expect("valid JSON");
    assert!(json["tasks"].as_array().is_some_and(|tasks| tasks.len() > 20));
    assert!(json["items"].as_array().is_some_and(|items| items.len() > 40));
    for form in ["svg", "html"] {
        let picture = graph(&["--format", form, "--patches", "2x1x2", "--ranks", "2", "--rank", "1"]);
        assert!(
            picture.status.success() && String::from_utf8_lossy(&picture.stdout).contains("<svg"),
            "{form}"
        );
    }
    for (what, word) in [
        ("Contact", "line"),
        ("Gather", "Particles read velocity"),
        ("NodeSums", "Computes by Scatter"),
        ("Gather:Stress", "VelocityGradient"),
    ] {
        assert!(words(&graph(&["--why", what])).contains(word), "{what}");
    }
    let check = graph(&["--check"]);
    assert!(check.status.success());
    for word in ["38 tasks on 1 patch: no race", "1 graph, 1 loop: each label that is read was left"] {
        assert!(words(&check).contains(word), "{}", words(&check));
    }
    for wrong in [
        &["--why", "Nonsense"][..],
        &["--why", "Stress:Weights:x"],
        &["--ranks", "0"],
        &["--ranks", "18446744073709551615"],
        &["--ranks", "3", "--patches", "1x1x2"],
        &["--patch", "1"],
        &["--rank", "5", "--ranks", "2"],
        &["--trace", "no-such-file"],
    ] {
        assert_eq!(graph(wrong).status.code(), Some(2), "{wrong:?}");
    }
}

#[test]
fn shells_and_manuals_know_every_subcommand() {
    let folder = ok(tempfile::tempdir());
    let said = String::from_utf8_lossy(&sinew(&["completions", "bash"]).stdout).into_owned();
    let pages = sinew(&["man", text(folder.path())]);
    assert!(pages.status.success(), "{}", words(&pages));
    for command in ["run", "graph", "export", "scene-docs"] {
        assert!(
            said.contains(&format!("sinew__{}", command.replace('-', "__"))) || said.contains(command),
            "{command}"
        );
        let page = ok(std::fs::read_to_string(folder.path().join(format!("sinew-{command}.1"))));
        assert!(page.contains(".SH SYNOPSIS"), "{page}");
    }
}

#[test]
fn a_graph_takes_no_times_of_another_scene() {
    let folder = ok(tempfile::tempdir());
    let (out, trace) = (folder.path().join("run"), folder.path().join("run/trace.json"));
    let short = ["--steps", "2", "--set", "domain.cell=4 mm", "-q", "--trace", "--threads", "1"];
    let ran = sinew(&[&["run", "problems/two-spheres", "--out", text(&out)], &short[..]].concat());
    assert!(ran.status.success(), "{}", words(&ran));
    let graph = |scene: &str| sinew(&["graph", scene, "--trace", text(&trace)]);
    // the scene that ran lies beside the trace
    let own = graph(text(&out.join("scene.toml")));
    assert!(own.status.success(), "{}", words(&own));
    let other = graph("problems/two-spheres");
    assert_eq!(other.status.code(), Some(2));
    assert!(words(&other).contains("is the trace of another scene than"), "{}", words(&other));
}

#[test]
fn a_wound_is_not_measured_where_failure_is_not_shown() {
    let folder = ok(tempfile::tempdir());
    let out = folder.path().join("run");
    let short = ["--steps", "2", "--set", "domain.cell=3 mm", "-q", "--threads", "1"];
    let fields = ["--set", "output.fields=[\"mass\"]"];
    let ran = sinew(&[&["run", "problems/slab-quick", "--out", text(&out)], &short[..], &fields].concat());
    assert!(ran.status.success() && words(&ran).contains("do not show `failure`"), "{}", words(&ran));
    assert!(out.join("section.png").exists(), "pictures are drawn in any case");
    let wound = sinew(&["wound", text(&out)]);
    assert!(wound.status.code() == Some(2) && words(&wound).contains("output.fields"), "{}", words(&wound));
}

#[test]
fn the_graph_s_estimates_take_the_pace_of_this_machine() {
    let said = |arguments: &[&str]| {
        let output = sinew(&[&["graph"][..], arguments].concat());
        (output.status.code(), words(&output))
    };
    let plain = said(&["problems/slab-quick"]);
    let measured = said(&["problems/slab-quick", "--measure"]);
    assert!(plain.0 == Some(0) && plain.1.contains("0.12 ns a particle"), "{plain:?}");
    assert!(measured.0 == Some(0) && measured.1.contains("took on one thread here"), "{measured:?}");
    let rounds = said(&["problems/slab-rigid", "--measure"]);
    let rates = said(&["problems/slab-quick", "--measure", "--set", "run.rates=per-material"]);
    for refused in [rounds, rates] {
        assert!(refused.0 == Some(2) && refused.1.contains("take a trace instead"), "{refused:?}");
    }
}

#[test]
fn check_predicts_without_running() {
    let output = sinew(&["check", "problems/slab-quick"]);
    let words = words(&output);
    let more = [
        "21 frames (at most one a step) of up to",
        "thinnest slab: 6.0 cells across",
        "displacement, velocity",
    ];
    for word in ["27648 particles", "memory", "wall time", "steps"].into_iter().chain(more) {
        assert!(words.contains(word), "{words}");
    }
    let free = sinew(&["check", "problems/slab-quick", "--validate-only", "--set", "contact=[]"]);
    assert!(
        self::words(&free).contains("no contact tissue and lead pass through each other"),
        "{}",
        self::words(&free)
    );
    let early =
        ["body.bullet.velocity=[0, \"-300 m/s\", 0]", "run.until=1 ms"].map(|set| ["--set", set]).concat();
    let early = sinew(&[&["check", "problems/slab-quick", "--validate-only"], &early[..]].concat());
    assert!(
        self::words(&early).contains("unhindered it reaches the end of the domain after"),
        "{}",
        self::words(&early)
    );
    let tool = sinew(&["check", "problems/hertz", "--validate-only"]);
    assert!(self::words(&tool).contains("sphere: a shape without particles"), "a tool");
}

#[test]
fn a_bench_writes_json_that_it_compares_with() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("bench.json");
    let file = file.to_str().expect("a plain path");
    let bench = ["bench", "problems/slab-quick", "--steps", "1", "--repeat", "1", "-q", "--at"];
    let first = sinew(&[&bench[..], &["0", "--json", file]].concat());
    assert!(first.status.success() && first.stderr.is_empty(), "{}", words(&first));
    let again = sinew(&[&bench[..], &["1 us", "--against", file]].concat());
    let words = words(&again);
    for word in ["Gather", "G2P tissue.Gather.one_thread_ns", "differs: state: slab-quick at 0.00"] {
        assert!(words.contains(word), "{words}");
    }
    for (wrong, remedy) in [
        (["--at", "9 s"], "choose a time between"),
        (["--at", "soon"], "write a time"),
        (["--against", "no-such-file"], "sinew bench --json"),
        (["--steps", "0"], "at least one step"),
        (["--steps", "18446744073709551615"], "18446744073709551615 steps were measured"),
    ] {
        let soon = ["--set", "run.until=2 us"];
        let output = sinew(&[&["bench", "problems/slab-quick", "-q"], &soon[..], &wrong].concat());
        assert_eq!(output.status.code(), Some(2), "{wrong:?}");
        assert!(self::words(&output).contains(remedy), "{}", self::words(&output));
    }
}

#[test]
fn every_subcommand_has_help() {
    for command in ["run", "check", "graph", "wound", "picture", "compare", "bench", "scene-docs"] {
        let output = sinew(&[command, "--help"]);
        assert!(output.status.success() && words(&output).contains("Usage"), "{command}");
    }
    assert_eq!(sinew(&["no-such-command"]).status.code(), Some(2));
}

#[test]
fn a_second_run_without_out_goes_to_a_folder_of_its_own() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems/two-spheres");
    for _ in 0..2 {
        let mut command = Command::cargo_bin("sinew").expect("the command is built");
        let arguments = ["--steps", "2", "-q", "--set", "output.frames=0"];
        command.current_dir(folder.path()).arg("run").arg(&scene).args(arguments).assert().success();
    }
    for name in ["two-spheres", "two-spheres-2"] {
        assert!(folder.path().join("runs").join(name).join("summary.json").is_file(), "{name}");
    }
}

#[test]
fn output_that_nobody_reads_ends_without_a_word() {
    let sinew = assert_cmd::cargo::cargo_bin!("sinew");
    let script = format!(
        "{} scene-docs | head -1; {} graph problems/slab --format json | head -1",
        sinew.display(),
        sinew.display()
    );
    let output = std::process::Command::new("sh").args(["-c", &script]).output().expect("a shell");
    assert!(output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_launcher_that_starts_other_ranks_is_told_in_its_row() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().to_str().expect("a name");
    let measure = ["--launcher", "env", "--ranks", "2", "--patches", "2", "--threads", "1", "--measure-only"];
    let steps = ["--steps", "1", "--warm-up", "0", "--repeat", "1", "-q", "--out", out];
    let output = sinew(&[&["scale", "problems/two-spheres"], &measure[..], &steps[..]].concat());
    let csv = std::fs::read_to_string(folder.path().join("measured.csv")).expect("a table");
    assert!(csv.contains("started 1 ranks: give another --launcher"), "{csv}{}", words(&output));
}

#[test]
fn there_is_no_such_patch_or_rank() {
    for (option, told) in
        [("--patch", "no patch 9: there are patches 0 to 0"), ("--rank", "no rank 9: there are ranks 0")]
    {
        let output = sinew(&["graph", "problems/two-spheres", option, "9"]);
        assert_eq!(output.status.code(), Some(2));
        assert!(words(&output).contains(told), "{}", words(&output));
    }
}

#[test]
fn scaling_of_what_is_found_in_rounds_is_measured_and_not_foreseen() {
    let output = sinew(&["scale", "problems/slab-rigid", "--quiet"]);
    assert_eq!(output.status.code(), Some(2));
    let said = words(&output);
    assert!(said.contains("found in rounds") && said.contains("--measure-only"), "{said}");
}
