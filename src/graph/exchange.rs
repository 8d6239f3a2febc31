//! What ranks and patches exchange in a step: derived from the declared ghosts and reductions, like the edges.
use super::fuse::Phase;
use super::task::Mode;
use crate::data::label::{Home, Reduce};
use crate::data::labels::LabelId;
use std::collections::{BTreeMap, BTreeSet};

/// Fills in what each phase sends and receives, and which reductions it needs complete; returns the labels whose reductions are
/// complete only at the end of the tick.
pub fn derive(phases: &mut [Phase]) -> Vec<LabelId> {
    let mut spread = BTreeMap::new();
    let mut open = BTreeSet::new();
    let mut writer: BTreeMap<LabelId, usize> = BTreeMap::new();
    for number in 0..phases.len() {
        let phase = &phases[number];
        let touched = || phase.stages.iter().flat_map(|stage| &stage.touched);
        let reads = touched().filter(|a| a.mode.reads() && a.label.home() == Home::Node);
        let across = reads.filter(|a| a.ghost > 0 || spread.get(&a.label).is_some_and(|&ghost| ghost > 0));
        let halos: BTreeSet<_> = across.map(|a| a.label).collect();
        let needs = phase.shared.iter().filter(|(_, reduces)| !reduces).map(|&(label, _)| label);
        let reductions: Vec<_> = needs.filter(|label| open.remove(label)).collect();
        let writes = || touched().filter(|a| a.mode.writes() && a.label.home() == Home::Node);
        spread.extend(writes().filter(|a| a.mode == Mode::Computes).map(|a| (a.label, a.ghost)));
        let written: Vec<LabelId> = writes().map(|a| a.label).collect();
        let reduces = phase.shared.iter().filter(|(label, reduces)| *reduces && label.reduce() != Reduce::No);
        open.extend(reduces.map(|&(label, _)| label));
        for label in &halos {
            // what one phase has sent need not be sent again
            if let Some(writer) = writer.remove(label) {
                phases[writer].sends.push(*label);
            }
        }
        writer.extend(written.into_iter().map(|label| (label, number)));
        phases[number].halos = halos.into_iter().collect();
        phases[number].reductions = reductions;
    }
    open.into_iter().collect()
}
