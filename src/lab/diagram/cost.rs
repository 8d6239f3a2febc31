//! What items take: measured, or estimated by what they touch.
use super::{Diagram, Item, Kind, Source};
use crate::output::trace::measured::About;
use engine::graph::recipe::over_particles;
use engine::graph::task::{Access, Declaration, Domain};
use engine::graph::traffic::Traffic;
use engine::schema::Home;
use std::collections::BTreeMap;

/// Nanoseconds for each particle and number of eight-particle lines that a task declares.
const PARTICLE: f64 = 0.12;
/// Nanoseconds for each node and node label that a task declares.
const NODE: f64 = 0.5;
/// Nanoseconds of a task that runs once.
const ONCE: f64 = 1e3;
/// Nanoseconds before a message arrives.
const LATENCY: f64 = 2e3;
/// Nanoseconds a byte of a message.
const BYTE: f64 = 0.2;
/// Nanoseconds a block that is looked at to see whether particles left it.
const LOOK: f64 = 2.0;

/// How costs are estimated, in words.
pub const ESTIMATE: &str = "estimated: 0.12 ns a particle and line that a task declares, 0.5 ns a node and label, \
1 µs for what runs once, 2 µs and 0.2 ns a byte for a message; one thread a rank";

/// A task's estimated cost for a particle or node [ns].
fn nominal(task: &Declaration, material: Option<usize>, traffic: &Traffic) -> f64 {
    match task.domain {
        Domain::Once => ONCE,
        Domain::Buffers => LOOK,
        Domain::Nodes => {
            NODE * task.access.iter().filter(|a| a.label.home() == Home::Node).count().max(1) as f64
        }
        _ => {
            let width = |a: &Access| traffic.width(a.label, material.unwrap_or(0));
            PARTICLE * task.access.iter().map(width).sum::<u64>() as f64
        }
    }
}

impl Diagram<'_> {
    /// Particles or nodes of a task on some patches.
    pub(super) fn work(&self, task: &Declaration, material: Option<usize>, patches: &[usize]) -> u64 {
        let of = |counts: &[Vec<u64>]| -> u64 {
            patches.iter().map(|&p| material.map_or(counts[p].iter().sum(), |m| counts[p][m])).sum()
        };
        match task.domain {
            Domain::Once => 1,
            Domain::Nodes => of(&self.traffic.nodes),
            Domain::NearParticles => of(&self.traffic.near),
            Domain::Particles => of(&self.traffic.particles),
            Domain::Buffers => of(&self.traffic.blocks),
        }
    }

    /// Scales the estimates of tasks by a factor, of which `words` say where it is from.
    pub fn set_pace(&mut self, factor: f64, words: &str) {
        let tasks = self.items.iter_mut().filter(|item| matches!(item.kind, Kind::Task(_)));
        tasks.filter(|item| item.source == Source::Estimated).for_each(|item| item.cost *= factor);
        self.estimate = words.to_owned();
        self.find_path();
    }

    /// The estimated work of all tasks [ns].
    pub fn work_ns(&self) -> f64 {
        self.items.iter().filter(|item| matches!(item.kind, Kind::Task(_))).map(|item| item.cost).sum()
    }

    /// Fills in the costs of all items.
    pub(super) fn weigh(&mut self) {
        for at in 0..self.items.len() {
            self.items[at].cost = self.estimate(&self.items[at]);
        }
        self.weigh_measured();
    }

    fn estimate(&self, item: &Item) -> f64 {
        let traffic = self.traffic;
        match item.kind {
            Kind::Task(node) => {
                let task = &self.graph.graph[node].declaration;
                let work = match (item.rank, over_particles(task.domain) || task.domain == Domain::Nodes) {
                    // collapsed: the rank that has most of it decides
                    (None, true) => (0..traffic.ranks)
                        .map(|rank| self.work(task, item.material, &self.patches_of(rank)))
                        .max()
                        .unwrap_or(0),
                    _ => item.work,
                };
                work as f64 * nominal(task, item.material, traffic)
            }
            Kind::Relocation => {
                let blocks: u64 = traffic.blocks.iter().flatten().sum();
                let share = blocks as f64 / traffic.ranks as f64;
                LOOK * share + self.exchange(item)
            }
            _ => self.exchange(item),
        }
    }

    /// The estimated time of the messages that an item stands for: those of the rank that receives most.
    fn exchange(&self, item: &Item) -> f64 {
        let pairs = match item.kind {
            Kind::Halo(phase) => self.traffic.halo(&self.graph.phases[phase], &self.graph.exchanges),
            Kind::Reduction(_) => self.traffic.reduce(&item.labels),
            _ => self.traffic.relocation(),
        };
        let mut received: BTreeMap<usize, f64> = BTreeMap::new();
        let mine = |&(from, to): &(usize, usize)| match (item.rank, item.to_rank) {
            (Some(rank), Some(target)) => (from, to) == (rank, target),
            (Some(rank), None) => to == rank,
            _ => true,
        };
        for (&(_, to), messages) in pairs.iter().filter(|(pair, _)| mine(pair)) {
            let time = LATENCY * messages.count as f64 + BYTE * messages.bytes as f64;
            *received.entry(to).or_default() += time;
        }
        received.into_values().fold(0.0, f64::max)
    }

    /// Patches of a rank.
    pub(super) fn patches_of(&self, rank: usize) -> Vec<usize> {
        (0..self.traffic.patches()).filter(|&patch| self.traffic.rank_of[patch] == rank).collect()
    }

    /// Takes over measured times. A stage is measured as a whole: its tasks share the time as they do in the estimate.
    fn weigh_measured(&mut self) {
        let Some(measured) = self.measured else { return };
        let mut ranks: Vec<u64> = measured.workers.iter().map(|worker| worker.rank).collect();
        ranks.dedup();
        let of_each = if self.expanded { 1.0 } else { ranks.len().max(1) as f64 };
        let shares: Vec<(Option<About>, Option<About>)> =
            self.items.iter().map(|item| self.traced(item)).collect();
        let mut totals: BTreeMap<&About, f64> = BTreeMap::new();
        for (item, about) in
            self.items.iter().zip(&shares).filter_map(|(item, (about, _))| Some((item, about.as_ref()?)))
        {
            *totals.entry(about).or_default() += item.cost.max(1e-9);
        }
        let mean = |about: &Option<About>| {
            measured.sum(about.as_ref()?).map(|sum| measured.per_step(sum.ns) / of_each)
        };
        let mut costs = Vec::with_capacity(shares.len());
        for (item, (about, idle)) in self.items.iter().zip(&shares) {
            let total = about.as_ref().and_then(|about| totals.get(about)).copied().unwrap_or(1.0);
            let share = item.cost.max(1e-9) / total;
            costs.push((
                mean(about).map(|ns| ns * share),
                mean(idle).map(|ns| ns * share),
                share > 0.999_999,
            ));
        }
        for (item, (cost, idle, alone)) in self.items.iter_mut().zip(costs) {
            item.idle = idle;
            item.source = match (cost, alone) {
                (None, _) => Source::Estimated,
                (Some(_), true) => Source::Measured,
                (Some(_), false) => Source::Split,
            };
            item.cost = cost.unwrap_or(item.cost);
        }
    }

    /// Under which names a trace knows an item, and the idleness beside it.
    fn traced(&self, item: &Item) -> (Option<About>, Option<About>) {
        match item.kind {
            Kind::Halo(phase) => (Some(About::Halo(phase)), None),
            Kind::Reduction(phase) => (Some(About::Reduction(phase)), None),
            Kind::Relocation => (Some(About::Other("relocate".to_owned())), None),
            Kind::Task(node) => {
                let stages = self.graph.phases.iter().flat_map(|phase| &phase.stages);
                let Some(stage) = stages.into_iter().find(|stage| stage.nodes.contains(&node)) else {
                    return (None, None);
                };
                let tasks: Vec<String> =
                    stage.nodes.iter().map(|&n| self.graph.graph[n].declaration.name.to_owned()).collect();
                let material = stage.material.map(|m| self.graph.recipe.materials[m].clone());
                (Some(About::Stage(tasks.clone(), material.clone())), Some(About::Idle(tasks, material)))
            }
        }
    }
}
