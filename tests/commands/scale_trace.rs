//! The model of `sinew scale` replays the order of the engine: held against the `trace.json` of runs on two ranks.

use crate::common::{Overrides, problem};
use engine::exec::order::{Op, Part};
use engine::exec::ranks::local::Local;
use engine::exec::trace::Kind;
use scene::Scene;
use simd::Isa;
use sinew::lab::scale::footprint::Footprint;
use sinew::lab::scale::load::{Listed, Ranks, coming};
use sinew::lab::scale::model::{Cluster, Costs, PhaseCost, Setup};
use sinew::lab::scale::order::{Order, Place};
use sinew::lab::scale::predict::watch;
use sinew::lab::scale::step::Step;
use sinew::output::trace::{Line, Trace};
use sinew::simulation::{Simulation, layout, step_graph};
use std::collections::BTreeSet;
use std::path::Path;

const RANKS: usize = 2;
const STEPS: usize = 2;

/// What a span on the main track of a rank says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Span {
    /// Tasks of a phase, on a slab, on the rim or without a place.
    Tasks(usize, Option<u32>),
    Sent(usize),
    Taken(usize),
    Reduced(Option<usize>),
    Relocated,
    Travelers,
}

impl Span {
    fn of(line: &Line) -> Option<Self> {
        let about = &line.about;
        match line.kind()? {
            Kind::Task => Some(Self::Tasks(about.phase.expect("a phase"), about.slab)),
            Kind::HaloWait if about.messages > 0 => about.exchange.map(Self::Sent),
            Kind::HaloWait => about.exchange.map(Self::Taken),
            Kind::ReduceWait if line.name() == "travelers" => Some(Self::Travelers),
            Kind::ReduceWait => Some(Self::Reduced(about.phase)),
            Kind::Relocate => Some(Self::Relocated),
            Kind::Arrange | Kind::Output | Kind::Idle => None,
        }
    }
}

/// Runs a scene on ranks of one thread each; the ticks that were taken.
fn run(scene: &Scene, path: &Path) -> u64 {
    let one = |network: Local| {
        let run = Simulation::on(Box::new(network), scene.clone(), Isa::detect());
        let mut simulation = run.unwrap_or_else(|e| panic!("{e}"));
        simulation.set_trace(1 << 16);
        (0..STEPS).for_each(|_| assert!(simulation.step().unwrap_or_else(|e| panic!("{e}"))));
        simulation.write_trace(path).unwrap_or_else(|e| panic!("{e}"));
        simulation.ticks()
    };
    std::thread::scope(|scope| {
        let ranks: Vec<_> = Local::crew(RANKS).into_iter().map(|rank| scope.spawn(|| one(rank))).collect();
        ranks.into_iter().map(|rank| rank.join().expect("a rank ends")).max().expect("ranks")
    })
}

/// The spans of a rank's main track; what a worker does on several blocks is one.
fn spans(trace: &Trace, rank: usize) -> Vec<Span> {
    let own = trace.lines.iter().filter(|line| line.is_event() && (line.rank, line.worker) == (rank, 0));
    let mut spans: Vec<Span> = own.filter_map(Span::of).collect();
    spans.dedup();
    spans
}

/// A rank of the model, and what it has to do and to send.
struct Rank<'a> {
    number: usize,
    setup: &'a Setup<'a>,
    ranks: &'a Listed,
    /// First layers of its slabs.
    layers: Vec<u32>,
    spans: &'a [Span],
}

impl Rank<'_> {
    /// The spans that an operation leaves.
    fn leaves(&self, op: Op, kind: usize) -> Vec<Span> {
        let load = self.ranks.load(self.number, kind);
        let mut messages = Vec::new();
        match op {
            Op::Once(phase) => vec![Span::Tasks(phase, None)],
            Op::Work(phase, Part::Rim) if load.work[phase][0] > 0.0 => vec![Span::Tasks(phase, None)],
            Op::Work(phase, Part::Interior(slab)) if load.work[phase][1] > 0.0 => {
                let span = Span::Tasks(phase, Some(self.layers[slab]));
                // all of a slab may be rim
                if self.spans.contains(&span) { vec![span] } else { Vec::new() }
            }
            Op::Send(exchange) => {
                self.ranks.sends(self.number, kind, Some(exchange), &mut messages);
                messages.iter().map(|_| Span::Sent(exchange)).collect()
            }
            Op::Unpack(exchange) if self.comes(exchange, kind) => vec![Span::Taken(exchange)],
            Op::Work(..) | Op::Expect(_) | Op::Unpack(_) => Vec::new(),
            Op::Reduce(phase) => vec![Span::Reduced(Some(phase))],
            Op::SendTravelers => vec![Span::Relocated],
            Op::ReceiveTravelers => vec![Span::Travelers],
            Op::ReduceAtEnd => vec![Span::Reduced(None)],
        }
    }

    fn comes(&self, exchange: usize, kind: usize) -> bool {
        coming(self.ranks, exchange + 1, kind)[exchange][self.number].messages > 0
    }

    /// Goes through the order of all ticks as the spans tell when messages arrived; every span has its operation, and every
    /// operation its spans.
    fn follow(&self) -> Vec<Op> {
        let (mut at, mut ops, spans) = (0, Vec::new(), self.spans);
        let ticks = (0..STEPS).flat_map(|_| self.setup.step.ticks.iter().copied());
        for (tick, kind) in ticks.enumerate() {
            let slabs = self.ranks.load(self.number, kind).slabs;
            let (order, mut place) = (Order::new(self.setup.step.graph, slabs, false), Place::default());
            loop {
                let taken = |exchange: usize| spans.get(at) == Some(&Span::Taken(exchange));
                let here = |exchange| Ok::<_, ()>(taken(exchange) || !self.comes(exchange, kind));
                let Some(op) = place.next(&order, here).expect("the trace knows") else { break };
                for span in self.leaves(op, kind) {
                    let context = &spans[at.saturating_sub(6)..spans.len().min(at + 3)];
                    assert_eq!(
                        spans.get(at),
                        Some(&span),
                        "{op:?} of tick {tick} on rank {} after {ops:?}: {context:?}",
                        self.number
                    );
                    at += 1;
                }
                ops.push(op);
            }
        }
        assert_eq!(at, spans.len(), "all spans have their place in the order");
        ops
    }
}

/// The operations on the interior, and all others: when a message arrives decides how they mix.
fn parts(ops: &[Op]) -> [Vec<Op>; 2] {
    let interior = |op: &Op| matches!(op, Op::Work(_, Part::Interior(_)));
    let (a, b) = ops.iter().partition(|op| interior(op));
    [a, b]
}

fn check(name: &str, overrides: Overrides<'_>, least_ticks: usize) {
    let scene = problem(name, &[&[("run.threads", "1"), ("run.patches", "[4, 2, 2]")], overrides].concat());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("trace.json");
    let ticks = run(&scene, &path);
    let trace = Trace::load(&path).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(trace.lost(), 0);

    let (patches, _) = layout::decompose(&scene, RANKS, RANKS).expect("patches that fit");
    let graph = step_graph(&scene, patches.patches.len()).unwrap_or_else(|e| panic!("{e}"));
    let step = Step::of(&scene, &graph);
    assert_eq!(ticks, (STEPS * step.ticks.len()) as u64, "a step at rest has the ticks of the run");
    assert!(step.ticks.len() >= least_ticks, "{:?}", step.ticks);
    let phases = graph.phases.iter().map(|phase| match phase {
        phase if phase.is_over_nodes() => PhaseCost::Nodes(1e3),
        phase if phase.stages[0].material.is_none() => PhaseCost::Once(1e3),
        _ => PhaseCost::Particles(vec![50.0; scene.materials.len()]),
    });
    let costs = Costs { phases: phases.collect(), contention: 1.0, ..Costs::default() };
    let setup = Setup { step: &step, costs, cluster: Cluster::default(), threads: 1, steps: STEPS };
    let footprint = Footprint::of(&scene).expect("a footprint");
    let mut ranks = footprint.ranks(&patches, RANKS, &setup).expect("enough patches");

    let all: Vec<Vec<Span>> = (0..RANKS).map(|rank| spans(&trace, rank)).collect();
    let layers = |rank: usize| -> BTreeSet<u32> {
        let slab = |span: &Span| if let Span::Tasks(_, slab) = span { *slab } else { None };
        all[rank].iter().filter_map(slab).collect()
    };
    // where the engine cuts between layers, the model has a mean
    for load in ranks.loads.iter_mut().flat_map(|kind| kind.iter_mut().enumerate()) {
        load.1.slabs = if load.1.slabs > 1 { layers(load.0).len() } else { 1 };
    }
    let mut replayed = vec![Vec::new(); RANKS];
    watch(&ranks, &setup, |rank, op| replayed[rank].push(op));
    for (number, spans) in all.iter().enumerate() {
        let layers = layers(number).into_iter().collect();
        let rank = Rank { number, setup: &setup, ranks: &ranks, layers, spans };
        assert_eq!(parts(&rank.follow()), parts(&replayed[number]), "{name}, rank {number}");
    }
}

#[test]
fn contact_at_a_common_rate() {
    check("slab-quick", &[], 1);
}

#[test]
fn contact_where_materials_take_steps_of_their_own() {
    check("slab-quick", &[("run.rates", "per-material")], 8);
}
