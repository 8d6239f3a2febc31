//! A state kept in memory, so that a run that fails leaves a checkpoint of shortly before.
use crate::output;
use crate::output::checkpoint::{self, Recorded};
use crate::simulation::{Kept, Simulation};
use std::path::Path;
use std::time::Instant;

/// Keeping takes at most one part in so many of the time.
const SHARE: f64 = 100.0;
/// Of the memory that is free, which it may take at most one part in so many.
const MEMORY: usize = 4;

/// The last state that was kept.
#[derive(Debug)]
pub struct Backup {
    kept: Option<Kept>,
    last: Instant,
    /// Seconds that the last one took.
    took: f64,
}

impl Backup {
    /// Without one: a run that fails at once has its start.
    pub fn new() -> Self {
        Self { kept: None, last: Instant::now(), took: 0.0 }
    }

    /// Whether this rank's clock and memory say that it is time for another one.
    pub fn is_due(&self, simulation: &Simulation) -> bool {
        // asked only of a clock that says yes: the system is not asked for its memory at every step
        let fits = || {
            let free = crate::input::available_memory().unwrap_or(usize::MAX);
            simulation.bytes().0 < free / MEMORY
        };
        self.last.elapsed().as_secs_f64() > SHARE * self.took && fits()
    }

    /// Keeps the state between two steps, in place of the one before. All ranks call it.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn keep(&mut self, simulation: &mut Simulation, recorded: Recorded) -> output::Result<()> {
        let began = Instant::now();
        // never two of them at a time
        self.kept = None;
        self.kept = Some(simulation.keep(recorded)?);
        (self.last, self.took) = (Instant::now(), began.elapsed().as_secs_f64());
        Ok(())
    }

    /// Writes what was kept, if no checkpoint is later and the files that it counts on are there. All ranks call it.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(
        self,
        folder: &Path,
        simulation: &mut Simulation,
        there: impl Fn(&Recorded) -> bool,
    ) -> output::Result<()> {
        let Some(kept) = self.kept.filter(|kept| there(kept.recorded())) else { return Ok(()) };
        let path = checkpoint::path(folder, kept.steps());
        let mut later = [u64::from(simulation.network().rank() == 0 && is_there(folder, &path))];
        engine::exec::ranks::collective::sum(simulation.network(), &mut later)?;
        if later[0] == 0 {
            kept.write(folder, simulation.network())?;
        }
        Ok(())
    }
}

/// Whether a folder has this checkpoint, or a later one.
fn is_there(folder: &Path, path: &Path) -> bool {
    checkpoint::list(folder).first().is_some_and(|last| last.as_path() >= path)
}
