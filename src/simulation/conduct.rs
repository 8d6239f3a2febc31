//! What a simulation looks at and decides after each graph.
use super::fault::{self, RunError};
use super::leaving;
use super::ledger::Ledger;
use engine::data::rates::Clock;
use engine::data::shared::Shared;
use engine::data::warehouse::{MaterialData, Warehouse};
use engine::exec::Conductor;
use engine::exec::ranks::NetworkError;
use engine::exec::relocate::Relocation;
use engine::exec::traveler::Traveler;
use engine::graph::build::TaskGraph;
use engine::program::Loop;
use engine::schema::Label;
use grid::Level;
use scene::{Leaving, Scene};
use simd::Wide;
use tasks::labels::{RigidSolved, StepOver, Time};

/// Conducts a program of a simulation.
pub struct Direction<'a> {
    /// What is simulated.
    pub scene: &'a Scene,
    /// The grid.
    pub level: Level,
    /// The accounts.
    pub ledger: &'a mut Ledger,
    /// Particles moved so far.
    pub updates: &'a mut u64,
    /// Number of the step.
    pub step: u64,
    /// The clock before the graph that runs.
    pub clock: Clock,
    /// Whether the step has become too long for whoever waits for its end.
    pub impatient: &'a mut Impatience,
}

/// Asked after each tick: whether the run shall end in the middle of a step.
pub type Impatience = Box<dyn FnMut() -> bool + Send>;

impl Conductor for Direction<'_> {
    type Error = RunError;

    fn puts_back(
        &mut self,
        particle: &mut Traveler,
        materials: &[MaterialData],
        shared: &mut Shared,
    ) -> bool {
        let back = self.scene.run.leaving == Leaving::Reflect && !self.is_whole(particle);
        if back {
            leaving::mirror(self.scene, &self.level, particle, materials, shared);
        }
        back
    }

    fn wants_to_stop(&mut self) -> bool {
        (self.impatient)()
    }

    fn ran(
        &mut self,
        graph: &TaskGraph,
        warehouse: &Warehouse,
        relocation: &Relocation,
    ) -> Result<(), RunError> {
        let before = std::mem::replace(&mut self.clock, warehouse.shared.get(Time::ID, 0));
        let ticks = graph.computes(StepOver::ID);
        if ticks {
            self.check_step(&before)?;
        }
        fault::find(self.scene, warehouse, before.time, self.step).map_or(Ok(()), Err)?;
        self.ledger.add(graph, &warehouse.shared);
        self.count(relocation, &warehouse.materials)?;
        // at the end of a step there is something to go on from
        let over = ticks && warehouse.shared.get::<Wide>(StepOver::ID, 0).0[0] > 0.0;
        if relocation.stopped && !over { Err(RunError::Stopped { step: self.step }) } else { Ok(()) }
    }

    fn looped(
        &mut self,
        looped: &Loop,
        rounds: u64,
        enough: bool,
        warehouse: &Warehouse,
    ) -> Result<(), RunError> {
        match (enough, looped.until) {
            (true, _) => Ok(()),
            (false, until) if until == RigidSolved::ID => {
                Err(fault::unfound(self.scene, warehouse, rounds, self.step))
            }
            (false, until) => Err(RunError::Rounds { until: until.name(), rounds, step: self.step }),
        }
    }
}

/// Conducts a report, which decides nothing.
pub struct Reporting;

impl Conductor for Reporting {
    type Error = NetworkError;
}

impl Direction<'_> {
    /// Whether the step that began at `before` did not collapse.
    fn check_step(&self, before: &Clock) -> Result<(), RunError> {
        // what limits the step was decided in it
        let clock = Clock { time: before.time, ..self.clock };
        if clock.tick > 0.0 && (clock.tick >= self.scene.run.smallest_step || clock.limited_by < 0.0) {
            return Ok(());
        }
        Err(fault::collapsed(self.scene, &clock, self.step))
    }

    /// Whether a particle is part of a free rigid body.
    fn is_whole(&self, particle: &Traveler) -> bool {
        self.scene.materials[particle.material].is_free()
    }

    fn count(&mut self, relocation: &Relocation, materials: &[MaterialData]) -> Result<(), RunError> {
        *self.updates += relocation.particles;
        self.ledger.reflect(relocation.reflected);
        if let Some(particle) = relocation.left().iter().find(|particle| self.is_whole(particle)) {
            return Err(fault::escaped(self.scene, particle, self.clock.time));
        }
        if let Some(first) = relocation.left().first() {
            if self.scene.run.leaving == Leaving::Error {
                let (number, time) = (relocation.left().len(), self.clock.time);
                return Err(fault::left(self.scene, first, number, time));
            }
            relocation.left().iter().for_each(|particle| self.ledger.delete(particle, materials));
        }
        Ok(())
    }
}
