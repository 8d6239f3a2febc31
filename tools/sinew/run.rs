//! `sinew run`: a scene, from the first step to the last.
use super::args::RunArgs;
use super::fail::Failure;
use super::folder::Taken;
use super::progress::Progress;
use super::ranks::Crew;
use super::say::{say, tell};
use super::stop::Stop;
use super::{folder, picture, ranks, restart, wound};
use engine::exec::trace;
use scene::Scene;
use sinew::input::Written;
use sinew::output::checkpoint;
use sinew::output::summary::Summary;
use sinew::simulation::recorder::{End, Next, Recorder};
use sinew::simulation::{RunError, Simulation};
use std::path::Path;

/// Runs the subcommand.
pub fn run(args: &RunArgs, crew: Crew) -> Result<(), Failure> {
    let mut stop = Stop::read(args.wall.as_deref())?;
    let first = crew.network.rank() == 0;
    let host = crew.host();
    let place = |path: &Path| ranks::place(host.as_deref(), path);
    let begun = match &args.restart {
        Some(folder) => restart::resume(args, folder, crew)?,
        None => Some(begin(args, crew)?),
    };
    // a run that is complete has nothing to do
    let Some((taken, mut simulation, mut recorder)) = begun else { return Ok(()) };
    stop.watch(&mut simulation)?;
    let folder = &taken.path;
    if let (true, false, Some(_)) = (first, args.quiet, &host) {
        tell!("results go to {}", place(folder));
    }
    let title = format!("{} ({})", simulation.scene.title, simulation.scene.name);
    let mut progress = Progress::begin(&title, &mut simulation, args.quiet)?;
    if args.trace {
        simulation.set_trace(trace::BOUND);
    }
    progress.warn(recorder.warnings());
    let end = march(&mut simulation, &mut recorder, &mut progress, &mut stop)?;
    progress.warn(recorder.warnings());
    progress.end();
    let summary = recorder.finish(&mut simulation, end.clone())?;
    if args.trace {
        simulation.write_trace(&folder.join("trace.json"))?;
    }
    if first {
        print_summary(&summary, &place(folder));
    }
    match end {
        End::Failed(error) => {
            let last = if first { checkpoint::last_whole(folder).ok() } else { None };
            let last = last
                .map_or_else(String::new, |last| format!("\nThe last state before is {}", place(&last.path)));
            return Err(Failure::Run(format!("{error}{last}")));
        }
        End::Interrupted => {
            let (reason, status) = stop.reason(simulation.network())?;
            let message = match first {
                true => stopped(reason, summary.steps, folder, host.as_deref()),
                false => String::new(),
            };
            if first && simulation.network().size() > 1 {
                tell!("{message}");
                simulation.network().end_by_signal(status.into());
                return Err(Failure::Told(status));
            }
            return Err(Failure::Interrupted(message, status));
        }
        End::Completed => {}
    }
    if simulation.network().size() > 1 {
        // a picture takes a whole frame: no rank holds the particles of all
        if first && simulation.scene.output.frames > 0 {
            say!("to see it      sinew picture {0}; sinew wound {0}", folder.display());
        }
        simulation.network().part(None);
        return Ok(());
    }
    // the run is complete, whatever becomes of its pictures
    if let Err(failure) = show(&simulation.scene, folder) {
        let words = failure.message();
        tell!("warning: {}", words.strip_prefix("error: ").unwrap_or(&words));
    }
    Ok(())
}

/// Wound table and pictures, if the scene has them.
fn show(scene: &Scene, folder: &Path) -> Result<(), Failure> {
    if scene.output.frames > 0 {
        let table = scene.output.wound.as_ref().map_or(Ok(()), |_| wound::print(folder));
        for picture in picture::draw(folder, None)? {
            say!("picture        {}", picture.display());
        }
        return table;
    }
    Ok(())
}

/// A run from the first step on.
fn begin(
    args: &RunArgs,
    Crew { mut network, site, isa }: Crew,
) -> Result<(Taken, Simulation, Recorder), Failure> {
    let path = args.scene.as_deref().unwrap_or(Path::new("."));
    let overrides = ranks::agree(&mut *network, args.changes.overrides())?;
    // rank 0 alone needs to see the file
    let written = || Ok(Written::read(path)?);
    let mut scene = ranks::scene(&mut *network, written, &overrides)?;
    ranks::share_cores(&mut scene, site, &mut *network)?;
    let taken = folder::begin(args, path, &scene.name, &mut *network)?;
    let mut simulation = Simulation::on(network, scene, isa)?;
    // until the first step, what cannot be written is bad usage
    let mut recorder = Recorder::create(&taken.path, &mut simulation).map_err(Failure::usage)?;
    recorder.guard(taken.claim.clone());
    Ok((taken, simulation, recorder))
}

/// Steps until the end, or until an error that all ranks share.
fn march(
    simulation: &mut Simulation,
    recorder: &mut Recorder,
    progress: &mut Progress,
    stop: &mut Stop,
) -> Result<End, Failure> {
    loop {
        match simulation.step() {
            Ok(true) => {}
            Ok(false) => return Ok(End::Completed),
            Err(error @ RunError::Network(_)) => return Err(error.into()),
            Err(RunError::Stopped { .. }) => return Ok(End::Interrupted),
            Err(error) => {
                recorder.look(simulation);
                return Ok(End::Failed(error.to_string()));
            }
        }
        let stop = stop.wanted(simulation, recorder);
        match recorder.step(simulation, stop) {
            Ok(Next::Go) => {}
            Ok(Next::Stop) => return Ok(End::Interrupted),
            Err(error) => return Ok(End::Failed(error.to_string())),
        }
        progress.warn(recorder.warnings());
        progress.step(simulation);
    }
}

/// What to say of a run that has stopped.
fn stopped(reason: &str, steps: u64, folder: &Path, host: Option<&str>) -> String {
    let named = |path: &Path| match (host, path.file_name()) {
        (None, Some(name)) => name.display().to_string(),
        _ => ranks::place(host, path),
    };
    match checkpoint::last_whole(folder) {
        Ok(last) => format!(
            "{reason} after step {steps}; {} is there: go on with: sinew run --restart {}",
            named(&last.path),
            folder.display()
        ),
        Err(_) => format!(
            "{reason} in the middle of step {}, which took long; there is no checkpoint to go on from",
            steps + 1
        ),
    }
}

fn print_summary(summary: &Summary, place: &str) {
    let e = &summary.energy_j;
    say!("results        {place}");
    say!("simulated      {:.4} ms in {} steps", 1e3 * summary.time_s, summary.steps);
    say!(
        "wall time      {:.1} s, {:.2} million particle updates a second and core ({}, {} threads)",
        summary.wall_s,
        summary.updates_per_s_per_core / 1e6,
        summary.isa,
        summary.threads
    );
    say!(
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
        let collapsed = material.more.get("counts").and_then(|counts| counts["collapsed"].as_u64());
        let collapsed = collapsed.filter(|&n| n > 0);
        let collapsed = collapsed.map_or(String::new(), |n| format!(", {n} particles collapsed (J < 0.1)"));
        say!(
            "{name:<14} {} particles, mean velocity ({x:.3}, {y:.3}, {z:.3}) m/s{failed}{collapsed}",
            material.particles
        );
    }
    if summary.deleted_particles > 0 {
        say!("left           {} particles left the domain", summary.deleted_particles);
    }
    say!("state hash     {}", summary.state_hash);
}
