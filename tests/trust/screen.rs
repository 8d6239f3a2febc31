//! No screen ends a run.
use crate::*;
use sinew::output::summary::{Status, Summary};
use std::fs::File;
use std::io::Read;

fn finished(out: &Path) -> bool {
    Summary::read(&out.join("summary.json")).is_ok_and(|summary| summary.status == Status::Completed)
}

/// `sh -c SCRIPT`, in which "$@" is a run into `out`.
fn shell(script: &str, out: &Path, arguments: &[&str]) -> Command {
    let run = run(&[arguments, &["--out", text(out)]].concat());
    let mut command = Command::new("sh");
    command.args(["-c", script, "sh"]).arg(run.get_program()).args(run.get_args());
    command
}

#[test]
fn a_screen_that_is_lost_ends_no_run() {
    let folder = temporary();
    for (number, script) in [
        "exec \"$@\" >&- 2>&-",
        "exec \"$@\" >/dev/full 2>/dev/full",
        "{ \"$@\"; echo $? >&3; } 3>\"$STATUS\" 2>&1 | true",
        "{ \"$@\" 2>&1; echo $? >&3; } 3>\"$STATUS\" | head -c 1",
    ]
    .into_iter()
    .enumerate()
    {
        let [out, status] = ["run", "status"].map(|name| folder.path().join(format!("{name}-{number}")));
        let output = ok(shell(script, &out, &["--steps", "100"]).env("STATUS", &status).output());
        assert!(finished(&out), "{script}: {}", words(&output));
        assert!(output.status.success(), "{script}: {}", output.status);
        let status = std::fs::read_to_string(&status).unwrap_or("0\n".into());
        assert_eq!(status, "0\n", "{script}");
    }
    // a run that fails says so in its status
    let out = folder.path().join("fails");
    let output =
        ok(shell("exec \"$@\" >/dev/full 2>/dev/full", &out, &["--set", "run.smallest-step=1"]).output());
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn output_that_cannot_be_written_is_an_error_of_the_commands_whose_purpose_it_is() {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
    command.args(["scene-docs"]).stdout(ok(File::options().write(true).open("/dev/full")));
    let output = ok(command.stderr(Stdio::piped()).output());
    assert_eq!(output.status.code(), Some(1), "{}", words(&output));
    assert!(words(&output).contains("cannot write to the standard output"), "{}", words(&output));
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
    let mut child = ok(command.args(["scene-docs"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn());
    let mut some = [0; 10];
    ok(child.stdout.take().expect("a pipe").read_exact(&mut some));
    let output = ok(child.wait_with_output());
    assert!(words(&output).is_empty(), "{}", words(&output));
}

#[test]
fn a_hangup_ends_a_run_in_good_order_unless_it_was_to_be_ignored() {
    let folder = temporary();
    let signal = |name: &str, pid: u32| ok(Command::new("kill").args([name, &pid.to_string()]).status());
    let begun = |out: &Path| until(|| !checkpoint::list(out).is_empty());
    let arguments = ["-q", "--set", "run.cfl=1e-4", "--set", "output.checkpoint.steps=10"];
    for (signalled, status) in [("-HUP", 129), ("-INT", 130), ("-TERM", 143), ("-USR1", 138)] {
        let out = folder.path().join(format!("run{signalled}"));
        // whoever runs the tests may have them ignore signals
        let script = "exec env --default-signal=HUP --default-signal=INT \"$@\"";
        let mut child = ok(shell(script, &out, &arguments).stderr(Stdio::null()).spawn());
        begun(&out);
        signal(signalled, child.id());
        assert_eq!(ok(child.wait()).code(), Some(status), "{signalled}");
        completed(&restart(&out, &["--steps", "30"]));
    }
    let out = folder.path().join("nohup");
    let script = "trap '' HUP; exec \"$@\"";
    let mut child = ok(shell(script, &out, &[&arguments[..], &["--steps", "600"]].concat()).spawn());
    begun(&out);
    signal("-HUP", child.id());
    assert!(ok(child.wait()).success());
    assert!(finished(&out));
}
