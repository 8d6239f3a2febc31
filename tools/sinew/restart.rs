//! `sinew run --restart`: from the last whole checkpoint on.
use super::args::RunArgs;
use super::fail::Failure;
use super::ranks;
use engine::exec::ranks::Network;
use engine::exec::ranks::launch::Machine;
use scene::Scene;
use simd::Isa;
use sinew::input::identity::first_difference;
use sinew::output::checkpoint::{Reader, VERSION};
use sinew::simulation::Simulation;
use sinew::simulation::recorder::{Recorder, last_checkpoint};
use std::path::{Path, PathBuf};

/// The run in `folder`, where its last whole checkpoint left it.
pub fn resume(
    args: &RunArgs,
    folder: &Path,
    isa: Isa,
    mut network: Box<dyn Network>,
    site: Machine,
) -> Result<(PathBuf, Simulation, Recorder), Failure> {
    let first = network.rank() == 0;
    let warn =
        |warnings: &[String]| warnings.iter().filter(|_| first).for_each(|w| eprintln!("warning: {w}"));
    let last = last_checkpoint(&mut *network, folder).map_err(Failure::usage);
    let (checkpoint, found) = ranks::agree(&mut *network, last)?;
    warn(&found.warnings);
    let scene = scene(args, folder, &checkpoint)
        .and_then(|scene| same(&checkpoint, &scene, isa, args.force).map(|()| scene));
    let mut scene = ranks::agree(&mut *network, scene)?;
    ranks::share_cores(&mut scene, site, &mut *network)?;
    let mut simulation = Simulation::restore(network, scene, isa, &checkpoint)?;
    let recorder = Recorder::resume(folder, &mut simulation, &checkpoint.head, &found.damaged);
    let (recorder, warnings) = recorder.map_err(Failure::usage)?;
    warn(&warnings);
    if first && !args.quiet {
        eprintln!("goes on from {}", found.path.display());
    }
    Ok((folder.to_owned(), simulation, recorder))
}

/// The scene that is given, that of the folder, or that of the checkpoint, with the changes of the command line.
fn scene(args: &RunArgs, folder: &Path, checkpoint: &Reader) -> Result<Scene, Failure> {
    let overrides = args.changes.overrides()?;
    let written = folder.join("scene.toml");
    let mut scene = match &args.scene {
        Some(given) => sinew::input::read(given, &overrides)?,
        None if written.exists() => sinew::input::read(&written, &overrides)?,
        None => {
            let memory = sinew::input::available_memory();
            let name = checkpoint.path().display().to_string();
            sinew::input::read_text(&name, &checkpoint.head.scene, &overrides, memory)?
        }
    };
    scene.name.clone_from(&checkpoint.head.name);
    Ok(scene)
}

/// Refuses a checkpoint from which a run of this scene would not go on bit for bit.
fn same(checkpoint: &Reader, scene: &Scene, isa: Isa, force: bool) -> Result<(), Failure> {
    let (head, file) = (&checkpoint.head, checkpoint.path().display());
    if let Some(difference) = first_difference(&head.scene, &scene.resolved) {
        return Err(Failure::usage(format!(
            "{file} is a checkpoint of another scene: {difference}. A restart may change run.until, run.steps, run.threads, \
             run.patches and what is in [output]; for another scene begin another run"
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
