//! What a simulation of steps says: how long a step takes, and where its time goes.
use super::load::Ranks;
use super::model::Setup;
use super::replay::{COMPUTE, ENGINE, HALO, REDUCTION, Replay, TRAVEL};
use super::wires::Cause;
use engine::exec::order::Op;

/// Where the time of a mean rank went, as shares of the step. They add up to one.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Shares {
    /// Tasks.
    pub compute: f64,
    /// Lists of blocks, locks, looking for who leaves.
    pub engine: f64,
    /// Packing, sending, unpacking and waiting for node data.
    pub halo: f64,
    /// Sending travelers and waiting for them: this is where ranks that have less to do wait.
    pub travel: f64,
    /// Reductions.
    pub reduction: f64,
}

/// What came out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// A step [s].
    pub step: f64,
    /// Shares of a mean rank.
    pub shares: Shares,
    /// What the critical path through all steps went into, as shares by [`Cause`].
    pub path: [f64; Cause::COUNT],
    /// Work of the rank that has most, over the mean.
    pub imbalance: f64,
}

/// Simulates some steps.
pub fn simulate<R: Ranks + ?Sized>(ranks: &R, setup: &Setup<'_>) -> Outcome {
    watch(ranks, setup, |_, _| {})
}

/// The same; `each` hears what ranks do, each rank in its order.
pub fn watch<R: Ranks + ?Sized>(ranks: &R, setup: &Setup<'_>, each: impl FnMut(usize, Op)) -> Outcome {
    let mut replay = Replay::new(ranks, setup, each);
    replay.run();
    let [first, last] = replay.ends();
    let (step, whole) = match setup.steps {
        0 | 1 => (first.time, first),
        steps => ((last.time - first.time) / (steps - 1) as f64, last),
    };
    let spent = replay.spent();
    let all = spent.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    let [compute, engine, halo, travel, reduction] =
        [COMPUTE, ENGINE, HALO, TRAVEL, REDUCTION].map(|part| spent[part] / all);
    let path: f64 = whole.parts.iter().map(|&x| f64::from(x)).sum::<f64>().max(f64::MIN_POSITIVE);
    Outcome {
        step,
        shares: Shares { compute, engine, halo, travel, reduction },
        path: whole.parts.map(|x| f64::from(x) / path),
        imbalance: imbalance(ranks, setup),
    }
}

/// Task time of a rank in a step [ns on one worker].
pub fn work<R: Ranks + ?Sized>(ranks: &R, setup: &Setup<'_>, rank: usize) -> f64 {
    let ticks = setup.step.ticks.iter().map(|&kind| ranks.load(rank, kind));
    ticks.flat_map(|load| load.work.iter().flatten()).sum()
}

fn imbalance<R: Ranks + ?Sized>(ranks: &R, setup: &Setup<'_>) -> f64 {
    let (mut sum, mut most) = (0.0, 0.0_f64);
    for work in (0..ranks.count()).map(|rank| work(ranks, setup, rank)) {
        (sum, most) = (sum + work, most.max(work));
    }
    if sum > 0.0 { most * ranks.count() as f64 / sum } else { 1.0 }
}
