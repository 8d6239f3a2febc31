//! `sinew graph`: the tasks of a step and what passes between them.
use super::args::SceneArgs;
use super::fail::Failure;
use super::trial::Trial;
use engine::graph::build::TaskGraph;
use engine::graph::check::hazards;
use engine::program::{self, Program};
use grid::{BLOCK, Decomposition, Patch};
use scene::{Rates, Scene};
use simd::Isa;
use sinew::input::identity::fingerprint;
use sinew::lab::diagram::Chart;
use sinew::lab::plan::{self, Plan};
use sinew::output::trace;
use sinew::output::trace::measured::Measured;
use sinew::simulation::rates::Cycle;
use sinew::simulation::{rates, step_program};
use std::path::{Path, PathBuf};

/// Output form.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Format {
    /// The outline; then of each graph tables of tasks, messages, critical path
    Text,
    /// Graphviz
    Dot,
    /// The tree, and all that is known about tasks, edges, messages and what passes between graphs
    Json,
    /// A picture
    Svg,
    /// One page with pictures that explain themselves: open it in a browser
    Html,
}

/// Print the program of a step of a scene: its task graphs, in loops
///
/// The tree of graphs and loops, and what passes between them; of each graph, tasks, what they read and write, the edges that follow from it, fused stages, what patches and ranks exchange, and the
/// critical path. Bytes and messages are counted on the particles with which the scene begins.
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output form
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Ranks that share the patches: one patch for one rank, eight a rank for several, if --patches does not say
    #[arg(long, value_name = "N", default_value_t = 1)]
    ranks: usize,
    /// One node a task and patch, instead of one a task
    #[arg(long)]
    expanded: bool,
    /// Only what happens on this patch, and what is next to it (expanded)
    #[arg(long, value_name = "P")]
    patch: Option<usize>,
    /// Only what happens on this rank, and what is next to it (expanded)
    #[arg(long, value_name = "R")]
    rank: Option<usize>,
    /// What does this task do, and which line of the scene asked for it? Who writes and reads this label? With A:B: why does A come before B?
    #[arg(long, value_name = "TASK|LABEL|A:B", conflicts_with_all = ["check", "trace"])]
    why: Option<String>,
    /// Look for races, undeclared halos, idle labels and the like, and for labels that a graph or the next round of a loop reads
    /// and nobody has left; exit status 1 if there are any
    #[arg(long)]
    check: bool,
    /// Take times from the trace of a run: sinew run SCENE --trace writes it to RUN/trace.json
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Take some steps on one thread, as sinew check does, and scale the estimated times to what they take on this machine
    #[arg(long, conflicts_with_all = ["trace", "why", "check"])]
    measure: bool,
}

/// Patches a rank, if nobody says how many.
const PATCHES: usize = 8;

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let scene = args.scene.read()?;
    let wanted = if args.ranks > 1 { args.ranks.saturating_mul(PATCHES) } else { 1 };
    let plan = plan::plan(&scene, wanted, args.ranks).map_err(Failure::usage)?;
    let patches = plan.decomposition.patches.len();
    let mut program = step_program(&scene, patches).map_err(|error| Failure::Run(error.to_string()))?;
    if let Some(what) = &args.why {
        return why(&scene, &program, what);
    }
    if args.check {
        return check(&scene, patches, &plan.decomposition);
    }
    outside(["patch", "patches"], args.patch, patches)?;
    outside(["rank", "ranks"], args.rank, args.ranks)?;
    let measured = args.trace.as_deref().map(trace::read).transpose().map_err(Failure::usage)?;
    if let (Some(file), Some(measured)) = (&args.trace, &measured) {
        same_scene(file, measured, &scene)?;
    }
    if args.format == Format::Html {
        // the page is for people: they want the line
        let entries = program.graphs_mut().into_iter().flat_map(|graph| &mut graph.recipe.entries);
        for entry in entries.filter(|entry| !entry.because.is_empty()) {
            entry.because = because(&scene, &entry.because);
        }
    }
    let pace = if args.measure { Some(measure(args, &scene, &program, &plan)?) } else { None };
    show(args, &scene, &program, &plan, (measured.as_ref(), pace.as_ref()))
}

/// What a step takes here over what its tasks are estimated to take, and in words.
fn measure(args: &Args, scene: &Scene, program: &Program, plan: &Plan) -> Result<(f64, String), Failure> {
    // the loop over ticks has one round where all materials take the common step
    if program.loops().iter().any(|it| it.most > 1) || scene.run.rates != Rates::Common {
        let message = "--measure cannot tell what a round of a loop, or a tick with rates of their own, takes: take a trace instead (sinew run \
                       SCENE --trace, sinew graph SCENE --trace RUN/trace.json)";
        return Err(Failure::usage(message));
    }
    let cycle = rates::at_rest(scene);
    let estimated =
        Chart::new(program, &cycle, &plan.traffic, None, false).work_ns() * plan.traffic.ranks as f64;
    let mut overrides = args.scene.changes.overrides()?;
    overrides.push(("run.threads".to_owned(), "1".to_owned()));
    let alone = sinew::input::read(&args.scene.scene, &overrides)?;
    let trial = Trial::of(alone, Isa::from_environment().map_err(Failure::usage)?)?;
    let Some(pace) = trial.pace else {
        return Err(Failure::usage("the run ends before a step of it could be measured"));
    };
    let words = format!(
        "estimated by what tasks touch, scaled to {:.3} ms a step, which {} steps took on one thread here; 2 µs and 0.2 ns a byte for a \
         message; one thread a rank",
        1e3 * pace.seconds,
        pace.tried
    );
    Ok((1e9 * pace.seconds / estimated.max(f64::MIN_POSITIVE), words))
}

/// Refuses the trace of another scene, if it says of which it is: its times are those of other tasks.
fn same_scene(file: &Path, measured: &Measured, scene: &Scene) -> Result<(), Failure> {
    if measured.scene.is_empty() || measured.scene == fingerprint(&scene.resolved) {
        return Ok(());
    }
    Err(Failure::usage(format!(
        "{} is the trace of another scene than {}: give the scene.toml beside it, or record one of this scene with sinew run --trace",
        file.display(),
        scene.name
    )))
}

/// Refuses a patch or rank that does not exist.
fn outside([one, many]: [&str; 2], wanted: Option<usize>, count: usize) -> Result<(), Failure> {
    match wanted {
        Some(number) if number >= count => {
            Err(Failure::usage(format!("there is no {one} {number}: there are {many} 0 to {}", count - 1)))
        }
        _ => Ok(()),
    }
}

fn show(
    args: &Args,
    scene: &Scene,
    program: &Program,
    plan: &Plan,
    (measured, pace): (Option<&Measured>, Option<&(f64, String)>),
) -> Result<(), Failure> {
    let cycle = rates::at_rest(scene);
    let of = |expanded| chart(args, program, &cycle, plan, (measured, pace), expanded);
    let expanded = args.expanded || args.patch.is_some() || args.rank.is_some();
    let chart = of(expanded);
    match args.format {
        Format::Text => print!("{}", chart.to_text()),
        Format::Dot => print!("{}", chart.to_dot()),
        Format::Json => println!("{:#}", chart.to_json()),
        Format::Svg => print!("{}", chart.to_svg().map_err(Failure::usage)?),
        Format::Html => {
            let other = (plan.traffic.patches() > 1).then(|| of(!expanded));
            let title = format!("{}: a step", scene.title);
            print!("{}", chart.to_html(&title, other.as_ref()).map_err(Failure::usage)?);
        }
    }
    Ok(())
}

fn chart<'a>(
    args: &Args,
    program: &'a Program,
    cycle: &'a Cycle,
    plan: &'a Plan,
    (measured, pace): (Option<&'a Measured>, Option<&(f64, String)>),
    expanded: bool,
) -> Chart<'a> {
    let mut chart = Chart::new(program, cycle, &plan.traffic, measured, expanded);
    // before anything is left out: the critical path is that of all
    pace.iter().for_each(|(factor, words)| chart.set_pace(*factor, words));
    if let Some(patch) = args.patch.filter(|_| expanded) {
        chart.keep(|item| item.patch == Some(patch));
    }
    if let Some(rank) = args.rank.filter(|_| expanded) {
        chart.keep(|item| item.rank == Some(rank) || item.to_rank == Some(rank));
    }
    chart
}

/// Answers `--check`.
fn check(scene: &Scene, patches: usize, decomposition: &Decomposition) -> Result<(), Failure> {
    let (program, refusals) = plan::inspect(scene, patches);
    let across = |patch: &Patch| patch.blocks.size().map(|blocks| blocks * BLOCK as usize);
    let narrowest = decomposition.patches.iter().flat_map(across).min().unwrap_or(0);
    let reported = plan::read_by_reports(scene);
    let graphs = program.graphs();
    let mut findings: Vec<String> = refusals.iter().map(|refusal| format!("refused: {refusal}")).collect();
    for graph in &graphs {
        let place = if graphs.len() > 1 { format!("graph {}: ", graph.name) } else { String::new() };
        let found = hazards(graph, narrowest, &reported);
        findings.extend(found.iter().map(|hazard| format!("{place}{hazard}")));
    }
    findings.extend(program::hazards(&program).iter().map(ToString::to_string));
    findings.iter().for_each(|finding| println!("{finding}"));
    match findings.len() {
        0 => println!("{}", clean(&program, patches)),
        1 => return Err(Failure::Run("one finding".to_owned())),
        many => return Err(Failure::Run(format!("{many} findings"))),
    }
    Ok(())
}

/// What was looked at and found to be in order.
fn clean(program: &Program, patches: usize) -> String {
    let count = |n: usize, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
    let tasks = program.graphs().iter().map(|graph| graph.graph.node_count()).sum();
    format!(
        "{} on {}: no race, no undeclared halo, no idle label\n{}, {}: each label that is read was left, by an earlier graph, the round before or the last step, and each loop computes what it waits for",
        count(tasks, "task", "tasks"),
        count(patches, "patch", "patches"),
        count(program.graphs().len(), "graph", "graphs"),
        count(program.loops().len(), "loop", "loops"),
    )
}

/// Answers `--why`.
fn why(scene: &Scene, program: &Program, what: &str) -> Result<(), Failure> {
    let of = |graph: &TaskGraph| match what.split_once(':') {
        Some((from, to)) => graph.why_edge(from.trim(), to.trim()),
        None => tasks(scene, graph, what).into_iter().chain(graph.why_label(what)).collect(),
    };
    let graphs = program.graphs();
    let head = |graph: &TaskGraph| (graphs.len() > 1).then(|| format!("in graph {}:", graph.name));
    let answers = graphs.iter().map(|graph| (head(graph), of(graph))).filter(|(_, lines)| !lines.is_empty());
    let lines: Vec<String> = answers.flat_map(|(head, lines)| head.into_iter().chain(lines)).collect();
    if lines.is_empty() {
        return Err(Failure::usage(match what.split_once(':') {
            Some((from, to)) => format!("nothing makes {from} come before {to} in this scene"),
            None => format!("no task {what} in this scene, and no label; sinew graph lists them"),
        }));
    }
    lines.iter().for_each(|line| println!("{line}"));
    Ok(())
}

/// What the tasks of a name do, and the lines of the scene behind them.
fn tasks(scene: &Scene, graph: &TaskGraph, name: &str) -> Vec<String> {
    let line = |(name, key): (String, String)| format!("{name}: {}", because(scene, &key));
    let about = graph.about(name).map(str::to_owned);
    about.into_iter().chain(graph.why(name).into_iter().map(line)).collect()
}

/// The line of the scene that begins with a dotted key.
fn because(scene: &Scene, key: &str) -> String {
    let line = scene.lines.iter().find(|(k, _)| !key.is_empty() && k.starts_with(key));
    match (key, line) {
        ("", _) => "every explicit step has it".to_owned(),
        (_, Some((key, line))) => format!("{key}, line {line} of the scene"),
        (key, None) => format!("{key}, by default or by --set"),
    }
}
