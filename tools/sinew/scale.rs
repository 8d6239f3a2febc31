//! `sinew scale`: how a scene scales, here and beyond.
use super::args::overrides;
use super::fail::Failure;
use super::say::tell;
use engine::exec::ranks::launch::cores;
use scene::Patches;
use scene::Scene;
use sinew::lab::scale::footprint::Footprint;
use sinew::lab::scale::list::{self, MOST};
use sinew::lab::scale::measure::{self, Plan};
use sinew::lab::scale::model::{Cluster, KEYS, Setup};
use sinew::lab::scale::ping::Ping;
use sinew::lab::scale::report::Report;
use sinew::lab::scale::row::{self, Row};
use sinew::lab::scale::step::Step;
use sinew::lab::scale::tally::Tally;
use sinew::lab::scale::validate::{largest, validate};
use sinew::lab::scale::{calibrate, series, table};
use sinew::simulation::{layout, step_graph, step_program};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Measure how a scene scales over patches, threads and ranks, and predict it beyond this machine
///
/// Runs `sinew run` with a trace for each combination of --patches, --threads and --ranks, and prints a table; then
/// simulates steps of the scene on growing numbers of ranks of a cluster, with the costs of work measured here and a network
/// that --network describes, and compares the model of this machine with the table. The simulation goes through the same order
/// of work and messages as a run; with run.rates = "per-material" through the ticks of the step that the scene has at rest.
///
/// Columns. ms/step, median: the best and the median of the repetitions, without the first steps. effic.: particle updates a
/// second and worker (thread of a rank) over those of the row with the fewest workers and patches. cuts %: time over that of
/// the fewest patches on the same threads and ranks. engine ms: time of a step in which the first worker of a rank does
/// something other than tasks, communication and waiting: lists of blocks, handing out work, locks, checks, looking for
/// particles that leave; mean of the ranks. kB/rank, msg/rank: what a rank sends in halos and relocation a step; a reduction
/// has log2(ranks) messages more. halo %: packing, sending and waiting for node data. wait %: waiting for others, for node
/// data, travelers and reductions. idle %: time of workers in which they have nothing to do while others of their rank work
/// or wait. imbal.: task time of the busiest rank over the mean. peak MB: the most memory of a rank. state: equal in all rows
/// of a scene, or there is a bug.
///
/// Files: measured.csv, efficiency.svg, time.svg, patches.svg, predicted.csv, prediction.svg, scale.json.
///
/// More ranks and threads than cores can be measured, but then processes take turns, and waiting ones spin.
#[derive(clap::Args)]
pub struct Args {
    /// Folder with a scene.toml, or a .toml file
    scene: PathBuf,
    /// Patches: numbers to be cut where the particles are, or AxBxC
    #[arg(long, value_name = "LIST", default_value = "1,2,4,8,16,32,64")]
    patches: String,
    /// Threads a rank (default: 1, 2, 4, … to all cores)
    #[arg(long, value_name = "LIST")]
    threads: Option<String>,
    /// Ranks; above 1, Sinew must be built with --features mpi
    #[arg(long, value_name = "LIST", default_value = "1")]
    ranks: String,
    /// Steps that count
    #[arg(long, value_name = "N", default_value_t = 30)]
    steps: u64,
    /// Steps before them; after the tenth, patches move to where their costs are shared evenly
    #[arg(long, value_name = "N", default_value_t = 12)]
    warm_up: u64,
    /// Repetitions
    #[arg(long, value_name = "R", default_value_t = 3)]
    repeat: usize,
    /// Weak scaling: the cell shrinks with (ranks * threads)^(1/3), as far as whole cells allow
    #[arg(long)]
    weak: bool,
    /// What starts several ranks
    #[arg(long, value_name = "COMMAND", default_value = "mpirun -n {ranks}")]
    launcher: String,
    /// Only measure
    #[arg(long, conflicts_with = "predict_only")]
    measure_only: bool,
    /// Only predict, from three short runs on one thread
    #[arg(long)]
    predict_only: bool,
    /// The cluster of the prediction, for example latency=1.2, bandwidth=25 (repeatable): latency, hop, overhead,
    /// inner-latency [us], bandwidth (of a machine), inner-bandwidth (of a rank) [GB/s], ranks (a machine), machines (below
    /// one switch), taper, noise (mean random part of a rank's task time)
    #[arg(long, value_name = "KEY=VALUE")]
    network: Vec<String>,
    /// Threads a rank in the prediction
    #[arg(long, value_name = "N", default_value_t = 8)]
    rank_threads: usize,
    /// Most ranks of the weak prediction
    #[arg(long, value_name = "N", default_value_t = 100_000)]
    most_ranks: usize,
    /// Ticks that are simulated at least for each number of ranks, in whole steps; the first step does not count. Where
    /// materials take steps of their own, a step has many ticks, and --most-ranks 10000 keeps the time of a prediction short
    #[arg(long, value_name = "N", default_value_t = 4)]
    ticks: usize,
    /// Folder for the results (default: scaling/NAME)
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Override a field of the scene, for example domain.cell="1 mm"
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// No progress on the screen
    #[arg(long, short)]
    quiet: bool,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let scene = read(args, &[])?;
    let cluster = cluster(args)?;
    let sizes = [args.repeat, args.rank_threads, args.most_ranks, args.ticks].map(|n| n as u64);
    let mut counts = [args.steps, args.warm_up.max(1)].into_iter().chain(sizes);
    if !counts.all(|n| (1..=MOST as u64).contains(&n)) {
        return Err(Failure::usage(format!(
            "--steps, --repeat, --rank-threads, --most-ranks and --ticks are at least 1; they and --warm-up are at most {MOST}"
        )));
    }
    let rounds = step_program(&scene, 1).map_err(|error| Failure::Run(error.to_string()))?.graphs().len() > 1;
    if rounds && !args.measure_only {
        return Err(Failure::usage(
            "contact moves a free rigid body, whose motion is found in rounds: the model cannot foresee them. Add --measure-only",
        ));
    }
    let folder = args.out.clone().unwrap_or_else(|| Path::new("scaling").join(&scene.name));
    let plan = plan(args, &folder)?;
    let mut report = Report {
        scene: scene.name.clone(),
        machine: machine(),
        weak: args.weak,
        steps: args.steps,
        repeat: args.repeat,
        ..Report::default()
    };
    let mut tallies = Vec::new();
    if !args.predict_only {
        (report.rows, tallies) = measure::measure(&plan, &reader(args), &mut say(args));
        show_measured(&mut report);
    }
    if !args.measure_only {
        predict(args, &scene, &plan, cluster, &tallies, &mut report)?;
    }
    for path in report.write(&folder)? {
        println!("file           {}", path.display());
    }
    verdict(&report)
}

/// A run that failed or ended elsewhere is a failure after everything has been written.
fn verdict(report: &Report) -> Result<(), Failure> {
    if report.same_state == Some(false) {
        return Err(Failure::Run("rows of the same scene end in different states: this is a bug".to_owned()));
    }
    let failed = report.rows.iter().filter(|row| row.error.is_some()).count();
    if failed > 0 && failed == report.rows.len() {
        return Err(Failure::Run("no run succeeded: see the table".to_owned()));
    }
    Ok(())
}

fn say(args: &Args) -> impl FnMut(&str) + use<> {
    let quiet = args.quiet;
    move |what: &str| {
        if !quiet {
            tell!("{what}");
        }
    }
}

fn read(args: &Args, more: &[(String, String)]) -> Result<Scene, Failure> {
    let mut set = overrides(&args.set)?;
    set.extend_from_slice(more);
    Ok(sinew::input::read(&args.scene, &set)?)
}

fn reader(args: &Args) -> impl Fn(&[(String, String)]) -> Result<Scene, String> + use<'_> {
    |more: &[(String, String)]| read(args, more).map_err(|failure| failure.message())
}

fn cluster(args: &Args) -> Result<Cluster, Failure> {
    let mut cluster = Cluster::default();
    for pair in &args.network {
        cluster.set(pair).map_err(|error| {
            let known: Vec<String> = KEYS.iter().map(|(key, what)| format!("{key}: {what}")).collect();
            Failure::usage(format!("--network {error}\n{}", known.join("\n")))
        })?;
    }
    Ok(cluster)
}

fn plan(args: &Args, folder: &Path) -> Result<Plan, Failure> {
    let wrong = |option: &str| {
        let option = option.to_owned();
        move |error: String| Failure::usage(format!("{option} {error}"))
    };
    let threads = match &args.threads {
        Some(text) => list::counts(text).map_err(wrong("--threads"))?,
        None => {
            let all = cores().1;
            let doubled = std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|&n| n < all);
            doubled.chain([all]).collect()
        }
    };
    let patches: Vec<Patches> = list::patches(&args.patches).map_err(wrong("--patches"))?;
    let ranks = list::counts(&args.ranks).map_err(wrong("--ranks"))?;
    let program = std::env::current_exe()
        .map_err(|error| Failure::Run(format!("cannot find the program that is running: {error}")))?;
    std::fs::create_dir_all(folder).map_err(|error| {
        Failure::usage(format!(
            "cannot write to {}: {error}; choose another folder with --out",
            folder.display()
        ))
    })?;
    Ok(Plan {
        scene: args.scene.clone(),
        set: args.set.clone(),
        patches,
        threads,
        ranks,
        steps: args.steps,
        warm: args.warm_up,
        repeat: args.repeat,
        weak: args.weak,
        launcher: args.launcher.clone(),
        program,
        folder: folder.to_owned(),
    })
}

fn show_measured(report: &mut Report) {
    report.same_state = row::same_state(&report.rows);
    let kind = if report.weak { "weak" } else { "strong" };
    println!(
        "measured       {}, {kind} scaling, {} steps, best of {}\n",
        report.scene, report.steps, report.repeat
    );
    print!("{}", table::text(&report.rows));
    println!();
    match report.same_state {
        Some(true) => println!("state          the same in all rows of the same cells"),
        Some(false) => println!("state          NOT the same in all rows: this is a bug"),
        None => {}
    }
    let most = report.rows.iter().map(Row::workers).max().unwrap_or(1);
    if let (Some(all), _) = cores()
        && most > all
    {
        println!(
            "note           up to {most} workers on {all} cores: they take turns, and waiting ones spin"
        );
    }
    if report.rows.iter().any(|row| row.lost > 0) {
        println!("note           traces lost events: shares are too small; measure fewer --steps");
    }
}

/// The model: calibrated, checked, and run.
fn predict(
    args: &Args,
    scene: &Scene,
    plan: &Plan,
    cluster: Cluster,
    tallies: &[Option<Tally>],
    report: &mut Report,
) -> Result<(), Failure> {
    let graph = step_graph(scene, 1).map_err(|error| Failure::Run(error.to_string()))?;
    let read = reader(args);
    let mut costs = calibrate::calibrate(plan, &read, &graph, &mut say(args)).map_err(Failure::Run)?;
    costs.pack = calibrate::pack(tallies).unwrap_or(costs.pack);
    let footprint = Footprint::of(scene).map_err(Failure::usage)?;
    let step = Step::of(scene, &graph);
    let (threads, steps) = (args.rank_threads, steps(args.ticks, step.ticks.len()));
    let mut setup = Setup { step: &step, costs, cluster, threads, steps };
    // with --weak the rows are other scenes
    let fitted = if args.weak { None } else { fit(&report.rows, tallies, &mut setup, &footprint)? };
    report.reduced_bytes = step.each().filter_map(|tick| tick.reduced.last()).fold(0.0, |a, &b| b.max(a));
    println!("\nmodel          of {}", report.machine);
    print!("{}", setup.costs);
    if step.ticks.len() > 1 {
        println!(
            "rates          a step has {} ticks at rest; a run decides anew each step",
            step.ticks.len()
        );
    }
    if !report.rows.is_empty() && !args.weak {
        let here = here(plan);
        let own = Setup { cluster: here, ..setup.clone() };
        let level = layout::level(scene);
        report.checks =
            validate(&footprint, &level, &report.rows, &own, (fitted, cores_here())).map_err(Failure::Run)?;
        report.here = Some(here);
        show_checks(report, here);
    }
    series(args, &footprint, &setup, report)?;
    (report.costs, report.cluster, report.threads) = (Some(setup.costs), Some(cluster), args.rank_threads);
    Ok(())
}

/// Steps of so many ticks that are simulated for `ticks` ticks: a second one, if the first does not count.
fn steps(ticks: usize, each: usize) -> usize {
    if ticks > 1 { ticks.div_ceil(each).max(2) } else { 1 }
}

/// Fits what sharing memory costs to the first row on several workers; returns which that is.
fn fit(
    rows: &[Row],
    tallies: &[Option<Tally>],
    setup: &mut Setup<'_>,
    footprint: &Footprint,
) -> Result<Option<usize>, Failure> {
    let several = |number: &usize| (2..=cores_here()).contains(&rows[*number].workers());
    let tally = |number: usize| Some((number, tallies.get(number)?.as_ref()?));
    let Some((fitted, tally)) = (0..rows.len()).filter(several).find_map(tally) else { return Ok(None) };
    setup.costs.contention = calibrate::contention(tally, setup, footprint).map_err(Failure::Run)?;
    Ok(Some(fitted))
}

/// Cores of this machine.
fn cores_here() -> usize {
    cores().0.unwrap_or(cores().1)
}

/// The network between ranks on this machine, as a ping between two of them measures it.
fn here(plan: &Plan) -> Cluster {
    let mut here = Cluster::default();
    let ping = plan.ranks.iter().any(|&ranks| ranks > 1).then(|| pinged(plan)).flatten();
    if let Some(ping) = ping {
        (here.inner_latency, here.overhead) = (ping.latency, ping.overhead);
        here.inner_bandwidth = ping.bandwidth;
    }
    here
}

/// How long a ping may take.
const PATIENCE: Duration = Duration::from_secs(20);

/// A ping between two ranks; nothing, if the launcher does not start them or they do not answer.
fn pinged(plan: &Plan) -> Option<Ping> {
    let line = plan.launcher.replace("{ranks}", "2");
    let mut words = line.split_whitespace();
    let mut command = Command::new(words.next()?);
    command.args(words).arg(&plan.program).args(["ping", "--json"]);
    let mut child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().ok()?;
    let began = Instant::now();
    while child.try_wait().ok()?.is_none() {
        if began.elapsed() > PATIENCE {
            // whoever does not answer is ended; if that fails there is nothing else to do
            let _ = child.kill().and_then(|()| child.wait());
            return None;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    serde_json::from_reader(child.stdout.take()?).ok()
}

fn show_checks(report: &Report, here: Cluster) {
    println!(
        "ranks here     {:.2} us latency, {:.2} us of a processor a message, {:.1} GB/s",
        1e6 * here.inner_latency,
        1e6 * here.overhead,
        1e-9 * here.inner_bandwidth
    );
    println!("\nmodel of this machine against what was measured\n\n{}", table::checks(&report.checks));
    if let Some(worst) = largest(&report.checks) {
        println!(
            "largest error  {:+.1} %, on {} patches, {} threads and {} ranks",
            100.0 * worst.error,
            worst.patches,
            worst.threads,
            worst.ranks
        );
    }
}

fn series(args: &Args, footprint: &Footprint, setup: &Setup<'_>, report: &mut Report) -> Result<(), Failure> {
    report.strong = series::strong(footprint, setup, args.most_ranks).map_err(Failure::usage)?;
    let threads = args.rank_threads;
    println!(
        "\nprediction     ranks of {threads} threads, each core as those of this machine, {:.1} kB a reduction",
        1e-3 * report.reduced_bytes
    );
    print!("{}", setup.cluster);
    println!("\nstrong: {} as it is, on as many ranks as it has patches\n", report.scene);
    print!("{}", table::predicted(&report.strong));
    // a run cuts eight patches a thread
    let brick = footprint.brick(8.0);
    println!(
        "\nweak: {:.0} particles in {:.0} blocks a worker, in a torus of ranks that look the same\n",
        brick.particles.iter().sum::<f64>(),
        brick.all_blocks()
    );
    report.weak_points = series::weak(&brick, setup, args.most_ranks);
    print!("{}", table::predicted(&report.weak_points));
    report.brick = Some(brick);
    Ok(())
}

fn machine() -> String {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    let name = model.map_or("unknown", |(_, name)| name.trim());
    format!("{name}, {} cores", cores_here())
}
