//! Waves: phases follow one another slab by slab of blocks, so that what one leaves is still in cache for the next.
use crate::data::schedule::Schedule;
use crate::data::warehouse::{ParticlePatch, Warehouse};
use std::ops::Range;

/// Blocks a worker that a slab should have at least: enough to share the work evenly.
pub const GRAIN: usize = 48;

/// The level's layers of blocks along x, in slabs of about equal work.
pub fn slabs(warehouse: &Warehouse, workers: usize) -> Vec<Range<i32>> {
    let least = GRAIN * workers;
    let counts = warehouse.blocks_by_layer();
    let (mut slabs, mut blocks) = (Vec::new(), 0);
    let mut begin = warehouse.level.blocks().lower[0];
    let mut left: usize = counts.values().sum();
    for (layer, count) in counts {
        (blocks, left) = (blocks + count, left - count);
        if blocks >= least && left >= least {
            slabs.push(begin..layer + 1);
            (begin, blocks) = (layer + 1, 0);
        }
    }
    slabs.push(begin..warehouse.level.blocks().upper[0]);
    slabs
}

/// Whether most blocks take part in this tick: otherwise a wave does not pay.
pub fn busy(schedule: &Schedule, particles: &[Vec<ParticlePatch>]) -> bool {
    let (mut acting, mut all) = (0, 0);
    for (material, home) in particles.iter().flat_map(|patch| patch.iter().enumerate()) {
        all += home.blocks.len();
        if schedule.begins(material) || schedule.ends(material) {
            acting += home.blocks.len();
        }
    }
    2 * acting > all
}

/// All pairs of phase and slab, such that a phase comes to a slab when the one before it has done that slab and the next.
pub fn order(phases: usize, slabs: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..slabs + phases - 1).flat_map(move |front| {
        (0..phases)
            .filter_map(move |phase| Some((phase, front.checked_sub(phase).filter(|&slab| slab < slabs)?)))
    })
}
