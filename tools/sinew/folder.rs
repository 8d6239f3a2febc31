//! The folder of a run: chosen, and taken before anything in it is touched.
use super::args::RunArgs;
use super::fail::Failure;
use engine::exec::ranks::Network;
use sinew::output::Error;
use sinew::output::claim::Claim;
use sinew::output::together::path_from_first;
use sinew::simulation::RunError;
use sinew::simulation::recorder::{Held, held, is_result};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// A folder that is this run's as long as this lives.
pub struct Taken {
    /// The folder, on all ranks.
    pub path: PathBuf,
    /// On rank 0.
    pub claim: Option<Rc<Claim>>,
}

/// For a new run of the scene that was read from `scene` and is called `name`.
pub fn begin(args: &RunArgs, scene: &Path, name: &str, network: &mut dyn Network) -> Result<Taken, Failure> {
    let choose = || match &args.out {
        Some(folder) => claim(folder, scene, args.force).map(|claim| (folder.clone(), claim)),
        None => first_free(name, scene, args.force),
    };
    agree(network, choose)
}

/// For a run that goes on.
pub fn resume(folder: &Path, network: &mut dyn Network) -> Result<Taken, Failure> {
    let choose = || match folder.is_dir() {
        true => {
            Ok((folder.to_owned(), take(folder, "copy the run to where you may write, and go on there")?))
        }
        false => Err(Failure::usage(format!(
            "there is no folder {}: name that of a run that left a checkpoint",
            folder.display()
        ))),
    };
    agree(network, choose)
}

/// Rank 0 chooses.
fn agree(
    network: &mut dyn Network,
    choose: impl FnOnce() -> Result<(PathBuf, Claim), Failure>,
) -> Result<Taken, Failure> {
    let chosen = if network.rank() == 0 { choose().map(Some) } else { Ok(None) };
    let (path, claim) = super::ranks::agree(network, chosen)?.unzip();
    let path = path_from_first(network, &path.unwrap_or_default()).map_err(RunError::from)?;
    Ok(Taken { path, claim: claim.map(Rc::new) })
}

/// `runs/NAME`, or the first of `runs/NAME-2`, `runs/NAME-3`, … that nobody has and that holds no run; with `force` always
/// the first.
fn first_free(name: &str, scene: &Path, force: bool) -> Result<(PathBuf, Claim), Failure> {
    let first = Path::new("runs").join(name);
    if force {
        return claim(&first, scene, force).map(|claim| (first, claim));
    }
    let numbered = (2..1_000_000).map(|n| Path::new("runs").join(format!("{name}-{n}")));
    let mut last = None;
    for folder in std::iter::once(first).chain(numbered).filter(|folder| held(folder) == Held::Nothing) {
        match claim(&folder, scene, force) {
            Ok(claim) => return Ok((folder, claim)),
            // another run has just taken it, or has come and gone
            Err(error) if matches!(error, Failure::Taken(_)) || held(&folder) == Held::Run => {
                last = Some(error)
            }
            Err(error) => return Err(error),
        }
    }
    Err(last.unwrap_or_else(|| Failure::usage("runs/ is full: choose a folder with --out")))
}

/// Takes a folder that holds no run, or any run's with `force`, and never that of the scene.
fn claim(folder: &Path, scene: &Path, force: bool) -> Result<Claim, Failure> {
    refuse_scene(folder, scene)?;
    refuse_held(folder, force)?;
    std::fs::create_dir_all(folder).map_err(|error| not_writable(folder, &error, ELSEWHERE))?;
    let claim = take(folder, ELSEWHERE)?;
    // another run may have come and gone in the meantime
    refuse_held(folder, force)?;
    Ok(claim)
}

/// Refuses to replace a file that a run has left by another one that a user asks for.
pub fn refuse_result(file: &Path) -> Result<(), Failure> {
    match is_result(file) {
        false => Ok(()),
        true => Err(Failure::usage(format!(
            "{} is a file of a run, which this would replace: write to another file",
            file.display()
        ))),
    }
}

/// What helps a run whose folder cannot be written.
const ELSEWHERE: &str = "choose another folder with --out";

/// Takes a folder; `remedy` is what helps, if it cannot be written.
fn take(folder: &Path, remedy: &str) -> Result<Claim, Failure> {
    Claim::take(folder).map_err(|error| match error {
        Error::Io { source, .. } => not_writable(folder, &source, remedy),
        taken => Failure::Taken(taken.to_string()),
    })
}

fn not_writable(folder: &Path, error: &std::io::Error, remedy: &str) -> Failure {
    Failure::usage(format!("cannot write to {}: {error}; {remedy}", folder.display()))
}

fn refuse_held(folder: &Path, force: bool) -> Result<(), Failure> {
    match held(folder) {
        Held::Nothing => Ok(()),
        Held::Run if force => Ok(()),
        Held::Run => Err(Failure::usage(format!(
            "{} already holds a run: choose another folder with --out, or overwrite it with --force",
            folder.display()
        ))),
        Held::Scene => Err(Failure::usage(format!(
            "{0} holds a scene.toml that no run has left there, and the results would replace it: choose another folder with \
             --out, or move {0}/scene.toml away",
            folder.display()
        ))),
    }
}

/// The files of a run would replace the scene that it is of.
fn refuse_scene(folder: &Path, scene: &Path) -> Result<(), Failure> {
    let file = if scene.is_dir() { scene.join("scene.toml") } else { scene.to_owned() };
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    let its = real(&file).and_then(|file| file.parent().map(Path::to_owned));
    if its.is_some() && its == real(folder) {
        return Err(Failure::usage(format!(
            "{} is the folder of the scene, which the results would replace: choose another folder with --out",
            folder.display()
        )));
    }
    Ok(())
}
