//! The model of this machine against what was measured on it.
use super::footprint::Footprint;
use super::load::{Listed, Ranks, coming};
use super::model::{Cluster, Costs, Setup};
use super::predict::simulate;
use super::row::Row;
use grid::{Decomposition, Level};
use serde::Serialize;

/// A measured row and the model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Patches.
    pub patches: usize,
    /// Threads a rank.
    pub threads: usize,
    /// Ranks.
    pub ranks: usize,
    /// A step [ms], the best measured.
    pub measured_ms: f64,
    /// A step of the model [ms].
    pub model_ms: f64,
    /// Model over measured, less one.
    pub error: f64,
    /// What a rank sends in a step [B], measured.
    pub measured_bytes: f64,
    /// The same in the model, from the blocks with which the scene begins.
    pub model_bytes: f64,
    /// Whether the model was fitted to this row.
    pub fitted: bool,
}

/// Steps of the model, for all measured rows of the scene itself on no more workers than `cores`: where more take turns,
/// the model says nothing.
///
/// # Errors
/// Rows that the model cannot cut.
pub fn validate(
    footprint: &Footprint,
    level: &Level,
    rows: &[Row],
    setup: &Setup<'_>,
    (fitted, cores): (Option<usize>, usize),
) -> Result<Vec<Check>, String> {
    let mut checks = Vec::new();
    let fits = |row: &Row| row.error.is_none() && row.workers() <= cores;
    for (number, row) in rows.iter().enumerate().filter(|(_, row)| fits(row)) {
        let patches = Decomposition::new(level, row.grid)?;
        // one worker has the machine to itself
        let contention = if row.workers() > 1 { setup.costs.contention } else { 1.0 };
        let costs = Costs { contention, ..setup.costs.clone() };
        let cluster = Cluster { ranks: row.ranks.max(1), noise: 0.0, ..setup.cluster };
        let setup = Setup { costs, cluster, threads: row.threads, ..setup.clone() };
        let listed = footprint.ranks(&patches, row.ranks, &setup)?;
        let (model_ms, measured_ms) = (1e3 * simulate(&listed, &setup).step, row.step_ms[0]);
        checks.push(Check {
            patches: row.patches,
            threads: row.threads,
            ranks: row.ranks,
            measured_ms,
            model_ms,
            error: model_ms / measured_ms - 1.0,
            measured_bytes: row.parts.bytes,
            model_bytes: bytes(&listed, &setup),
            fitted: fitted == Some(number),
        });
    }
    Ok(checks)
}

/// What a mean rank sends in a step [B]: what comes to one.
fn bytes(ranks: &Listed, setup: &Setup<'_>) -> f64 {
    let coming = setup.step.ticks.iter().map(|&kind| coming(ranks, setup.step.graph.exchanges.len(), kind));
    coming.flatten().flatten().map(|it| f64::from(it.bytes)).sum::<f64>() / ranks.count() as f64
}

/// The largest error of a row that the model was not fitted to.
pub fn largest(checks: &[Check]) -> Option<&Check> {
    let free = checks.iter().filter(|check| !check.fitted);
    free.max_by(|a, b| a.error.abs().total_cmp(&b.error.abs()))
}
