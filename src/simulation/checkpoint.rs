//! A run's state into a checkpoint, and out of it.
use super::fault::RunError;
use super::start::Roll;
use super::{Ledger, Simulation, populate};
use crate::output;
use crate::output::checkpoint::{self, Head, Part, Reader, Recorded, VERSION};
use engine::data::rates::Clock;
use engine::data::warehouse::Warehouse;
use engine::exec::ranks::{Network, collective};
use engine::schema::Label;
use scene::Scene;
use simd::Isa;
use std::path::Path;
use tasks::labels::{Reactions, Time};

/// A state that is kept in memory, in case that a later step fails.
#[derive(Debug)]
pub struct Kept {
    head: Head,
    /// This rank's.
    parts: Vec<Part>,
}

impl Kept {
    /// Steps taken until then.
    pub fn steps(&self) -> u64 {
        self.head.steps
    }

    /// How far the files of the run had come.
    pub fn recorded(&self) -> &Recorded {
        &self.head.recorded
    }

    /// Writes it as a checkpoint, from rank 0. All ranks call it.
    ///
    /// # Errors
    /// If the file cannot be written: on all ranks.
    pub fn write(self, folder: &Path, network: &mut dyn Network) -> output::Result<()> {
        let Self { head, parts } = self;
        let path = checkpoint::path(folder, head.steps);
        checkpoint::write(network, |give| parts.into_iter().for_each(give), &path, &head)
    }
}

impl Simulation {
    /// Writes `checkpoint-NNNNNNNN.h5` into a folder, from rank 0. All ranks call it, between two steps.
    ///
    /// # Errors
    /// If the file cannot be written: on all ranks.
    pub fn write_checkpoint(&mut self, folder: &Path, recorded: Recorded) -> output::Result<()> {
        let head = self.checkpoint_head(recorded)?;
        let path = checkpoint::path(folder, self.steps);
        let Self { warehouse, network, .. } = self;
        checkpoint::write(&mut **network, |give| checkpoint::parts(warehouse, give), &path, &head)
    }

    /// What a checkpoint would hold now, kept in memory. All ranks call it, between two steps.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn keep(&mut self, recorded: Recorded) -> output::Result<Kept> {
        let (head, mut parts) = (self.checkpoint_head(recorded)?, Vec::new());
        checkpoint::parts(&self.warehouse, &mut |part| parts.push(part));
        Ok(Kept { head, parts })
    }

    fn checkpoint_head(&mut self, recorded: Recorded) -> output::Result<Head> {
        let mut updates = [self.updates];
        collective::sum(self.network(), &mut updates)?;
        let mut head = Head {
            version: VERSION.into(),
            isa: self.isa().name().into(),
            name: self.scene.name.clone(),
            scene: self.scene.resolved.clone(),
            time: self.clock().time,
            steps: self.steps,
            updates: updates[0],
            recorded,
            ledger: self.ledger.numbers(),
            ..Head::default()
        };
        head.describe(&mut *self.network, &self.warehouse)?;
        Ok(head)
    }

    /// This rank's part of a simulation as a checkpoint of it says, on all ranks of `network`.
    ///
    /// # Errors
    /// Patches that do not fit, threads that do not start, or a checkpoint of something else.
    pub fn restore(
        network: Box<dyn Network>,
        scene: Scene,
        isa: Isa,
        from: &Reader,
    ) -> Result<Self, RunError> {
        let census = |_: &Scene, _: &Roll, _: &mut dyn Network| {
            let tables = (0..from.head.materials.len()).map(|m| from.blocks(m));
            let tables = tables.collect::<output::Result<Vec<_>>>()?;
            Ok(tables.iter().flatten().map(|b| (b.index, u64::from(b.count))).collect())
        };
        let fill = |scene: &Scene, roll: &Roll, warehouse: &mut Warehouse, _: &mut dyn Network, _| {
            checkpoint::fill(warehouse, from)?;
            populate::recall(scene, roll, warehouse);
            // the end of the run may be another one
            let clock: Clock = warehouse.shared.get(Time::ID, 0);
            warehouse.shared.set(Time::ID, 0, Clock { until: scene.run.until, ..clock });
            Ok(())
        };
        let mut simulation = Self::assemble(network, scene, isa, census, fill)?;
        let givers = simulation.warehouse.tiles.of(Reactions::ID, 0);
        simulation.ledger = Ledger::from_numbers(&from.head.ledger, simulation.scene.materials.len(), givers)
            .ok_or_else(|| from.wrong("its ledger is not one of this scene".into()))?;
        simulation.steps = from.head.steps;
        // counted by rank, added up for people
        simulation.updates = if simulation.network.rank() == 0 { from.head.updates } else { 0 };
        Ok(simulation)
    }
}
