//! `sinew run`: a scene, from the first step to the last.
use super::args::RunArgs;
use super::fail::Failure;
use super::progress::Progress;
use super::signals::Signals;
use super::{picture, ranks, restart, wound};
use engine::exec::ranks::Network;
use engine::exec::ranks::launch::Machine;
use engine::exec::trace;
use scene::Scene;
use simd::Isa;
use sinew::output::summary::Summary;
use sinew::simulation::recorder::{End, Next, Recorder, holds_run};
use sinew::simulation::{RunError, Simulation};
use std::path::{Path, PathBuf};

/// Runs the subcommand.
pub fn run(args: &RunArgs) -> Result<(), Failure> {
    let isa = Isa::from_environment().map_err(Failure::usage)?;
    let (network, site) = ranks::connect()?;
    let first = network.rank() == 0;
    let (folder, mut simulation, mut recorder) = match &args.restart {
        Some(folder) => restart::resume(args, folder, isa, network, site)?,
        None => begin(args, isa, network, site)?,
    };
    let signals =
        Signals::watch().map_err(|error| Failure::Local(format!("cannot watch signals: {error}")))?;
    let title = format!("{} ({})", simulation.scene.title, simulation.scene.name);
    let mut progress = Progress::begin(&title, &mut simulation, args.quiet)?;
    if args.trace {
        simulation.set_trace(trace::BOUND);
    }
    let end = march(&mut simulation, &mut recorder, &mut progress, &signals)?;
    progress.end();
    if args.trace {
        simulation.write_trace(&folder.join("trace.json"))?;
    }
    let summary = recorder.finish(&mut simulation, end.clone())?;
    if first {
        print_summary(&summary, &folder);
    }
    match end {
        End::Failed(error) => return Err(Failure::Run(error)),
        End::Interrupted => {
            let message = format!(
                "interrupted after step {}; go on with: sinew run --restart {}",
                summary.steps,
                folder.display()
            );
            return Err(Failure::Interrupted(message, signals.exit_status()));
        }
        End::Completed => {}
    }
    if simulation.network().size() > 1 {
        // a picture takes a whole frame: no rank holds the particles of all
        if first && simulation.scene.output.frames > 0 {
            println!("to see it      sinew picture {0}; sinew wound {0}", folder.display());
        }
        simulation.network().part(None);
        return Ok(());
    }
    show(&simulation.scene, &folder)
}

/// Wound table and pictures, if the scene has them.
fn show(scene: &Scene, folder: &Path) -> Result<(), Failure> {
    if scene.output.frames > 0 {
        if scene.output.wound.is_some() {
            wound::print(folder)?;
        }
        for picture in picture::draw(folder, None)? {
            println!("picture        {}", picture.display());
        }
    }
    Ok(())
}

/// A run from the first step on.
fn begin(
    args: &RunArgs,
    isa: Isa,
    mut network: Box<dyn Network>,
    site: Machine,
) -> Result<(PathBuf, Simulation, Recorder), Failure> {
    let path = args.scene.as_deref().unwrap_or(Path::new("."));
    let scene = args.changes.overrides().and_then(|overrides| Ok(sinew::input::read(path, &overrides)?));
    let mut scene = ranks::agree(&mut *network, scene)?;
    ranks::share_cores(&mut scene, site, &mut *network)?;
    let folder = ranks::from_first(&mut *network, || {
        let folder = args.out.clone().unwrap_or_else(|| default_folder(&scene.name, args.force));
        claim(&folder, args.force)?;
        Ok(folder.display().to_string())
    })?;
    let mut simulation = Simulation::on(network, scene, isa)?;
    // until the first step, what cannot be written is bad usage
    let recorder = Recorder::create(Path::new(&folder), &mut simulation).map_err(Failure::usage)?;
    Ok((folder.into(), simulation, recorder))
}

/// Steps until the end, or until an error that all ranks share.
fn march(
    simulation: &mut Simulation,
    recorder: &mut Recorder,
    progress: &mut Progress,
    signals: &Signals,
) -> Result<End, Failure> {
    loop {
        match simulation.step() {
            Ok(true) => {}
            Ok(false) => return Ok(End::Completed),
            Err(error @ RunError::Network(_)) => return Err(error.into()),
            Err(error) => return Ok(End::Failed(error.to_string())),
        }
        match recorder.step(simulation, signals.came()) {
            Ok(Next::Go) => {}
            Ok(Next::Stop) => return Ok(End::Interrupted),
            Err(error) => return Ok(End::Failed(error.to_string())),
        }
        progress.step(simulation);
    }
}

/// `runs/NAME`, or the first `runs/NAME-2`, `runs/NAME-3`, … that holds no run; with `force` always the first.
fn default_folder(name: &str, force: bool) -> PathBuf {
    let numbered = (2..).map(|n| Path::new("runs").join(format!("{name}-{n}")));
    let mut folders = std::iter::once(Path::new("runs").join(name)).chain(numbered);
    let first = folders.find(|folder| force || !holds_run(folder));
    first.unwrap_or_else(|| Path::new("runs").join(name))
}

/// Refuses a folder that holds a run, unless forced, and one that cannot be written.
fn claim(folder: &Path, force: bool) -> Result<(), Failure> {
    if !force && holds_run(folder) {
        return Err(Failure::usage(format!(
            "{} already holds a run: choose another folder with --out, or overwrite it with --force",
            folder.display()
        )));
    }
    let probe = folder.join(".sinew-probe");
    let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&probe, b""));
    written.map_err(|error| {
        Failure::usage(format!(
            "cannot write to {}: {error}; choose another folder with --out",
            folder.display()
        ))
    })?;
    // an empty probe left behind would do no harm
    let _ = std::fs::remove_file(probe);
    Ok(())
}

fn print_summary(summary: &Summary, folder: &Path) {
    let e = &summary.energy_j;
    println!("results        {}", folder.display());
    println!("simulated      {:.4} ms in {} steps", 1e3 * summary.time_s, summary.steps);
    println!(
        "wall time      {:.1} s, {:.2} million particle updates a second and core ({}, {} threads)",
        summary.wall_s,
        summary.updates_per_s_per_core / 1e6,
        summary.isa,
        summary.threads
    );
    println!(
        "energy [J]     kinetic {:.4e}, strain {:.4e}, plastic {:.4e}, fracture {:.4e}, friction {:.4e}, impact {:.4e}, transfer {:.4e}, residual {:+.4e} ({:+.2} % of what was turned over)",
        e.kinetic,
        e.strain,
        e.plastic,
        e.fracture,
        e.friction,
        e.impact,
        e.transfer,
        e.residual,
        if e.turnover > 0.0 { 100.0 * e.residual / e.turnover } else { 0.0 }
    );
    for (name, material) in &summary.materials {
        let [x, y, z] = material.mean_velocity_m_s;
        let failed = material
            .failed_fraction
            .as_ref()
            .map_or(String::new(), |f| format!(", failed {:.2} %", 100.0 * f.any));
        println!(
            "{name:<14} {} particles, mean velocity ({x:.3}, {y:.3}, {z:.3}) m/s{failed}",
            material.particles
        );
    }
    if summary.deleted_particles > 0 {
        println!("left           {} particles left the domain", summary.deleted_particles);
    }
    println!("state hash     {}", summary.state_hash);
}
