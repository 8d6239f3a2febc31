//! Costs of the model, from short runs on this machine.
use super::footprint::Footprint;
use super::load::Ranks;
use super::measure::{Plan, Reader, measure, resized};
use super::model::{Costs, PhaseCost, Setup};
use super::predict;
use super::tally::{Rank, Tally};
use engine::data::reduction;
use engine::exec::{Executor, Threads};
use engine::graph::build::TaskGraph;
use engine::graph::phase::Phase;
use engine::graph::task::Domain;
use engine::schema::{Combine, LabelId};
use scene::Patches;
use simd::Wide;
use std::hint::black_box;
use std::time::Instant;

/// Packing where no run on several ranks has measured it [ns a byte]: a copy from cache to memory.
const PACK: f64 = 0.25;
/// Patches of the run that shows what patches cost.
const MANY: usize = 64;
/// Cells of the run that shows what blocks cost, over those of the scene.
const COARSER: f64 = 2.0;

/// Every tick is a step of all materials.
const TOGETHER: &str = "run.rates=common";

/// Costs from three runs on one worker: on one patch, on many, and on coarser cells. All materials act in each of their
/// ticks: what acts alone costs the same.
///
/// # Errors
/// A run that failed.
pub fn calibrate(
    plan: &Plan,
    read: &Reader<'_>,
    graph: &TaskGraph,
    say: &mut dyn FnMut(&str),
) -> Result<Costs, String> {
    let scene = read(&[])?;
    let mut run = |patches: usize, set: Option<String>| -> Result<(Tally, usize), String> {
        let set = plan.set.iter().cloned().chain([TOGETHER.to_owned()]).chain(set).collect();
        let (threads, ranks) = (vec![1], vec![1]);
        let own =
            Plan { patches: vec![Patches::Total(patches)], threads, ranks, weak: false, set, ..plan.clone() };
        let mut say = |what: &str| say(&format!("calibration {what}"));
        let (mut rows, mut tallies) = measure(&own, read, &mut say);
        match (tallies.pop().flatten(), rows.pop()) {
            (Some(tally), Some(row)) => Ok((tally, row.patches)),
            (_, row) => Err(row.and_then(|row| row.error).unwrap_or_default()),
        }
    };
    let footprint = Footprint::of(&scene)?;
    let (plain, few) = run(1, None)?;
    let mut costs = tasks(&plain, graph, &footprint);
    let (cut, many) = run(MANY, None)?;
    let engine = |tally: &Tally| per_step(tally, |rank| rank.engine() - rank.relocate).max(0.0);
    let more = many.saturating_sub(few).max(1) as f64;
    costs.patch = ((engine(&cut) - engine(&plain)) / more).max(0.0);
    let cell = resized(&scene, 1.0 / COARSER);
    let coarse =
        read(&[("domain.cell".to_owned(), cell.to_string())]).and_then(|scene| Footprint::of(&scene));
    // not every scene can have coarser cells: then all of it is the blocks'
    let slope = coarse.ok().filter(|coarse| coarse.blocks() < footprint.blocks()).and_then(|coarse| {
        let (tally, _) = run(1, Some(format!("domain.cell={cell}"))).ok()?;
        Some((engine(&plain) - engine(&tally)) / (footprint.blocks() - coarse.blocks()) as f64)
    });
    let rest = (engine(&plain) - costs.patch * few as f64).max(0.0);
    let blocks = footprint.blocks().max(1) as f64;
    costs.block = slope.unwrap_or(rest / blocks).clamp(0.0, rest / blocks);
    costs.step = rest - costs.block * blocks;
    costs.fork = fork();
    costs.merge = merge(&graph.at_end);
    (costs.pack, costs.contention) = (PACK, 1.0);
    Ok(costs)
}

/// Mean over ranks of a part of a step [ns].
fn per_step(tally: &Tally, part: impl Fn(&Rank) -> f64) -> f64 {
    tally.ranks.iter().map(part).sum::<f64>() / tally.ranks.len().max(1) as f64 / tally.steps.max(1) as f64
}

/// What tasks cost, and looking for particles that leave.
fn tasks(tally: &Tally, graph: &TaskGraph, footprint: &Footprint) -> Costs {
    let phases = graph.phases.iter().enumerate();
    let phases = phases.map(|(number, phase)| phase_cost(tally, graph, (number, phase), footprint)).collect();
    let relocate = per_step(tally, |rank| rank.relocate) / footprint.blocks().max(1) as f64;
    Costs { phases, relocate, ..Costs::default() }
}

fn phase_cost(
    tally: &Tally,
    graph: &TaskGraph,
    (number, phase): (usize, &Phase),
    footprint: &Footprint,
) -> PhaseCost {
    let steps = tally.steps.max(1) as f64;
    let ns = |material: Option<&String>| {
        tally.stages.get(&(number, material.cloned())).map_or(0.0, |ns| ns / steps)
    };
    match phase.stages.first().map(|stage| stage.domain) {
        Some(Domain::Nodes) => PhaseCost::Nodes(ns(None) / footprint.node_blocks().max(1.0)),
        Some(Domain::Once) | None => PhaseCost::Once(ns(None)),
        Some(_) => {
            let counts = graph.recipe.materials.iter().zip(footprint.particles());
            PhaseCost::Particles(counts.map(|(name, count)| ns(Some(name)) / count.max(1.0)).collect())
        }
    }
}

/// Packing as a run on several ranks measured it [ns a byte], if one did.
pub fn pack(tallies: &[Option<Tally>]) -> Option<f64> {
    let packed = |tally: &Tally| tally.ranks.iter().map(|rank| rank.packed).sum::<u64>();
    let tally = tallies.iter().flatten().find(|tally| packed(tally) > 0)?;
    Some(tally.ranks.iter().map(|rank| rank.pack).sum::<f64>() / packed(tally) as f64)
}

/// Task time of a run on several workers over what the costs of one worker make of it.
///
/// # Errors
/// A scene that cannot be cut.
pub fn contention(several: &Tally, setup: &Setup<'_>, footprint: &Footprint) -> Result<f64, String> {
    let tasks: f64 = several.ranks.iter().map(|rank| rank.tasks[1]).sum();
    let alone = footprint.ranks(&footprint.usual(1, 1), 1, setup)?;
    let alone: f64 = (0..alone.count()).map(|rank| predict::work(&alone, setup, rank)).sum();
    Ok((tasks / several.steps.max(1) as f64 / alone.max(1.0)).max(1.0))
}

/// Handing work to two workers and waiting for them [ns]: the best of many.
fn fork() -> f64 {
    let Ok(pool) = Threads::new(2) else { return 0.0 };
    let mut items = [0u64; 16];
    let mut once = || {
        let began = Instant::now();
        pool.each(&mut items, |_, item| *item = black_box(*item + 1));
        began.elapsed().as_nanos() as u64
    };
    let mut times: Vec<u64> = (0..400).map(|_| once()).collect();
    times.sort_unstable();
    times[times.len() / 4] as f64
}

/// Merging a byte of a reduction [ns]: the best of several.
fn merge(labels: &[LabelId]) -> f64 {
    let mut parts: Vec<(Combine, Vec<Wide>, Vec<Wide>)> = labels
        .iter()
        .map(|label| {
            (label.combine(), vec![Wide::default(); label.width()], vec![Wide::default(); label.width()])
        })
        .collect();
    let bytes: usize = parts.iter().map(|(_, into, _)| size_of_val(&into[..])).sum();
    let mut once = || {
        let began = Instant::now();
        for (combine, into, from) in &mut parts {
            reduction::merge(*combine, black_box(into), from);
        }
        began.elapsed().as_nanos() as u64
    };
    let best = (0..100).map(|_| once()).min().unwrap_or(0);
    best as f64 / bytes.max(1) as f64
}
