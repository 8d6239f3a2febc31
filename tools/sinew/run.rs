//! `sinew run`: a scene, from the first step to the last.
use super::args::RunArgs;
use super::fail::Failure;
use super::folder::Taken;
use super::progress::Progress;
use super::ranks::Crew;
use super::say::{say, tell};
use super::stop::Stop;
use super::voice::{Voice, event};
use super::{drawing, ending, folder, ranks, restart, wound};
use engine::exec::recorder;
use scene::Scene;
use sinew::input::Written;
use sinew::output::checkpoint;
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
    let voice = args.loudness.voice();
    if let (true, Voice::Plain | Voice::Verbose, Some(_)) = (first, voice, &host) {
        tell!("results go to {}", place(folder));
    }
    let title = format!("{} ({})", simulation.scene.title, simulation.scene.name);
    let mut progress = Progress::begin(&title, &mut simulation, voice)?;
    if args.trace {
        simulation.set_trace(recorder::BOUND);
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
        ending::tell(&summary, &place(folder), voice);
    }
    match end {
        End::Failed(error) => {
            let last = if first { checkpoint::last_whole(folder).ok() } else { None };
            let last = last.map_or_else(String::new, |last| {
                let step = checkpoint::Reader::open(&last.path)
                    .map_or(String::new(), |it| format!(" of step {}", it.head.steps));
                format!("\nThe last checkpoint before is{step}: {}", place(&last.path))
            });
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
        if first && voice != Voice::Json && simulation.scene.output.frames > 0 {
            let wound = match simulation.scene.output.wound {
                Some(_) => format!("; sinew wound {}", folder.display()),
                None => String::new(),
            };
            say!("to see it      sinew picture {}{wound}", folder.display());
        }
        simulation.network().part(None);
        return Ok(());
    }
    // the run is complete, whatever becomes of its pictures
    if let Err(failure) = show(&simulation.scene, folder, voice) {
        let words = failure.message();
        tell!("warning: {}", words.strip_prefix("error: ").unwrap_or(&words));
    }
    Ok(())
}

/// Wound table and pictures, if the scene has them.
fn show(scene: &Scene, folder: &Path, voice: Voice) -> Result<(), Failure> {
    if scene.output.frames > 0 {
        let table = match (&scene.output.wound, voice) {
            (None, _) | (_, Voice::Json) => Ok(()),
            _ => wound::print(folder),
        };
        for picture in drawing::draw(folder)? {
            match voice {
                Voice::Json => event("picture", serde_json::json!({ "path": picture.display().to_string() })),
                _ => say!("picture        {}", picture.display()),
            }
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
