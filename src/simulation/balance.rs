//! Ranks share the work anew as it changes: patches move where their measured costs are borne evenly. No bit of the result
//! depends on it.
use super::{RunError, Simulation};
use engine::exec::ranks::collective;
use grid::Partition;

/// Steps in which work is weighed before patches may move.
const WEIGHED: u64 = 5;
/// Patches may move for the first time after so many steps: until then only the particles have been counted.
const FIRST: u64 = 10;
/// Time to pack, send and unpack a byte of a patch [ns].
const NS_A_BYTE: f64 = 1.0;
/// The gain over the price that makes a move worth while: costs are measured, and will change.
const WORTH: f64 = 2.0;

/// What balancing did so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// How often patches moved.
    pub moves: u64,
    /// Patches that moved.
    pub patches: u64,
    /// The largest cost of a rank over the mean, when it was weighed last.
    pub imbalance: f64,
}

/// Whether the load is looked at after `steps` steps.
fn due(steps: u64, every: u64) -> bool {
    steps == FIRST.min(every) || steps.is_multiple_of(every)
}

impl Simulation {
    /// What balancing did so far.
    pub fn balance(&self) -> Balance {
        self.balance
    }

    /// After a step: weighs the work of the next one, or moves patches, when it is time.
    pub(super) fn share_load(&mut self) -> Result<(), RunError> {
        let every = self.scene.run.rebalance_every;
        if every == 0 || self.network.size() == 1 {
            return Ok(());
        }
        if due(self.steps, every) {
            self.rebalance(every)?;
        }
        let soon = (1..=WEIGHED).any(|ahead| due(self.steps + ahead, every));
        self.engine.set_weighing(soon);
        Ok(())
    }

    fn rebalance(&mut self, every: u64) -> Result<(), RunError> {
        let [costs, bytes] = self.loads()?;
        let old = &self.warehouse.partition;
        self.balance.imbalance = old.imbalance(&costs);
        let (rank, ranks) = (old.rank, old.ranks);
        let new = Partition::by_cost(&self.warehouse.decomposition, &costs, rank, ranks)
            .map_err(RunError::Patches)?;
        let weighed = WEIGHED.min(self.steps).max(1) as f64;
        let mean = costs.iter().sum::<u64>() as f64 / ranks as f64 / weighed;
        let gain = (old.imbalance(&costs) - new.imbalance(&costs)) * mean * every as f64;
        let moves: Vec<usize> = (0..costs.len()).filter(|&p| old.rank_of(p) != new.rank_of(p)).collect();
        let price = busiest(&moves, old, &new, &bytes) * NS_A_BYTE;
        if moves.is_empty() || gain < WORTH * price {
            return Ok(());
        }
        tracing::info!(
            patches = moves.len(),
            imbalance = self.balance.imbalance,
            then = new.imbalance(&costs),
            "patches change their rank"
        );
        self.balance.moves += 1;
        self.balance.patches += moves.len() as u64;
        let Self { engine, warehouse, network, .. } = self;
        Ok(engine.migrate(new, warehouse, &mut **network)?)
    }

    /// What each patch cost since it was weighed last [ns], and its bytes; the same on all ranks.
    fn loads(&mut self) -> Result<[Vec<u64>; 2], RunError> {
        let Self { warehouse, network, .. } = self;
        let patches = warehouse.particles.len();
        let mut loads = vec![0; 2 * patches];
        let (costs, bytes) = loads.split_at_mut(patches);
        for patch in warehouse.partition.mine().collect::<Vec<_>>() {
            costs[patch] = warehouse.take_cost(patch);
            let blocks = warehouse.particles[patch].iter().flat_map(|home| &home.blocks);
            bytes[patch] = blocks.map(|block| block.bytes() as u64).sum();
        }
        collective::sum(&mut **network, &mut loads)?;
        let bytes = loads.split_off(patches);
        Ok([loads, bytes])
    }
}

/// The most bytes that a rank sends and receives.
fn busiest(moves: &[usize], old: &Partition, new: &Partition, bytes: &[u64]) -> f64 {
    let mut traffic = vec![0; old.ranks];
    for &patch in moves {
        traffic[old.rank_of(patch)] += bytes[patch];
        traffic[new.rank_of(patch)] += bytes[patch];
    }
    traffic.into_iter().max().unwrap_or(0) as f64
}
