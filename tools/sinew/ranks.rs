//! A command as one of several ranks.
use super::fail::Failure;
use engine::exec::ranks::launch::{self, Launch, Machine};
use engine::exec::ranks::{Network, NetworkError, collective};
use scene::Scene;

/// The ranks that were launched together, and what this one finds where it runs.
pub fn connect() -> Result<(Box<dyn Network>, Machine), Failure> {
    Launch::of_this_process().connect().map_err(Failure::usage)
}

/// Gives the scene its threads, if nobody asked for a number, and says what stands in their way. None goes on where MPI
/// forbids threads to one of them.
pub fn share_cores(scene: &mut Scene, site: Machine, network: &mut dyn Network) -> Result<(), Failure> {
    let (threads, note) = launch::threads(scene.run.threads, site.ranks);
    scene.run.threads = Some(threads);
    agree(network, launch::admit(site.threading, threads).map_err(Failure::usage))?;
    if let (0, Some(note)) = (network.rank(), note) {
        eprintln!("note: {note}");
    }
    Ok(())
}

fn lost(error: NetworkError) -> Failure {
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
            eprintln!("on rank {first}: {problem}");
            Failure::Told(failure.status())
        }),
        _ => mine,
    }
}

/// What rank 0 says, on all ranks.
pub fn from_first(
    network: &mut dyn Network,
    say: impl FnOnce() -> Result<String, Failure>,
) -> Result<String, Failure> {
    let said = if network.rank() == 0 { say() } else { Ok(String::new()) };
    let said = agree(network, said)?;
    collective::text_from_first(network, &said).map_err(lost)
}
