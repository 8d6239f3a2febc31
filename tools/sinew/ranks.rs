//! A command as one of several ranks.
use super::fail::Failure;
use super::greet::greet;
use super::say::tell;
use engine::exec::ranks::launch::{self, Launch, Machine};
use engine::exec::ranks::{Network, NetworkError, collective};
use scene::Scene;
use simd::Isa;
use sinew::input::Written;
use sinew::input::identity::first_difference;
use sinew::output::together::path_from_first;
use sinew::simulation::start::memory::of_all_machines;
use std::path::Path;

/// The ranks that were launched together.
pub struct Crew {
    /// Them.
    pub network: Box<dyn Network>,
    /// What this one finds where it runs.
    pub site: Machine,
    /// The instruction set that all take.
    pub isa: Isa,
}

impl Crew {
    /// Connects this process with those that were launched with it. All of them must be the same: see [`greet`].
    pub fn meet() -> Result<Self, Failure> {
        let launch = Launch::of_this_process();
        let found = launch.connect().map_err(|problem| match launch.rank {
            0 => Failure::usage(problem),
            // the others may be waiting already: its status ends them
            _ => Failure::Local(problem),
        });
        let (mut network, site) = found?;
        let isa = greet(&mut *network)?;
        Ok(Self { network, site, isa })
    }

    /// The host of this rank, where ranks run on several: there a path alone does not say where a file lies.
    pub fn host(&self) -> Option<String> {
        (self.site.ranks < self.network.size()).then(launch::host)
    }
}

/// Where something lies: `path`, or `host:/whole/path`.
pub fn place(host: Option<&str>, path: &Path) -> String {
    match host {
        Some(host) => {
            let whole = std::path::absolute(path);
            format!("{host}:{}", whole.as_deref().unwrap_or(path).display())
        }
        None => path.display().to_string(),
    }
}

/// A rank and where it runs, for messages of ranks that rank 0 may be far from.
pub fn named(rank: usize) -> String {
    format!("rank {rank} (host {})", launch::host())
}

/// Gives the scene its threads, if nobody asked for a number, and says what stands in their way. None goes on where MPI
/// forbids threads to one of them.
pub fn share_cores(scene: &mut Scene, site: Machine, network: &mut dyn Network) -> Result<(), Failure> {
    let (threads, note) = launch::threads(scene.run.threads, site.ranks);
    scene.run.threads = Some(threads);
    agree(network, launch::admit(site.threading, threads).map_err(Failure::usage))?;
    if let (0, Some(note)) = (network.rank(), note) {
        tell!("note: {note}");
    }
    Ok(())
}

pub fn lost(error: NetworkError) -> Failure {
    Failure::Local(error.to_string())
}

/// The outcome of something that all ranks tried: none goes on if one failed, and only the first that did tells it.
pub fn agree<T>(network: &mut dyn Network, mine: Result<T, Failure>) -> Result<T, Failure> {
    if network.size() == 1 {
        return mine;
    }
    let problem = mine.as_ref().err().map(Failure::message);
    match collective::first_error(network, problem.as_deref()).map_err(lost)? {
        Some((first, _)) if first != network.rank() => Err(Failure::Elsewhere),
        // who fails alone says so; what rank 0 knows, it says at its end
        Some((first, problem)) if first > 0 => mine.map_err(|failure| {
            tell!("on {}: {problem}", named(first));
            Failure::Told(failure.status())
        }),
        _ => mine,
    }
}

/// The scene that rank 0 has found, with what is changed in it, on all ranks. The files of its meshes all must see.
pub fn scene(
    network: &mut dyn Network,
    find: impl FnOnce() -> Result<Written, Failure>,
    overrides: &[(String, String)],
) -> Result<Scene, Failure> {
    let found = if network.rank() == 0 { find().map(Some) } else { Ok(None) };
    let Written { file, text } = agree(network, found)?.unwrap_or_default();
    let file = path_from_first(network, &file).map_err(lost)?;
    let text = text_from_first(network, &text)?;
    let memory = of_all_machines(network).map_err(lost)?;
    let scene = agree(network, Written { file, text }.scene_in(overrides, memory).map_err(Failure::from))?;
    let first = text_from_first(network, &scene.resolved)?;
    // under one path there may be other meshes
    let differs = first_difference(&first, &scene.resolved).map(|difference| {
        Failure::usage(format!(
            "the scene is not that of rank 0: {difference}. All ranks read the files of meshes: put the same ones under one \
             path on all hosts"
        ))
    });
    agree(network, differs.map_or(Ok(scene), Err))
}

fn text_from_first(network: &mut dyn Network, text: &str) -> Result<String, Failure> {
    let bytes = collective::bytes_from_first(network, text.as_bytes()).map_err(lost)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
