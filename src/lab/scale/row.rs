//! A measured row: one combination of patches, threads and ranks.
use super::tally::{Rank, Tally};
use serde::Serialize;

/// Mean times of a step, and shares of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Parts {
    /// Time of the rank's engine outside tasks, communication and waiting: lists of blocks, locks, relocation [ms a step].
    pub overhead_ms: f64,
    /// Bytes that a rank sends in halos and relocation, a step.
    pub bytes: f64,
    /// Messages of the same.
    pub messages: f64,
    /// Time in tasks over the time of all workers.
    pub task_share: f64,
    /// Packing, sending and waiting for node data, over the step.
    pub halo_share: f64,
    /// Waiting for other ranks: for node data, travelers and reductions, over the step.
    pub wait_share: f64,
    /// Time of workers in which they do nothing: others of the rank work, or wait for other ranks.
    pub idle_share: f64,
    /// Task time of the rank that has most, over the mean.
    pub imbalance: f64,
}

impl Parts {
    /// The parts of a tally.
    pub fn of(tally: &Tally) -> Self {
        let (ranks, steps) = (&tally.ranks, tally.steps.max(1) as f64);
        let count = ranks.len().max(1) as f64;
        let sum = |part: &dyn Fn(&Rank) -> f64| ranks.iter().map(part).sum::<f64>();
        let span = sum(&|r| r.span).max(1.0);
        let workers_span = sum(&|r| r.span * r.workers as f64).max(1.0);
        let talk = sum(&|r| r.pack + r.halo + r.reduce);
        let tasks = sum(&|r| r.tasks[1]);
        let most = ranks.iter().map(|r| r.tasks[1]).fold(0.0, f64::max);
        let engine = sum(&Rank::engine);
        Self {
            overhead_ms: 1e-6 * engine / steps / count,
            bytes: sum(&|r| r.bytes as f64) / steps / count,
            messages: sum(&|r| r.messages as f64) / steps / count,
            task_share: tasks / workers_span,
            halo_share: sum(&|r| r.pack + r.halo) / span,
            wait_share: sum(&|r| r.halo + r.reduce) / span,
            idle_share: (1.0 - (tasks + talk + engine) / workers_span).max(0.0),
            imbalance: if tasks > 0.0 { most * count / tasks } else { 1.0 },
        }
    }
}

/// What was measured of one combination.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Row {
    /// Patches.
    pub patches: usize,
    /// Patches along each axis.
    pub grid: [usize; 3],
    /// Threads a rank.
    pub threads: usize,
    /// Ranks.
    pub ranks: usize,
    /// Why there is nothing else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// Particles.
    pub particles: u64,
    /// Cell [m].
    pub cell_m: f64,
    /// Milliseconds a step: the best and the median of the repetitions.
    pub step_ms: [f64; 2],
    /// Particle updates a second, of the best.
    pub updates_per_s: f64,
    /// Updates a second and worker over those of the first row.
    pub efficiency: f64,
    /// Time over that with the fewest patches on the same threads and ranks, less one.
    pub over_decomposition: f64,
    /// The parts of the best repetition.
    pub parts: Parts,
    /// Largest memory of a rank [B]; 0: unknown.
    pub peak_bytes: u64,
    /// State at the end.
    pub state_hash: String,
    /// Events that the trace lost: shares are wrong if there are any.
    pub lost: u64,
}

impl Row {
    /// Threads of all ranks.
    pub fn workers(&self) -> usize {
        self.threads * self.ranks
    }

    fn rate(&self) -> f64 {
        self.updates_per_s / self.workers().max(1) as f64
    }
}

/// Fills in what compares rows.
pub fn compare(rows: &mut [Row]) {
    let ok = |row: &&Row| row.error.is_none();
    let first = rows.iter().filter(ok).min_by_key(|row| (row.workers(), row.patches)).cloned();
    let all = rows.to_vec();
    for row in rows.iter_mut().filter(|row| row.error.is_none()) {
        row.efficiency = first.as_ref().map_or(0.0, |first| row.rate() / first.rate());
        let same = |other: &&Row| (other.threads, other.ranks) == (row.threads, row.ranks);
        let fewest = all.iter().filter(ok).filter(same).min_by_key(|other| other.patches);
        row.over_decomposition = fewest.map_or(0.0, |least| row.step_ms[0] / least.step_ms[0] - 1.0);
    }
}

/// Whether all rows of the same scene end in the same state; `None`: there is nothing to compare.
pub fn same_state(rows: &[Row]) -> Option<bool> {
    let done: Vec<&Row> = rows.iter().filter(|row| row.error.is_none()).collect();
    let pairs = || done.iter().zip(done.iter().skip(1)).filter(|(a, b)| a.cell_m == b.cell_m);
    (pairs().count() > 0).then(|| pairs().all(|(a, b)| a.state_hash == b.state_hash))
}
