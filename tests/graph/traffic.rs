//! What travels, as the graph shows it: counted on the particles, and against what a step sends.

use crate::common;
use crate::shown::{Shown, shown};
use engine::exec::ranks::local::Local;
use engine::exec::ranks::{Channel, Network, NetworkError, collective};
use engine::graph::recipe::Why;
use engine::graph::task::Domain;
use engine::graph::traffic::{Between, LINE, Messages, names};
use engine::schema::{Label, LabelId};
use grid::{Level, around};
use scene::Scene;
use scene::sampling;
use simd::{Isa, Wide};
use sinew::lab::diagram::Kind;
use sinew::simulation::Simulation;
use sinew::simulation::layout::level;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Barrier, Mutex};
use tasks::labels::{ContactSums, NodeMotion, NodeSums};
use tasks::recipes;

/// By material and block: the lowest and highest base node on each axis.
type Blocks = BTreeMap<(usize, [i32; 3]), ([i32; 3], [i32; 3])>;

/// Blocks of a scene from its particles alone: material and block, with the lowest and highest base node on each axis.
fn blocks(scene: &Scene, level: &Level) -> Blocks {
    let mut blocks = BTreeMap::new();
    let rigid = |m: usize| matches!(scene.materials[m].behavior, scene::Behavior::Rigid(_));
    for body in scene.bodies.iter().filter(|body| !rigid(body.material)) {
        let half = recipes::half_size(scene, body.material);
        for x in sampling::sample(scene, body) {
            let y: [f64; 3] = std::array::from_fn(|a| (x[a] - level.lower[a]) / level.cell - half[a]);
            let block = y.map(|y| (y.floor() as i32).div_euclid(4));
            let (low, high) = blocks.entry((body.material, block)).or_insert(([i32::MAX; 3], [i32::MIN; 3]));
            for a in 0..3 {
                // stencils may round differently by a millionth of a cell
                low[a] = low[a].min((y[a] - 1e-6).floor() as i32);
                high[a] = high[a].max((y[a] + 1e-6).floor() as i32);
            }
        }
    }
    blocks
}

/// (from, to) -> (label, material) -> lines.
type Counted = BTreeMap<(usize, usize), BTreeMap<(String, usize), u64>>;

/// Lines from patch to patch (or to rank), node by node; of motion, those in a box around what is read of a block.
fn brute(shown: &Shown, part: impl Fn(usize) -> usize) -> Counted {
    let level = level(&shown.scene);
    let owner = |block| shown.plan.decomposition.owner(block);
    let blocks = blocks(&shown.scene, &level);
    let mut lines: Counted = BTreeMap::new();
    let mut read: BTreeMap<_, ([i32; 3], [i32; 3])> = BTreeMap::new();
    for (&(material, block), &(low, high)) in &blocks {
        let from = owner(block).expect("a patch");
        let near = blocks.keys().any(|&(other, b)| {
            other != material && (0..3).all(|a| (b[a] - block[a]).abs() <= 2) && {
                let pair = [material.min(other), material.max(other)];
                shown.scene.contacts.iter().any(|c| c.between == pair)
            }
        });
        for x in low[0]..high[0] + 3 {
            for y in low[1]..high[1] + 3 {
                for z in low[2]..high[2] + 3 {
                    let Some(to) = owner([x, y, z].map(|n| n.div_euclid(4))) else { continue };
                    let mut add = |label: &str| {
                        let count = lines.entry((from, part(to))).or_default();
                        *count.entry((label.to_owned(), material)).or_default() += 1;
                    };
                    add("NodeSums");
                    if near {
                        add("ContactSums");
                    }
                    let node = [x, y, z];
                    let key = (to, part(from), material, node.map(|n| n.div_euclid(4)));
                    let (low, high) = read.entry(key).or_insert((node, node));
                    for a in 0..3 {
                        (low[a], high[a]) = (low[a].min(node[a]), high[a].max(node[a]));
                    }
                }
            }
        }
    }
    for ((from, to, material, _), (low, high)) in read {
        let nodes: i32 = (0..3).map(|a| high[a] + 1 - low[a]).product();
        let count = lines.entry((from, to)).or_default();
        *count.entry(("NodeMotion".to_owned(), material)).or_default() += nodes as u64;
    }
    lines
}

#[test]
fn lines_between_patches_and_ranks_are_those_that_particles_touch() {
    for (name, patches) in [("slab-quick", [2, 1, 2]), ("two-spheres", [2, 1, 2]), ("slab-rigid", [2, 1, 2])]
    {
        let shown = shown(name, &[], patches, 3);
        let traffic = &shown.plan.traffic;
        let named = |pairs: &Between, bytes: &dyn Fn(usize, usize, LabelId, usize) -> u64| -> Counted {
            let mut named = Counted::new();
            let keys = || {
                [NodeSums::ID, ContactSums::ID, NodeMotion::ID]
                    .into_iter()
                    .flat_map(|label| (0..shown.scene.materials.len()).map(move |m| (label, m)))
            };
            for (&(from, to), (label, material)) in
                pairs.keys().flat_map(|pair| keys().map(move |key| (pair, key)))
            {
                let bytes = bytes(from, to, label, material);
                if bytes > 0 {
                    named
                        .entry((from, to))
                        .or_default()
                        .insert((label.name().to_owned(), material), bytes / LINE);
                }
            }
            named
        };
        // a rigid body has no lines, and its neighborhood is that of its shape: the sums near it are not counted here
        let counted = |all: Counted| -> Counted {
            let mut all = all;
            if name == "slab-rigid" {
                all.values_mut().for_each(|lines| lines.retain(|(label, _), _| label != "ContactSums"));
            }
            all
        };
        let patches = named(&traffic.between, &|from, to, label, m| traffic.patch_bytes(from, to, label, m));
        let ranks = named(&traffic.to_rank, &|from, to, label, m| traffic.rank_bytes(from, to, label, m));
        assert_eq!(counted(patches), counted(brute(&shown, |patch| patch)), "{name}");
        assert_eq!(counted(ranks), counted(brute(&shown, |patch| traffic.rank_of[patch])), "{name}");
        // what a diagram says is the same in both forms
        let bytes = |expanded: bool, wanted: &dyn Fn(Kind) -> bool| -> u64 {
            let diagram = shown.diagram(expanded);
            let into = diagram.links.iter().filter(|link| wanted(diagram.items[link.to].kind));
            into.map(|link| link.bytes).sum()
        };
        let halos = |kind| matches!(kind, Kind::Halo(_));
        assert!(bytes(false, &halos) > 0);
        assert_eq!(bytes(false, &halos), bytes(true, &halos), "{name}");
        for expanded in [false, true] {
            let diagram = shown.diagram(expanded);
            let sent: u64 = diagram.items.iter().filter(|i| halos(i.kind)).map(|i| i.messages.bytes).sum();
            let heads = traffic.to_rank.iter().filter(|((p, to), _)| traffic.rank_of[*p] != *to);
            let heads = heads.flat_map(|(_, passing)| passing.iter().zip(&traffic.fields));
            let heads: u64 = heads.map(|(passing, &fields)| fields * LINE * passing.adders).sum();
            assert_eq!(sent, heads + bytes(expanded, &halos), "{name}");
        }
    }
}

#[test]
fn the_outline_of_a_scene_is_what_a_simulation_begins_with() {
    let shown = shown("slab-quick", &[], [2, 1, 2], 1);
    let mut scene = shown.scene.clone();
    (scene.run.patches, scene.run.threads) = (Some(scene::Patches::Grid([2, 1, 2])), Some(1));
    let simulation = common::start(scene);
    let whole = grid::Partition::alone(4);
    assert_eq!(engine::exec::traffic::count(&simulation.warehouse, &whole), shown.plan.traffic);
}

#[test]
fn an_expanded_graph_has_an_item_for_each_task_where_it_runs() {
    let shown = shown("slab-quick", &[], [2, 2, 2], 4);
    let (graph, traffic) = (shown.graph(), &shown.plan.traffic);
    let level = level(&shown.scene);
    let owner = |block| shown.plan.decomposition.owner(block);
    let mut particles = BTreeSet::new();
    let mut nodes = BTreeSet::new();
    for (material, block) in blocks(&shown.scene, &level).into_keys() {
        particles.extend(owner(block).map(|patch| (patch, material)));
        for d in around() {
            nodes.extend(owner([0, 1, 2].map(|a| block[a] + d[a])));
        }
    }
    let with = |m: usize| particles.iter().filter(|(_, material)| *material == m).count();
    let places = |node: &engine::graph::recipe::TaskNode| match (node.declaration.domain, node.material) {
        (Domain::Once, _) => 4,
        (Domain::Nodes, _) => nodes.len(),
        (_, material) => with(material.expect("a material")),
    };
    let diagram = shown.diagram(true);
    for at in graph.graph.node_indices() {
        assert_eq!(diagram.of(Kind::Task(at)).count(), places(&graph.graph[at]), "{}", graph.graph[at].name);
    }
    let pairs: BTreeSet<_> = brute(&shown, |patch| traffic.rank_of[patch])
        .into_keys()
        .map(|(p, r)| (traffic.rank_of[p], r))
        .collect();
    let pairs = pairs.iter().filter(|(a, b)| a != b).count();
    let halos = graph.phases.iter().enumerate().filter(|(_, phase)| !phase.halos.is_empty());
    assert!(halos.clone().count() == 2 && pairs > 4);
    for (phase, _) in halos {
        assert!(diagram.of(Kind::Halo(phase)).count() <= pairs);
        assert!(
            diagram.of(Kind::Halo(phase)).all(|halo| halo.messages.count == 1 && halo.messages.bytes > 0)
        );
    }
    assert_eq!(diagram.of(Kind::Reduction(None)).count(), 4);
    assert_eq!(diagram.of(Kind::Relocation).count(), 4);

    // edges that stay where they are: one a place
    let stays = |e: petgraph::stable_graph::EdgeIndex| {
        let (from, to) = graph.graph.edge_endpoints(e).expect("ends");
        let domains = [from, to].map(|n| graph.graph[n].declaration.domain == Domain::Nodes);
        (graph.graph[e].why != Why::Flow || domains[0] == domains[1])
            .then(|| [from, to].map(|n| places(&graph.graph[n])).into_iter().max().unwrap_or(0))
    };
    let expected: usize = graph.graph.edge_indices().filter_map(stays).sum();
    let task = |at: usize| match diagram.items[at].kind {
        Kind::Task(node) => Some(graph.graph[node].declaration.domain == Domain::Nodes),
        _ => None,
    };
    let found = diagram.links.iter().filter(|link| match (task(link.from), task(link.to)) {
        (Some(a), Some(b)) => link.why != Why::Flow || a == b,
        _ => false,
    });
    let once_to_nodes = graph.graph.edge_indices().filter(|&e| {
        let (from, to) = graph.graph.edge_endpoints(e).expect("ends");
        graph.graph[from].declaration.domain == Domain::Once
            && graph.graph[to].declaration.domain == Domain::Nodes
    });
    assert!(once_to_nodes.count() > 0);
    assert_eq!(found.count(), expected);
}

/// Channel, sender, receiver and lines of a message.
type Sent = (Channel, usize, usize, usize);

/// A rank that notes what it sends.
struct Noting(Local, Arc<Mutex<Vec<Sent>>>);

impl Noting {
    fn crew(ranks: usize) -> (Vec<Noting>, Arc<Mutex<Vec<Sent>>>) {
        let list = Arc::new(Mutex::new(Vec::new()));
        (Local::crew(ranks).into_iter().map(|rank| Noting(rank, list.clone())).collect(), list)
    }
}

impl Network for Noting {
    fn rank(&self) -> usize {
        self.0.rank()
    }
    fn size(&self) -> usize {
        self.0.size()
    }
    fn send(&mut self, to: usize, channel: Channel, message: Vec<Wide>) {
        self.1.lock().expect("the list").push((channel, self.rank(), to, message.len()));
        self.0.send(to, channel, message);
    }
    fn expect(&mut self, from: usize, channel: Channel, most: usize) {
        self.0.expect(from, channel, most);
    }
    fn arrived(&mut self, from: usize, channel: Channel) -> Result<Option<Vec<Wide>>, NetworkError> {
        self.0.arrived(from, channel)
    }
    fn receive(&mut self, from: usize, channel: Channel) -> Result<Vec<Wide>, NetworkError> {
        self.0.receive(from, channel)
    }
    fn settle(&mut self) {
        self.0.settle();
    }
}

#[test]
fn a_reduction_sends_the_messages_that_the_graph_shows() {
    for ranks in 1..=8 {
        let shown = shown("slab-quick", &[], [2, 2, 2], ranks);
        let (crew, sent) = Noting::crew(ranks);
        std::thread::scope(|scope| {
            for mut rank in crew {
                scope.spawn(move || {
                    collective::reduce(&mut rank, &mut vec![Wide::default()], |_, _| {})
                        .expect("all are here");
                });
            }
        });
        let mut sent: Vec<_> = sent.lock().expect("the list").iter().map(|&(_, a, b, _)| (a, b)).collect();
        let mut wanted = shown.plan.traffic.reduction.clone();
        sent.sort_unstable();
        wanted.sort_unstable();
        assert_eq!(sent, wanted, "{ranks} ranks");
    }
}

#[test]
fn the_first_step_sends_what_the_graph_shows_to_the_byte() {
    for (name, patches, ranks) in [
        ("slab-quick", [2, 2, 2], 3),
        ("slab-quick", [3, 1, 2], 4),
        ("two-spheres", [2, 1, 2], 2),
        ("sliding-block", [4, 1, 1], 3),
        ("slab-rigid", [2, 1, 2], 3),
    ] {
        let mut shown = shown(name, &[], patches, ranks);
        (shown.scene.run.threads, shown.scene.run.steps) = (Some(1), Some(1));
        let (crew, sent) = Noting::crew(ranks);
        let ready = Barrier::new(ranks);
        std::thread::scope(|scope| {
            for rank in crew {
                let (scene, ready, sent) = (shown.scene.clone(), &ready, &sent);
                scope.spawn(move || {
                    let on = Simulation::on(Box::new(rank), scene, Isa::detect());
                    let mut simulation = on.unwrap_or_else(|e| panic!("{e}"));
                    // what it took to begin does not count
                    if ready.wait().is_leader() {
                        sent.lock().expect("the list").clear();
                    }
                    ready.wait();
                    simulation.step().unwrap_or_else(|e| panic!("{e}"));
                });
            }
        });
        let mut on_channel: BTreeMap<Channel, BTreeMap<(usize, usize), Messages>> = BTreeMap::new();
        for &(channel, from, to, lines) in &*sent.lock().expect("the list") {
            let pairs = on_channel.entry(channel).or_default();
            pairs.entry((from, to)).or_default().add(1, 64 * lines as u64);
        }
        let mut wanted: BTreeMap<Channel, BTreeMap<(usize, usize), Messages>> = BTreeMap::new();
        let graphs = shown.program.graphs();
        let causes = graphs.iter().flat_map(|graph| {
            shown.plan.traffic.by_cause(graph).into_iter().map(move |(about, pairs)| (graph, about, pairs))
        });
        for (graph, about, pairs) in causes {
            let exchange = |about| graph.exchanges.iter().position(|e| names(&e.labels) == about);
            let channel = match about.as_str() {
                "relocation" => Channel::Travelers,
                about if about.starts_with("reduction") => Channel::Reduction,
                about => Channel::Halo(exchange(about).expect("an exchange") as u16),
            };
            let sum = wanted.entry(channel).or_default();
            pairs.iter().for_each(|(&pair, m)| sum.entry(pair).or_default().add(m.count, m.bytes));
        }
        assert!(wanted.values().all(|pairs| !pairs.is_empty()), "{wanted:?}");
        if name != "slab-rigid" {
            assert_eq!(on_channel, wanted, "{name} {patches:?} on {ranks} ranks");
            continue;
        }
        // a rigid body is measured anew before the first step, without the margin of a particle that has just come
        for (channel, pairs) in wanted {
            let sent = &on_channel[&channel];
            assert!(sent.keys().eq(pairs.keys()), "{channel:?}: {sent:?} instead of {pairs:?}");
            let below =
                sent.iter().all(|(pair, m)| m.count == pairs[pair].count && m.bytes <= pairs[pair].bytes);
            assert!(below, "{channel:?}: {sent:?} instead of {pairs:?}");
        }
    }
}
