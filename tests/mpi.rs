//! Ranks as processes under `mpirun`: the same bits, and an end for all when one fails. `SINEW_TEST_MPIRUN` names another
//! launcher, for example `mpirun.mpich`; `SINEW_TEST_KILLS` sets how often a run is killed.
#![cfg(feature = "mpi")]
mod common;

use common::Random;
use common::command::{kills, ok, text, words};
use sinew::output::checkpoint;
use sinew::output::summary::Summary;
use sinew::output::vtkhdf::Reader;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// `mpirun -n RANKS sinew ARGUMENTS`.
fn mpirun(ranks: usize, arguments: &[&str]) -> Command {
    let mut command = launcher(ranks);
    command.arg(assert_cmd::cargo::cargo_bin!("sinew")).args(arguments);
    command
}

/// `mpirun -n RANKS`, also as root and on fewer cores than ranks.
fn launcher(ranks: usize) -> Command {
    let launcher = std::env::var("SINEW_TEST_MPIRUN").unwrap_or("mpirun".into());
    let mut command = Command::new(launcher);
    command.args(["-n", &ranks.to_string()]);
    command.current_dir(env!("CARGO_MANIFEST_DIR")).stdin(Stdio::null());
    command.envs([
        ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
        ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
        ("OMPI_MCA_rmaps_base_oversubscribe", "1"),
        ("OMPI_MCA_hwloc_base_binding_policy", "none"),
    ]);
    command
}

#[track_caller]
fn run(ranks: usize, arguments: &[&str], out: &Path) -> Summary {
    let output = ok(mpirun(ranks, &[arguments, &["-q", "--out", text(out)]].concat()).output());
    assert!(output.status.success(), "{arguments:?} on {ranks} ranks: {}", words(&output));
    ok(Summary::read(&out.join("summary.json")))
}

/// Everything in a summary that does not depend on who ran it, and on the time it took.
fn result(summary: Summary) -> Summary {
    let mut summary = Summary {
        ranks: 0,
        threads: 0,
        patches: [0; 3],
        wall_s: 0.0,
        timing: Vec::new(),
        updates_per_s: 0.0,
        updates_per_s_per_core: 0.0,
        ..summary
    };
    summary.more.retain(|key, _| ["deleted_j", "ticks", "updates"].contains(&key.as_str()));
    summary
}

#[test]
fn a_shot_has_one_hash_on_all_ranks_threads_and_patches() {
    let folder = ok(tempfile::tempdir());
    // soft lead takes long steps, so that 60 of them reach the slab
    let shot = [
        "run",
        "problems/slab-quick",
        "--steps",
        "60",
        "--set",
        "material.lead.bulk-modulus=4.6 GPa",
        "--set",
        "material.lead.shear-modulus=0.56 GPa",
        "--set",
        "body.bullet.shape.sphere.center.1=4.6 mm",
        "--set",
        "run.rebalance-every=25",
    ];
    for rates in ["run.rates=common", "run.rates=per-material"] {
        let mut first = None;
        for (ranks, threads, patches) in [
            (1, "1", "1x1x1"),
            (1, "2", "2x2x2"),
            (2, "1", "2x1x1"),
            (2, "2", "3x2x1"),
            (3, "1", "2x2x2"),
            (4, "2", "4x1x2"),
            (8, "1", "2x2x2"),
            (8, "1", "3x2x4"),
        ] {
            let out = folder.path().join(format!("{rates}-{ranks}-{threads}-{patches}"));
            let layout = ["--threads", threads, "--patches", patches, "--set", rates];
            let summary = run(ranks, &[&shot[..], &layout].concat(), &out);
            assert_eq!((summary.ranks, summary.threads.to_string()), (ranks, threads.to_owned()));
            let result = result(summary);
            let wanted = first.get_or_insert(result.clone());
            assert_eq!(&result, wanted, "{ranks} ranks, {threads} threads, {patches} patches, {rates}");
        }
    }
}

#[test]
fn an_error_is_told_once_and_ends_all_ranks() {
    let folder = ok(tempfile::tempdir());
    let out = folder.path().join("run");
    let cases: [(&[&str], i32, &str); 5] = [
        (&["--set", "run.cflx=1"], 2, "did you mean `cfl`"),
        (&["--patches", "2x1x1"], 2, "3 ranks cannot share 2 patches"),
        (&["--patches", "99x1x1"], 2, "99 patches along x"),
        (&["--set", "run.smallest-step=1"], 1, "the time step collapsed"),
        (
            &["--set", "body.bullet.velocity=[0, 5000, 0]", "--set", "run.leaving=error"],
            1,
            "left the domain at",
        ),
    ];
    for (arguments, status, message) in cases {
        let began = Instant::now();
        let all = [&["run", "problems/slab-quick", "--steps", "2000", "-q"], arguments].concat();
        let output = ok(mpirun(3, &[&all[..], &["--force", "--out", text(&out)]].concat()).output());
        let said = words(&output);
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
        assert_eq!(said.matches(message).count(), 1, "{arguments:?}: {said}");
        assert!(began.elapsed() < Duration::from_secs(60), "{arguments:?} hangs");
    }
    // a folder that cannot be written, known to rank 0 alone
    let output = ok(mpirun(2, &["run", "problems/slab-quick", "-q", "--out", "/proc/nowhere"]).output());
    assert_eq!(output.status.code(), Some(2), "{}", words(&output));
    assert_eq!(words(&output).matches("cannot write to").count(), 1, "{}", words(&output));
}

/// Two ranks that were started differently: one message, and an end within seconds.
#[test]
fn ranks_that_disagree_are_told_so_once() {
    let folder = ok(tempfile::tempdir());
    let [out, other] = ["run", "other-build"].map(|name| folder.path().join(name));
    let sinew = assert_cmd::cargo::cargo_bin!("sinew");
    let mut build = ok(std::fs::read(sinew));
    build.push(0);
    ok(std::fs::write(&other, build));
    ok(std::fs::set_permissions(&other, ok(std::fs::metadata(sinew)).permissions()));
    let run = ["run", "problems/two-spheres", "-q", "--steps", "3", "--out", text(&out)];
    let changed = [&run[..], &["--set", "run.cfl=0.1"]].concat();
    let wrong = [&run[..], &["--no-such-option"]].concat();
    let check = ["check", "problems/two-spheres"];
    let (same, other) = (vec![text(sinew)], vec![text(&other)]);
    let told = vec!["env", "SINEW_ISA=baseline", text(sinew)];
    let mut cases = vec![
        (&same, &changed[..], &run[..], "was started as"),
        (&same, &check, &run, "was started as"),
        (&same, &run, &check, "was started as"),
        (&same, &wrong, &run, "was started as"),
        (&other, &run, &run, "another build"),
    ];
    if simd::Isa::available().len() > 1 {
        cases.push((&told, &run, &run, "SINEW_ISA=baseline"));
    }
    for (program, words, first, fact) in cases {
        let began = Instant::now();
        let mut command = launcher(1);
        command.arg(sinew).args(first).args([":", "-n", "1"]).args(program).args(words);
        let output = ok(command.output());
        let said = self::words(&output);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
        assert_eq!(said.matches(fact).count(), 1, "{words:?}: {said}");
        assert!(said.contains("rank 1") && !out.exists(), "{said}");
        assert!(began.elapsed() < Duration::from_secs(20), "{words:?} hangs");
    }
}

/// Rank 0 alone sees the scene and the folder of results.
#[test]
#[cfg(target_os = "linux")]
fn other_ranks_need_not_see_the_files() {
    let folder = ok(tempfile::tempdir());
    let [scene, out] = ["scene", "run"].map(|name| folder.path().join(name));
    ok(std::fs::create_dir(&scene));
    ok(std::fs::copy("problems/two-spheres/scene.toml", scene.join("scene.toml")));
    let begin = ["run", text(&scene), "--steps", "5", "--set", "domain.cell=4 mm"];
    let run = [&begin[..], &["-q", "--out", text(&out)]].concat();
    let mut command = launcher(1);
    // a root of its own, in which the folder is not there
    let hidden = format!("mount -t tmpfs none {} && exec \"$@\"", text(folder.path()));
    let sinew = assert_cmd::cargo::cargo_bin!("sinew");
    let can = Command::new("unshare").args(["-m", "true"]).status().is_ok_and(|status| status.success());
    if !can {
        return eprintln!("skipped: this user may not make a mount namespace");
    }
    command.arg(sinew).args(&run).args([":", "-n", "1", "unshare", "-m", "sh", "-c", &hidden, "sh"]);
    let output = ok(command.arg(sinew).args(run).output());
    assert!(output.status.success(), "{}", words(&output));
    let summary = ok(Summary::read(&out.join("summary.json")));
    assert_eq!(summary.steps, 5);
    // rank 0 has written the rows of both
    let frames = ok(Reader::open(&out.join("particles.vtkhdf")));
    assert_eq!([0, 1].map(|k| ok(frames.frame(k)).identities.len() as u64), [summary.particles; 2]);
    let mut names: Vec<_> =
        ok(std::fs::read_dir(out.join("particles"))).map(|it| ok(it).file_name()).collect();
    names.sort();
    assert_eq!(names, ["000000.h5", "000001.h5", "cells.h5"]);
    let alone = folder.path().join("alone");
    self::run(1, &begin, &alone);
    same(&alone, &out);
}

/// Bit for bit, by particle.
#[track_caller]
fn same(one: &Path, other: &Path) {
    let mut compare = Command::new(assert_cmd::cargo::cargo_bin!("sinew"));
    let output = ok(compare.args(["compare", text(one), text(other)]).output());
    assert!(output.status.success(), "{}", words(&output));
}

/// Stands before MPI and takes back what it grants to threads.
const FORBIDS_THREADS: &str = "int PMPI_Init_thread(int *, char ***, int, int *);\n\
    int MPI_Init_thread(int *n, char ***words, int wanted, int *granted) {\n\
    int error = PMPI_Init_thread(n, words, wanted, granted); *granted = 0; return error; }\n";

#[test]
#[cfg(target_os = "linux")]
fn an_mpi_that_knows_no_threads_gets_one_a_rank() {
    let folder = ok(tempfile::tempdir());
    let [source, library] = ["forbid.c", "forbid.so"].map(|name| folder.path().join(name));
    ok(std::fs::write(&source, FORBIDS_THREADS));
    let mut compiler = Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-o"]).args([&library, &source]);
    assert!(ok(compiler.status()).success());
    let preload = format!("LD_PRELOAD={}", text(&library));
    let out = folder.path().join("run");
    for (threads, status) in [("1", 0), ("2", 2)] {
        let mut command = launcher(2);
        command.args(["env", &preload]).arg(assert_cmd::cargo::cargo_bin!("sinew"));
        command.args(["run", "problems/two-spheres", "-q", "--force", "--steps", "3", "--out", text(&out)]);
        let output = ok(command.args(["--threads", threads]).output());
        let said = words(&output);
        assert_eq!(output.status.code(), Some(status), "{threads} threads: {said}");
        assert_eq!(
            said.matches("2 threads a rank need MPI_THREAD_FUNNELED").count(),
            usize::from(status != 0)
        );
    }
}

/// A run of two ranks that writes a checkpoint every step, or that goes on.
fn start(parts: &Path) -> Child {
    let any = !checkpoint::list(parts).is_empty();
    let arguments = match any {
        true => vec!["run", "--restart", text(parts), "-q"],
        false => vec![
            "run",
            "problems/two-spheres",
            "-q",
            "--steps",
            "60",
            "--out",
            text(parts),
            "--force",
            "--set",
            "output.checkpoint.steps=1",
            "--set",
            "output.frames=200",
        ],
    };
    // each time on another number of ranks
    let ranks = 2 + checkpoint::list(parts).len() % 2;
    ok(mpirun(ranks, &arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn())
}

/// The ranks whose parent, or grandparent, is `parent`; what its launcher has forked and not begun yet is none.
fn ranks_of(parent: u32) -> Vec<i32> {
    let parent_of = |pid: i32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        let (_, rest) = stat.rsplit_once(')')?;
        rest.split_whitespace().nth(1)?.parse::<i32>().ok()
    };
    let all = ok(std::fs::read_dir("/proc"));
    let pids = all.filter_map(|entry| entry.ok()?.file_name().to_str()?.parse::<i32>().ok());
    let mine = parent as i32;
    let begun = |pid: &i32| {
        let name = std::fs::read_to_string(format!("/proc/{pid}/comm"));
        name.is_ok_and(|name| name.trim() == "sinew")
    };
    let ranks = pids.filter(begun);
    ranks.filter(|&pid| parent_of(pid).is_some_and(|p| p == mine || parent_of(p) == Some(mine))).collect()
}

fn kill(pid: i32) {
    let _ = Command::new("kill").args(["-9", &pid.to_string()]).status();
}

fn wait(child: &mut Child, most: Duration) -> Option<std::process::ExitStatus> {
    let began = Instant::now();
    while began.elapsed() < most {
        if let Some(status) = ok(child.try_wait()) {
            return Some(status);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    None
}

/// After which a job hangs.
const LONG: Duration = Duration::from_secs(60);

/// Kills a rank or the whole job at random moments, also while a checkpoint is written, until the run is done.
#[test]
fn a_killed_rank_ends_the_run_and_a_restart_goes_on() {
    let least = kills(12);
    let mut random = Random(std::process::id().into());
    let folder = ok(tempfile::tempdir());
    let steps = ["run", "problems/two-spheres", "--steps", "60", "--set", "output.frames=200"];
    let (began, unharmed) = (Instant::now(), folder.path().join("whole"));
    let whole = result(run(2, &steps, &unharmed));
    let took = began.elapsed();
    let (mut kills, mut rounds) = (0, 0);
    while kills < least {
        rounds += 1;
        let parts = folder.path().join(format!("parts-{rounds}"));
        loop {
            let mut job = start(&parts);
            // of all the time that a run takes here, launcher and checkpoints included
            let moment = if kills < least { took.mul_f64(0.2 + 1.3 * random.unit()) } else { LONG };
            if let Some(status) = wait(&mut job, moment) {
                assert!(status.success(), "it ended by itself with {status}");
                break;
            }
            let ranks = ranks_of(job.id());
            let one = random.unit() < 0.6;
            match ranks.get((random.unit() * ranks.len() as f64) as usize) {
                Some(&rank) if one => kill(rank),
                _ => ranks.iter().chain([&(job.id() as i32)]).for_each(|&pid| kill(pid)),
            }
            let Some(status) = wait(&mut job, LONG) else {
                ranks.iter().chain([&(job.id() as i32)]).for_each(|&pid| kill(pid));
                panic!("the others go on {LONG:?} after a rank was killed")
            };
            if status.success() {
                // it was done before the blow
                break;
            }
            kills += 1;
        }
        assert_eq!(result(ok(Summary::read(&parts.join("summary.json")))), whole, "round {rounds}");
        same(&unharmed, &parts);
    }
    println!("killed {kills} times in {rounds} runs");
}

#[test]
fn a_signal_to_the_launcher_leaves_a_checkpoint() {
    let folder = ok(tempfile::tempdir());
    let out = folder.path().join("run");
    let mut job = ok(mpirun(2, &["run", "problems/slab-quick", "-q", "--out", text(&out)])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn());
    let began = Instant::now();
    while !out.join("history.csv").exists() && began.elapsed() < Duration::from_secs(30) {
        std::thread::sleep(Duration::from_millis(50));
    }
    std::thread::sleep(Duration::from_millis(500));
    let _ = Command::new("kill").args(["-USR1", &job.id().to_string()]).status();
    let status = wait(&mut job, Duration::from_secs(60)).expect("the run stops");
    assert_eq!(status.code(), Some(138));
    let summary = ok(Summary::read(&out.join("summary.json")));
    assert_eq!(format!("{:?}", summary.status), "Interrupted");
    let last = ok(checkpoint::last_whole(&out));
    assert_eq!(last.path, checkpoint::path(&out, summary.steps));
}

/// Whichever rank sees first that the time is over.
#[test]
fn ranks_whose_time_is_over_say_so() {
    let folder = ok(tempfile::tempdir());
    let out = folder.path().join("run");
    let run = ["run", "problems/two-spheres", "-q", "--set", "run.cfl=1e-3", "--wall", "2 s", "--out"];
    let output = ok(mpirun(3, &[&run[..], &[text(&out)]].concat()).output());
    let said = words(&output);
    assert_eq!(output.status.code(), Some(124), "{said}");
    assert_eq!(said.matches("out of time (--wall)").count(), 1, "{said}");
    assert!(checkpoint::last_whole(&out).is_ok());
}
