//! Failure, as history and summary have it: the states and events of these names, whichever law declares them.
use super::report::{FirstEvent, MaterialReport, Report};
use crate::output::summary::Failed;

/// States that count as failure: the matrix alone, the fibers alone, both, both by inversion. A particle is in one of them
/// at most.
pub const STATES: [&str; 4] = ["matrix", "fiber", "total", "crushed"];
/// Events that are a failure.
pub const EVENTS: [&str; 2] = ["matrix", "fiber"];

/// Whether a state counts as failure.
pub fn is_one(state: &str) -> bool {
    STATES.contains(&state)
}

/// Whether the law of a material knows failure.
pub fn known(material: &MaterialReport) -> bool {
    material.counts.iter().any(|(state, _)| is_one(state))
}

/// Failed particles of some materials over their particles.
pub fn fractions(materials: &[&MaterialReport]) -> Failed {
    let particles = materials.iter().map(|m| m.particles).sum::<u64>().max(1) as f64;
    let share = |state| materials.iter().map(|m| m.count(state)).sum::<u64>() as f64 / particles;
    let [matrix, fiber, total, crushed] = STATES.map(share);
    let total = total + crushed;
    Failed { matrix, fiber, total, any: matrix + fiber + total }
}

/// Particles of all materials that are in a state.
pub fn total(report: &Report, state: &str) -> u64 {
    report.materials.iter().map(|m| m.count(state)).sum()
}

/// The first event of a name in any material.
pub fn first(report: &Report, event: &str) -> Option<FirstEvent> {
    let all = report.materials.iter().flat_map(|m| &m.first).filter(|(name, _)| *name == event);
    all.filter_map(|(_, first)| *first).min_by(|a, b| a.time.total_cmp(&b.time))
}
