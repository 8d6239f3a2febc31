//! Shared labels on their way to workers, and what workers reduced on its way back.
use super::scratch::Scratch;
use super::work::lock;
use crate::data::reduction;
use crate::data::schedule::Schedule;
use crate::data::shared::Shared;
use crate::graph::phase::Phase;
use crate::schema::{Home, LabelId};
use std::sync::Mutex;

/// Gives every worker the shared labels that the phases read, and nothing yet of those that they reduce.
pub fn lend(phases: &[Phase], scratch: &[Mutex<Scratch>], shared: &Shared) {
    for scratch in scratch {
        let mut scratch = lock(scratch);
        for &(label, reduces) in phases.iter().flat_map(|phase| &phase.shared) {
            let copy = scratch.shared.column_mut(label);
            match reduces {
                true => reduction::clear(label.combine(), copy),
                false => copy.copy_from_slice(shared.column(label)),
            }
        }
    }
}

/// Adds up what the workers reduced.
pub fn collect(phases: &[Phase], scratch: &[Mutex<Scratch>], shared: &mut Shared) {
    for scratch in scratch {
        let mut scratch = lock(scratch);
        for &(label, _) in phases.iter().flat_map(|phase| &phase.shared).filter(|(_, reduces)| *reduces) {
            let part = scratch.shared.column_mut(label);
            reduction::merge(label.combine(), shared.column_mut(label), part);
            // two phases of a wave may add to one label: it counts once
            reduction::clear(label.combine(), part);
        }
    }
}

/// The first phase of a tick that reduces a label starts it afresh; what is kept for each material, for those that contribute and
/// whose step ends.
pub fn begin(phase: &Phase, schedule: &Schedule, shared: &mut Shared) {
    let ends = |(label, material): &&(LabelId, usize)| label.home() == Home::Run || schedule.ends(*material);
    for &(label, material) in phase.afresh.iter().filter(ends) {
        let column = shared.column_mut(label);
        let lines = match label.home() {
            Home::Material => material * label.width()..(material + 1) * label.width(),
            _ => 0..column.len(),
        };
        reduction::clear(label.combine(), &mut column[lines]);
    }
}
