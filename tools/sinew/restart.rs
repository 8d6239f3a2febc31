//! `sinew run --restart`: from the last whole checkpoint on.
use super::args::RunArgs;
use super::fail::Failure;
use super::folder::{self, Taken};
use super::progress::seconds;
use super::ranks::{self, Crew};
use super::say::{say, tell};
use super::voice::{Voice, event};
use engine::exec::ranks::collective;
use scene::Scene;
use simd::Isa;
use sinew::input::Written;
use sinew::input::identity::first_difference;
use sinew::output::checkpoint::{Reader, VERSION};
use sinew::output::summary::{Status, Summary};
use sinew::simulation::recorder::{Recorder, last_checkpoint};
use sinew::simulation::{RunError, Simulation};
use std::path::Path;

/// The run in `folder`, where its last whole checkpoint left it; `None`: it is complete.
pub fn resume(
    args: &RunArgs,
    folder: &Path,
    Crew { mut network, site, isa }: Crew,
) -> Result<Option<(Taken, Simulation, Recorder)>, Failure> {
    let first = network.rank() == 0;
    let taken = folder::resume(folder, &mut *network)?;
    let folder = &*taken.path;
    let warn = |warnings: &[String]| warnings.iter().filter(|_| first).for_each(|w| tell!("warning: {w}"));
    let last = last_checkpoint(&mut *network, folder).map_err(Failure::usage);
    let (checkpoint, found) = ranks::agree(&mut *network, last)?;
    warn(&found.warnings);
    let overrides = ranks::agree(&mut *network, args.changes.overrides())?;
    let written = || written(args, folder, &checkpoint);
    let mut scene = ranks::scene(&mut *network, written, &overrides)?;
    scene.name.clone_from(&checkpoint.head.name);
    ranks::agree(&mut *network, same(&checkpoint, &scene, isa, args.force))?;
    let complete = first && is_complete(folder, &scene, &checkpoint);
    if collective::bytes_from_first(&mut *network, &[complete.into()]).map_err(RunError::from)? == [1] {
        if first {
            let steps = scene.run.steps.filter(|most| checkpoint.head.steps >= *most);
            let bound = steps.map_or("run.until (--until)", |_| "run.steps (--steps)");
            let words = format!(
                "{} is complete: {} steps, {}, where {bound} ends it; go further with a later one",
                folder.display(),
                checkpoint.head.steps,
                seconds(checkpoint.head.time)
            );
            match args.loudness.voice() {
                Voice::Json => event(
                    "complete",
                    serde_json::json!({ "text": words, "folder": folder.display().to_string() }),
                ),
                _ => say!("{words}"),
            }
        }
        network.part(None);
        return Ok(None);
    }
    ranks::share_cores(&mut scene, site, &mut *network)?;
    let mut simulation = Simulation::restore(network, scene, isa, &checkpoint)?;
    let recorder = Recorder::resume(folder, &mut simulation, &checkpoint.head, &found);
    let (mut recorder, warnings) = recorder.map_err(Failure::usage)?;
    recorder.guard(taken.claim.clone());
    warn(&warnings);
    if simulation.clock().limited_by < 0.0 && !simulation.finished() {
        warn(&["the last step before was cut short, because the run ended with it: from here on steps are not those of a run \
                that was never stopped"
            .into()]);
    }
    if first && matches!(args.loudness.voice(), Voice::Plain | Voice::Verbose) {
        tell!("goes on from {}", found.path.display());
    }
    Ok(Some((taken, simulation, recorder)))
}

/// Whether a run has come to the end that the scene asks for, and has said so.
fn is_complete(folder: &Path, scene: &Scene, checkpoint: &Reader) -> bool {
    let head = &checkpoint.head;
    let at_end = head.time >= scene.run.until || scene.run.steps.is_some_and(|most| head.steps >= most);
    let summary = Summary::read(&folder.join("summary.json"));
    let run = head.recorded.run.to_string();
    let says_so = |it: Summary| {
        it.status == Status::Completed
            && it.steps == head.steps
            && it.more.get("run").is_some_and(|its| *its == run)
    };
    at_end && summary.is_ok_and(says_so)
}

/// The scene that is given, that of the folder, or that of the checkpoint.
fn written(args: &RunArgs, folder: &Path, checkpoint: &Reader) -> Result<Written, Failure> {
    let beside = folder.join("scene.toml");
    Ok(match &args.scene {
        Some(given) => Written::read(given)?,
        None if beside.is_file() => Written::read(&beside)?,
        None => Written { file: checkpoint.path().to_owned(), text: checkpoint.head.scene.clone() },
    })
}

/// Refuses a checkpoint from which a run of this scene would not go on bit for bit.
fn same(checkpoint: &Reader, scene: &Scene, isa: Isa, force: bool) -> Result<(), Failure> {
    let (head, file) = (&checkpoint.head, checkpoint.path().display());
    if let Some(difference) = first_difference(&head.scene, &scene.resolved) {
        return Err(Failure::usage(format!(
            "{file} is a checkpoint of another scene: {difference}. A restart may change run.until, run.steps, run.leaving, \
             run.threads, run.patches and what is in [output], but not output.fields; for another scene begin another run"
        )));
    }
    for (what, there, here) in
        [("version", head.version.as_str(), VERSION), ("instruction set", head.isa.as_str(), isa.name())]
    {
        if there != here && !force {
            return Err(Failure::usage(format!(
                "{file} is from {what} {there}, this is {here}: the bits would differ from those of a run that was never \
                 stopped. Go on with the same {what}{}, or with --force",
                if what == "version" { "" } else { " (SINEW_ISA)" }
            )));
        }
    }
    Ok(())
}
