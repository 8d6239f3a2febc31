//! How a run ends, and goes further.
use crate::*;
use sinew::output::summary::{Status, Summary};

fn summary(folder: &Path) -> Summary {
    ok(Summary::read(&folder.join("summary.json")))
}

#[test]
fn a_completed_run_is_complete_and_can_go_further() {
    let folder = temporary();
    let [whole, parts] = ["whole", "parts"].map(|name| folder.path().join(name));
    // by steps no step is cut short: the parts are the whole
    completed(&ok(run(&["-q", "--steps", "20", "--out"]).arg(&whole).output()));
    completed(&ok(run(&["-q", "--steps", "11", "--out"]).arg(&parts).output()));
    assert_eq!(checkpoint::list(&parts), [checkpoint::path(&parts, 11)]);
    let before = contents(&parts);
    let again = restart(&parts, &[]);
    completed(&again);
    assert!(
        words(&again).contains("is complete: 11 steps")
            && words(&again).contains("run.steps (--steps) ends it"),
        "{}",
        words(&again)
    );
    assert_eq!(contents(&parts), before);
    completed(&restart(&parts, &["--steps", "20"]));
    assert_eq!(summary(&parts).state_hash, summary(&whole).state_hash);
    // by time the last step is: that is said
    let cut = folder.path().join("cut");
    completed(&ok(run(&["-q", "--until", "0.3 ms", "--out"]).arg(&cut).output()));
    let further = restart(&cut, &["--until", "0.5 ms"]);
    completed(&further);
    assert!(words(&further).contains("warning: the last step before was cut short"), "{}", words(&further));
    assert!((summary(&cut).time_s - 0.5e-3).abs() < 1e-15);
    // a killed run that had come to its end, and not said so, says it
    ok(std::fs::remove_file(cut.join("summary.json")));
    completed(&restart(&cut, &[]));
    assert_eq!(summary(&cut).status, Status::Completed);
    // sweeps need none
    let without = folder.path().join("without");
    let more = ["-q", "--steps", "3", "--set", "output.checkpoint.final=false", "--out"];
    completed(&ok(run(&more).arg(&without).output()));
    assert!(checkpoint::list(&without).is_empty());
}

#[test]
fn a_run_stops_before_its_time_is_over() {
    let folder = temporary();
    let [out, whole] = ["run", "whole"].map(|name| folder.path().join(name));
    let began = Instant::now();
    let slow = ["-q", "--set", "run.cfl=1e-3", "--wall", "2 s", "--out"];
    let output = ok(run(&slow).arg(&out).output());
    assert_eq!(output.status.code(), Some(124), "{}", words(&output));
    assert!(words(&output).contains("out of time (--wall)"), "{}", words(&output));
    assert!(began.elapsed() < Duration::from_secs(30));
    let stopped = summary(&out);
    assert_eq!(
        (stopped.status, checkpoint::list(&out)[0].clone()),
        (Status::Interrupted, checkpoint::path(&out, stopped.steps))
    );
    let steps = (stopped.steps + 5).to_string();
    completed(&restart(&out, &["--steps", &steps]));
    completed(&ok(run(&["-q", "--set", "run.cfl=1e-3", "--steps", &steps, "--out"]).arg(&whole).output()));
    assert_eq!(summary(&out).state_hash, summary(&whole).state_hash);
    for (wall, fact) in [("0 s", "must be above 0"), ("23", "without a unit"), ("5 m", "unit of a length")] {
        let output = ok(run(&["--wall", wall, "--out"]).arg(folder.path().join("none")).output());
        refused(&output, &[fact]);
    }
    assert!(!folder.path().join("none").exists());
}

#[test]
fn what_becomes_of_particles_that_leave_may_be_decided_anew() {
    let folder = temporary();
    let out = folder.path().join("run");
    // two balls fly apart, out of the domain
    let apart =
        ["--set", "body.left ball.velocity=[-20, 0, 0]", "--set", "body.right ball.velocity=[20, 0, 0]"];
    let more = ["-q", "--set", "run.leaving=error", "--out"];
    let output = ok(run(&[&apart[..], &more].concat()).arg(&out).output());
    assert_eq!(output.status.code(), Some(1), "{}", words(&output));
    // it has asked for no checkpoint, and leaves one of shortly before
    let (failed, last) = (summary(&out), checkpoint::list(&out));
    assert!(
        words(&output).contains("left the domain")
            && words(&output).contains("last checkpoint before is of step"),
        "{}",
        words(&output)
    );
    assert_eq!((failed.status, last.len()), (Status::Failed, 1));
    println!("failed in step {}, kept {}", failed.steps + 1, last[0].display());
    refused(&restart(&out, &["--set", "run.leaving=reflect"]), &["run.leaving is \"reflect\" here"]);
    completed(&restart(&out, &["--set", "run.leaving=delete"]));
    assert!(summary(&out).deleted_particles > 0);
    let whole = folder.path().join("whole");
    let more = ["-q", "--set", "run.leaving=delete", "--out"];
    completed(&ok(run(&[&apart[..], &more].concat()).arg(&whole).output()));
    assert_eq!(summary(&whole).state_hash, summary(&out).state_hash);
}
