//! The step that is replayed: its graph, and who acts in each of its ticks.
use crate::simulation::rates;
use engine::data::schedule::Schedule;
use engine::exec::work::{acts, travels};
use engine::graph::build::TaskGraph;
use engine::graph::exchange::Exchange;
use engine::graph::phase::Phase;
use engine::graph::traffic::reduced_bytes;
use scene::Scene;

/// A step of a scene.
pub struct Step<'a> {
    /// The graph of each tick.
    pub graph: &'a TaskGraph,
    /// Ticks that differ.
    pub kinds: Vec<Tick>,
    /// The kind of each tick, in order.
    pub ticks: Vec<usize>,
}

/// A kind of tick.
#[derive(Clone, Debug)]
pub struct Tick {
    /// Who acts.
    pub schedule: Schedule,
    /// Bytes that a rank gives to the reduction before each phase, and to that at the end.
    pub reduced: Vec<f64>,
    materials: usize,
}

impl<'a> Step<'a> {
    /// The step of a scene at rest, by its graph.
    pub fn of(scene: &Scene, graph: &'a TaskGraph) -> Self {
        let (mut kinds, mut ticks): (Vec<Tick>, _) = (Vec::new(), Vec::new());
        for schedule in rates::ticks_at_rest(scene) {
            let tick = Tick::new(schedule, graph, scene.materials.len());
            let known = kinds.iter().position(|kind| kind.acting() == tick.acting());
            ticks.push(known.unwrap_or(kinds.len()));
            if known.is_none() {
                kinds.push(tick);
            }
        }
        Self { graph, kinds, ticks }
    }

    /// The kinds of all ticks, in order.
    pub fn each(&self) -> impl Iterator<Item = &Tick> {
        self.ticks.iter().map(|&kind| &self.kinds[kind])
    }
}

impl Tick {
    fn new(schedule: Schedule, graph: &TaskGraph, materials: usize) -> Self {
        // what each material keeps is reduced where its step ends
        let ends = (0..materials).filter(|&m| schedule.ends(m)).count();
        let all = graph.phases.iter().map(|phase| &phase.reductions).chain([&graph.at_end]);
        let reduced = all.map(|labels| reduced_bytes(labels, ends, &graph.recipe.tiles) as f64).collect();
        Self { schedule, reduced, materials }
    }

    /// Whether a step of each material begins and ends.
    fn acting(&self) -> Vec<[bool; 2]> {
        (0..self.materials).map(|m| [self.schedule.begins(m), self.schedule.ends(m)]).collect()
    }

    /// Whether particles of a material are worked on in a phase, or blocks of nodes because of it.
    pub fn works(&self, phase: &Phase, material: usize) -> bool {
        match phase.is_over_nodes() {
            true => self.schedule.ends(material),
            false => {
                let mut own = phase.stages.iter().filter(|stage| stage.material == Some(material));
                own.any(|stage| acts(stage, &self.schedule))
            }
        }
    }

    /// Whether something of a material travels in an exchange.
    pub fn sends(&self, exchange: &Exchange, material: usize) -> bool {
        travels(exchange, &self.schedule, material)
    }

    /// Whether a step of the material begins or ends.
    pub fn acts(&self, material: usize) -> bool {
        self.schedule.begins(material) || self.schedule.ends(material)
    }
}
