//! `sinew bench`: how fast are steps, task by task, and how fast could they be?
use super::args::overrides;
use super::fail::Failure;
use super::progress::Progress;
use super::say::tell;
use super::voice::Voice;
use physics::parameter::Dimension;
use scene::{Rates, Scene};
use simd::Isa;
use sinew::input::{self, units};
use sinew::lab::bench::{BenchError, Plan, Report, bench, compare};
use sinew::output::io;
use sinew::simulation::{Simulation, available_threads};
use std::path::{Path, PathBuf};

/// Measure steps, task by task, against what this machine can do: multiply-adds and memory
///
/// Runs the scene until --at, each material at a rate of its own, so that tissue is ragged and bodies are in contact; then
/// measures whole steps at the common rate on one thread and on all threads in turns, and steps with a meter between tasks;
/// the steps move the scene on. Operations are counted
/// by running one step on vectors that count. A run of its own needs some seconds after --at.
#[derive(clap::Args)]
pub struct Args {
    /// Folder with a scene.toml, or a .toml file (default: the paper's slab, at CFL 0.4)
    scene: Option<PathBuf>,
    /// Simulated time at which to measure, for example "0.2 ms"; 0: the lattice that the scene begins with (default: a
    /// quarter of the scene's time)
    #[arg(long, value_name = "TIME")]
    at: Option<String>,
    /// Steps of a repetition
    #[arg(long, value_name = "N", default_value_t = 10)]
    steps: usize,
    /// Repetitions, of which the best counts
    #[arg(long, value_name = "R", default_value_t = 5)]
    repeat: usize,
    /// All threads (default: all cores)
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Write everything that was measured to a JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Compare with the JSON file of an earlier bench: ratios now/then, as they are and in units of the multiply-adds
    #[arg(long, value_name = "FILE")]
    against: Option<PathBuf>,
    /// Override a field of the scene, for example run.patches="[2, 1, 2]"
    #[arg(long = "set", value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// No progress on the screen
    #[arg(long, short)]
    quiet: bool,
}

/// The paper's slab is part of the command, so that it needs no file.
const SLAB: &str = include_str!("../../problems/slab/scene.toml");

/// With the step that most runs take.
const USUAL: [(&str, &str); 1] = [("run.cfl", "0.4")];

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let isa = Isa::from_environment().map_err(Failure::usage)?;
    let before = args.against.as_deref().map(earlier).transpose()?;
    let scene = scene(args)?;
    let at = start(args, &scene)?;
    let threads = args.threads.unwrap_or_else(available_threads);
    let title = format!("{} ({}), until {:.4} ms", scene.title, scene.name, 1e3 * at);
    let mut simulation = Simulation::new(scene, isa)?;
    advance(&mut simulation, at, &title, args.quiet)?;
    simulation.set_rates(Rates::Common)?;
    let plan = Plan { steps: args.steps, repeat: args.repeat, threads };
    let mut progress = |what: &str| {
        if !args.quiet {
            tell!("measuring {what}");
        }
    };
    let report = bench(&mut simulation, &plan, &mut progress)?;
    print!("{report}");
    if let Some(file) = &args.json {
        let text = serde_json::to_string_pretty(&report).map_err(|e| Failure::Run(e.to_string()))?;
        // a file that the user names may be a pipe
        std::fs::write(file, format!("{text}\n")).map_err(io("write", file))?;
    }
    if let Some(before) = before {
        print!("\n{}", compare(&report, &before));
    }
    Ok(())
}

impl From<BenchError> for Failure {
    fn from(error: BenchError) -> Self {
        match error {
            BenchError::Run(error) => error.into(),
            BenchError::Ended { .. } | BenchError::Nothing => Failure::usage(error),
        }
    }
}

fn scene(args: &Args) -> Result<Scene, Failure> {
    let threads = args.threads.map(|n| ("run.threads".to_owned(), n.to_string()));
    // last, as in a run: what is measured is what was checked
    let set: Vec<_> = overrides(&args.set)?.into_iter().chain(threads).collect();
    let mut scene = match &args.scene {
        Some(path) => input::read(path, &set)?,
        None => {
            let usual = USUAL.map(|(key, value)| (key.to_owned(), value.to_owned()));
            let set: Vec<_> = usual.into_iter().chain(set).collect();
            input::read_text("slab", SLAB, &set, input::available_memory())?
        }
    };
    scene.run.steps = None; // the bench says how far it goes
    scene.run.rates = Rates::PerMaterial { most: 256 }; // to be there soon
    Ok(scene)
}

/// When to measure [s].
fn start(args: &Args, scene: &Scene) -> Result<f64, Failure> {
    let Some(text) = &args.at else { return Ok(0.25 * scene.run.until) };
    // as in scenes, a number without a unit is in SI
    let at = text.trim().parse().or_else(|_| units::parse(text, Dimension::Time)).map_err(|problem| {
        Failure::usage(format!("--at {text}: {problem}; write a time, for example --at \"0.2 ms\""))
    })?;
    if (0.0..scene.run.until).contains(&at) {
        return Ok(at);
    }
    let until = 1e3 * scene.run.until;
    Err(Failure::usage(format!(
        "--at {text}: the scene runs from 0 to {until} ms; choose a time between, or --set run.until=..."
    )))
}

/// Steps until the state to measure.
fn advance(simulation: &mut Simulation, at: f64, title: &str, quiet: bool) -> Result<(), Failure> {
    let voice = if quiet { Voice::Quiet } else { Voice::Plain };
    let mut progress = Progress::begin(title, simulation, voice)?.until(at);
    while simulation.clock().time < at && simulation.step()? {
        progress.step(simulation);
    }
    progress.end();
    Ok(())
}

/// The report of an earlier bench.
fn earlier(file: &Path) -> Result<Report, Failure> {
    let problem = |problem: String| {
        Failure::usage(format!(
            "--against {}: {problem}; name a file that `sinew bench --json` wrote",
            file.display()
        ))
    };
    let text = std::fs::read_to_string(file).map_err(|error| problem(error.to_string()))?;
    serde_json::from_str(&text).map_err(|error| problem(error.to_string()))
}
