//! The same simulation on other workers, and what its steps take.
use super::{RunError, Simulation, backend};
use engine::exec::Engine;
use engine::exec::meter::Tally;
use simd::Isa;

impl Simulation {
    /// Goes on from here on `threads` threads and another instruction set, with the same patches. The first step after it
    /// meets cold scratch memory.
    ///
    /// # Errors
    /// Threads that do not start.
    pub fn go_on_with(&mut self, threads: usize, isa: Isa) -> Result<(), RunError> {
        self.engine = Engine::new(backend(threads)?, isa, &self.warehouse);
        Ok(())
    }

    /// Meters steps from now on, or stops that.
    pub fn set_meter(&mut self, on: bool) {
        self.engine.set_meter(on);
    }

    /// What the steps since [`Simulation::set_meter`] took, summed over workers.
    pub fn take_meter(&self) -> Tally {
        self.engine.take_meter()
    }
}
