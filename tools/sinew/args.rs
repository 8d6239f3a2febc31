//! What the command line says of a scene and of a run.
use super::fail::Failure;
use super::voice::Loudness;
use scene::Scene;
use std::path::PathBuf;

/// Which scene, with what changed.
#[derive(clap::Args)]
pub struct SceneArgs {
    /// Folder with a scene.toml, or a .toml file
    pub scene: PathBuf,
    #[command(flatten)]
    pub changes: Changes,
}

/// What is changed in a scene.
#[derive(clap::Args)]
pub struct Changes {
    /// Threads (default: all cores)
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Patches along x, y and z, for example 2x1x2, or in all, for example 16 (a run cuts eight a thread by itself)
    #[arg(long, value_name = "N|AxBxC")]
    pub patches: Option<String>,
    /// Stop after N steps
    #[arg(long, value_name = "N")]
    pub steps: Option<u64>,
    /// End of the simulated time, for example "0.2 ms"
    #[arg(long, value_name = "T")]
    pub until: Option<String>,
    /// Override a field of the scene, for example run.cfl=0.2 or material.tissue.c1="3 kPa"
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

impl SceneArgs {
    /// The scene with all overrides.
    pub fn read(&self) -> Result<Scene, Failure> {
        Ok(sinew::input::read(&self.scene, &self.changes.overrides()?)?)
    }
}

impl Changes {
    /// As pairs of key and value.
    pub fn overrides(&self) -> Result<Vec<(String, String)>, Failure> {
        let mut overrides = overrides(&self.set)?;
        let mut set = |key: &str, value: Option<String>| {
            overrides.extend(value.map(|value| (key.to_owned(), value)));
        };
        set("run.threads", self.threads.map(|n| n.to_string()));
        set("run.steps", self.steps.map(|n| n.to_string()));
        set("run.until", self.until.clone());
        let patches = |text: &String| match text.contains(['x', 'X']) {
            true => format!("[{}]", text.replace(['x', 'X'], ", ")),
            false => text.clone(),
        };
        set("run.patches", self.patches.as_ref().map(patches));
        Ok(overrides)
    }
}

/// Overrides of a command line as pairs of key and value.
pub fn overrides(set: &[String]) -> Result<Vec<(String, String)>, Failure> {
    let pair = |pair: &String| {
        let (key, value) = pair.split_once('=').ok_or_else(|| {
            Failure::usage(format!("--set {pair}: write it as KEY=VALUE, for example run.cfl=0.2"))
        })?;
        Ok((key.trim().to_owned(), value.trim().to_owned()))
    };
    set.iter().map(pair).collect()
}

/// Run a scene and leave a folder with summary, history, particle file, checkpoints and pictures
///
/// SIGINT (Ctrl-C), SIGTERM, SIGHUP and SIGUSR1 end a run after the step it is in, with a checkpoint; a second one ends it
/// at once. The exit status is then 130, 143, 129 or 138. mpirun leaves ranks a second after SIGINT and SIGTERM, but passes SIGUSR1 on and
/// waits.
#[derive(clap::Args)]
pub struct RunArgs {
    /// Folder with a scene.toml, or a .toml file
    #[arg(required_unless_present = "restart")]
    pub scene: Option<PathBuf>,
    #[command(flatten)]
    pub changes: Changes,
    /// Folder for the results (default: runs/NAME, or the first free of runs/NAME-2, runs/NAME-3, …)
    #[arg(long, value_name = "DIR", conflicts_with = "restart")]
    pub out: Option<PathBuf>,
    /// Go on with the run in DIR from its last whole checkpoint, bit for bit, on any patches, threads and ranks; run.until,
    /// run.steps, run.leaving and [output] may change, but for output.fields; the physics may not
    #[arg(long, value_name = "DIR")]
    pub restart: Option<PathBuf>,
    /// Stop with a checkpoint before so much time on the clock has passed, for example "23 h", as a batch system's limit
    /// demands; the exit status is then 124
    #[arg(long, value_name = "T")]
    pub wall: Option<String>,
    /// Overwrite a run that the folder holds; with --restart: go on although another version of Sinew or another instruction
    /// set wrote the checkpoint, with other bits
    #[arg(long)]
    pub force: bool,
    /// Write trace.json: what each thread of each rank does and waits for, for Perfetto (ui.perfetto.dev) and for
    /// sinew graph --trace
    #[arg(long)]
    pub trace: bool,
    #[command(flatten)]
    pub loudness: Loudness,
}
