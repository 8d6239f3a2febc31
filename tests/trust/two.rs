//! Two processes in one folder, in random order.
use crate::splitmix::Random;
use crate::*;

const STEPS: [&str; 8] = [
    "--steps",
    "40",
    "--set",
    "output.checkpoint.steps=1",
    "--set",
    "output.frames=200",
    "--set",
    "output.history-every=3",
];

/// Begins anew, with or without `--force`, or goes on.
fn start(out: &Path, random: &mut Random) -> Child {
    let mut command = match (4.0 * random.unit()) as u8 {
        0 => run(&["-q", "--force"]),
        1 => run(&["-q"]),
        _ => Command::new(assert_cmd::cargo::cargo_bin!("sinew")),
    };
    match command.get_args().next().is_some() {
        true => command.args(STEPS).arg("--out"),
        false => command.args(["run", "-q", "--restart"]),
    };
    ok(command.arg(out).stdout(Stdio::null()).stderr(Stdio::piped()).spawn())
}

/// A process that ended by itself was done, or was refused.
#[track_caller]
fn ended_well(output: &Output) {
    let said = words(output);
    let refusals =
        ["another run is writing", "already holds a run", "holds no checkpoint", "there is no folder"];
    let refused = output.status.code() == Some(2) && refusals.iter().any(|refusal| said.contains(refusal));
    assert!(output.status.success() || refused, "{:?}: {said}", output.status);
}

/// Does something to one of two processes; whether that was to kill one that ran.
fn act(slot: &mut Option<Child>, out: &Path, random: &mut Random) -> bool {
    let Some(mut child) = slot.take() else {
        *slot = Some(start(out, random));
        return false;
    };
    let runs = ok(child.try_wait()).is_none();
    if runs && random.unit() < 0.5 {
        *slot = Some(child);
        return false;
    }
    // of no account where it has ended
    let _ = child.kill();
    let output = ok(child.wait_with_output());
    let killed = output.status.code().is_none();
    if !killed {
        ended_well(&output);
    }
    killed
}

/// Whatever happens, the folder is one run's, and goes on to the end that a run has that nobody disturbed.
/// `SINEW_TEST_KILLS` sets how often at least one is killed.
#[test]
fn two_processes_in_one_folder_leave_one_run() {
    let least = command::kills(23);
    let mut random = Random(std::process::id().into());
    let folder = temporary();
    let whole = folder.path().join("whole");
    completed(&ok(run(&["-q"]).args(STEPS).arg("--out").arg(&whole).output()));
    let history = |out: &Path| ok(std::fs::read_to_string(out.join("history.csv")));
    let (mut kills, mut rounds) = (0, 0);
    while kills < least {
        rounds += 1;
        let out = folder.path().join(format!("round-{rounds}"));
        let mut two = [None, None];
        for _ in 0..30 {
            let slot = &mut two[usize::from(random.unit() < 0.5)];
            kills += usize::from(act(slot, &out, &mut random));
            std::thread::sleep(Duration::from_micros((random.unit() * 60_000.0) as u64));
        }
        for child in two.into_iter().flatten() {
            ended_well(&ok(child.wait_with_output()));
        }
        let last = restart(&out, &[]);
        if !last.status.success() {
            ended_well(&last);
            completed(&ok(run(&["-q", "--force"]).args(STEPS).arg("--out").arg(&out).output()));
        }
        assert_eq!(history(&out), history(&whole));
        completed(&sinew(&["compare", text(&whole), text(&out)]));
        assert!(!out.join("run.lock").exists());
        ok(std::fs::remove_dir_all(&out));
    }
    println!("killed {kills} times in {rounds} rounds");
}
