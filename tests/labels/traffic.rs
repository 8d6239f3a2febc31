//! Counts of what ranks send are what they send; and the bytes of a label stand in the dump of its graph.
use crate::again;
use crate::layouts::{cases, layout, random};
use crate::run::{Layout, level, warehouse};
use crate::state::{Particle, Start, start};
use crate::toy::*;
use engine::exec::ranks::local::Local;
use engine::exec::ranks::{Channel, Network, NetworkError};
use engine::exec::{Engine, Serial, traffic};
use engine::graph::build::TaskGraph;
use engine::graph::traffic::{Messages, Pairs, Traffic};
use engine::prelude::*;
use engine::schema::LabelId;
use engine::simd::Isa;
use sinew::lab::diagram::{Chart, Diagram};
use sinew::simulation::rates::Cycle;
use std::collections::BTreeMap;

/// A rank that counts what it sends, by channel and receiver.
struct Counting {
    rank: Local,
    sent: BTreeMap<(Channel, usize), Messages>,
}

impl Network for Counting {
    fn rank(&self) -> usize {
        self.rank.rank()
    }
    fn size(&self) -> usize {
        self.rank.size()
    }
    fn send(&mut self, to: usize, channel: Channel, message: Vec<Wide>) {
        self.sent.entry((channel, to)).or_default().add(1, size_of_val(&message[..]) as u64);
        self.rank.send(to, channel, message);
    }
    fn expect(&mut self, from: usize, channel: Channel, most: usize) {
        self.rank.expect(from, channel, most);
    }
    fn arrived(&mut self, from: usize, channel: Channel) -> Result<Option<Vec<Wide>>, NetworkError> {
        self.rank.arrived(from, channel)
    }
    fn receive(&mut self, from: usize, channel: Channel) -> Result<Vec<Wide>, NetworkError> {
        self.rank.receive(from, channel)
    }
    fn settle(&mut self) {
        self.rank.settle();
    }
}

fn toy(start: &Start, layout: &Layout) -> Program {
    program(&start.fields, start.cells, layout.patches.iter().product()).expect("a program")
}

/// What all ranks send in each graph of the first step, by what it is about.
fn sent(
    start: &Start,
    layout: &Layout,
    program: impl Fn() -> Program + Sync,
) -> Vec<BTreeMap<Channel, Pairs>> {
    let work = |rank: Local| {
        let (program, from) = (program(), rank.rank());
        let mut network = Counting { rank, sent: BTreeMap::new() };
        let mut warehouse = warehouse(start, layout, &program, from);
        let mut engine = Engine::new(Box::new(Serial), Isa::detect(), &warehouse);
        let graphs = program.graphs().into_iter().map(|graph| {
            engine.run(graph, &mut warehouse, &mut network).expect("a graph");
            engine.reduce(graph, None, &mut warehouse.shared, &mut network).expect("reductions");
            (from, std::mem::take(&mut network.sent))
        });
        graphs.collect::<Vec<_>>()
    };
    let ranks: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> =
            Local::crew(layout.ranks).into_iter().map(|rank| scope.spawn(|| work(rank))).collect();
        threads.into_iter().map(|rank| rank.join().expect("a rank")).collect()
    });
    let mut graphs: Vec<BTreeMap<Channel, Pairs>> = vec![BTreeMap::new(); ranks[0].len()];
    for (graph, (from, list)) in ranks.into_iter().flat_map(|rank| rank.into_iter().enumerate()) {
        for ((channel, to), messages) in
            list.into_iter().filter(|((channel, _), _)| *channel != Channel::Occupied)
        {
            graphs[graph].entry(channel).or_default().insert((from, to), messages);
        }
    }
    graphs
}

/// What is counted from the blocks alone.
fn counted(start: &Start, layout: &Layout) -> Traffic {
    let alone = Layout { ranks: 1, of: [vec![0; layout.of[0].len()], Vec::new()], ..layout.clone() };
    let mut warehouse = warehouse(start, &alone, &toy(start, layout), 0);
    warehouse.activate(&Serial);
    traffic::count(&warehouse, &Partition::new(layout.of[0].clone(), 0, layout.ranks))
}

fn expected(graph: &TaskGraph, traffic: &Traffic) -> BTreeMap<Channel, Pairs> {
    let mut all = BTreeMap::new();
    for (number, exchange) in (0..).zip(&graph.exchanges) {
        all.insert(Channel::Halo(number), traffic.exchange(exchange, |_| true));
    }
    let mut reductions = Pairs::new();
    let reduced = graph.phases.iter().map(|phase| &phase.reductions).chain([&graph.at_end]);
    for labels in reduced.filter(|labels| !labels.is_empty()) {
        for (pair, messages) in traffic.reduce(labels) {
            reductions.entry(pair).or_default().add(messages.count, messages.bytes);
        }
    }
    all.insert(Channel::Reduction, reductions);
    all.retain(|_, pairs| !pairs.is_empty());
    all
}

#[track_caller]
fn counted_as_sent(start: &Start, layout: &Layout, program: impl Fn() -> Program + Sync) {
    let traffic = counted(start, layout);
    for (graph, sent) in program().graphs().into_iter().zip(sent(start, layout, &program)) {
        assert_eq!(sent, expected(graph, &traffic), "graph {}, {layout:?}", graph.name);
    }
}

#[test]
fn what_is_counted_is_what_is_sent() {
    cases(24, (start(), 2..=4usize, random()), |(start, ranks, random)| {
        let layout = layout(&start, ranks, 1, &random);
        if layout.ranks > 1 {
            counted_as_sent(&start, &layout, || toy(&start, &layout));
        }
    });
}

#[test]
fn who_does_not_add_sends_nothing() {
    let of = [vec![0, 1], vec![0, 1]];
    let layout = Layout { patches: [2, 1, 1], ranks: 2, of, moves: 0, threads: 1 };
    let mut start = again::start();
    start.particles.iter_mut().for_each(|p| p.x[0] = 3.5);
    counted_as_sent(&start, &layout, again::program);
}

/// One particle at 3.5 on a line of two patches, which are on two ranks. It may touch the nodes 3 to 5; 4 and 5 are those of the
/// other rank.
fn one() -> (Start, Layout) {
    let particle = Particle { material: 0, x: [3.5, 0.0, 0.0], velocity: [0.0; 3], charge: 1.0, whole: 1.0 };
    let start = Start {
        cells: [8, 0, 0],
        fields: vec![1],
        memory: vec![0],
        interacts: vec![vec![false]],
        particles: vec![particle],
    };
    assert_eq!(level(start.cells).block_columns(), [2, 1, 1]);
    (start, Layout { patches: [2, 1, 1], ranks: 2, of: [vec![0, 1], vec![0, 1]], moves: 0, threads: 1 })
}

const LINE: u64 = 64;

#[test]
fn bytes_are_lines_of_the_label_times_nodes() {
    let (start, layout) = one();
    counted_as_sent(&start, &layout, || toy(&start, &layout));
    let (program, sent) = (toy(&start, &layout), sent(&start, &layout, || toy(&start, &layout)));
    let bytes = |graph: usize, label: LabelId, pair| {
        let exchanges = (0..).zip(&program.graphs()[graph].exchanges);
        let about = exchanges.filter(|(_, exchange)| exchange.labels.contains(&label));
        let messages = about.filter_map(|(number, _)| sent[graph].get(&Channel::Halo(number))?.get(&pair));
        messages.map(|messages| messages.bytes).collect::<Vec<_>>()
    };
    let ([before, begin, round], [there, back]) = ([0, 1, 2], [(0, 1), (1, 0)]);
    // 3 lines of the nodes 4 to 6, all that particles of the block may touch: nobody has said which they do
    assert_eq!(bytes(before, Total::ID, back), [LINE * 3 * 3]);
    // the sums of two nodes, StageSum to StageFirst, and a line that says which nodes
    assert_eq!(bytes(begin, StageSum::ID, there), [LINE * (1 + 2 * (1 + 2 + 3 + 1 + 9 + 1 + 1))]);
    assert_eq!(bytes(begin, TickValue::ID, back), [LINE * 2]);
    assert_eq!(bytes(round, StageSum::ID, there), [LINE * (1 + 2)]);
    assert_eq!(bytes(before, Total::ID, there), [0u64; 0], "no particle of rank 1 reads nodes of rank 0");
}

#[test]
fn a_label_stands_in_the_dump_with_its_bytes() {
    let (start, layout) = one();
    let (traffic, program) = (counted(&start, &layout), toy(&start, &layout));
    let graph = program.graphs()[1];
    let cycle = Cycle { most: None, tick: 0.0, fastest: 0, own: Vec::new() };
    let diagram = Diagram::collapsed(graph, &cycle, &traffic, None);
    let (json, text) = (diagram.to_json(), diagram.table() + &diagram.report());
    // the node that stays on the rank, and the two that travel
    for (label, lines) in [("StageSum", 1), ("TickSum", 2), ("StepSum", 3), ("StageExact", 9)] {
        let links = json["links"].as_array().expect("links");
        let mut bytes: Vec<u64> = links
            .iter()
            .filter(|link| link["label"] == label)
            .filter_map(|link| link["bytes"].as_u64())
            .collect();
        bytes.sort_unstable();
        assert_eq!(bytes, [LINE * lines, 2 * LINE * lines, 2 * LINE * lines], "{label}");
        assert!(text.contains(&format!("{label}@")), "{text}");
    }
    let message = json["messages"]
        .as_array()
        .expect("messages")
        .iter()
        .find(|it| it["about"].as_str().is_some_and(|about| about.contains("StageExact")));
    let pair = &message.expect("an exchange of sums")["pairs"][0];
    assert_eq!((&pair["from"], &pair["to"], &pair["bytes"]), (&0.into(), &1.into(), &(LINE * 37).into()));
    assert!(text.contains("2.4 kB"), "37 lines of 64 bytes: {text}");
    let whole = Chart::new(&program, &cycle, &traffic, None, false).to_text();
    assert!(whole.lines().any(|line| line.contains("step before") && line.contains("Total")), "{whole}");
}
