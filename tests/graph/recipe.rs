//! Graphs from declarations: what is derived, refused, pruned, fused and exported.

use crate::common;
use crate::common::tasks;
use engine::graph::build::TaskGraph;
use engine::graph::error::GraphError;
use engine::graph::recipe::{Recipe, RecipeLine, Why};
use engine::graph::task::{Domain, Runnable};
use engine::schema::{Label, LabelId};
use petgraph::stable_graph::NodeIndex;
use scene::Scene;
use sinew::lab::diagram::export::Shown;
use sinew::simulation::{rates, step_graph, step_program};
use tasks::labels::*;

tasks! {
    Particles make_flow MakeFlow { requires old { mass: Mass } computes { flow: MassFlow } }
    Particles use_flow UseFlow { requires new { flow: MassFlow } modifies { velocity: Velocity } }
    Particles spread Spread { requires new { flow: MassFlow } computes { nodes: NodeSums @ 3 } }
    Particles collect Collect { requires new { nodes: NodeMotion @ 3 } modifies { position: Position } }
    Particles reach_far ReachFar { requires new { nodes: NodeMotion @ 4 } modifies { position: Position } }
    Particles see_ghosts SeeGhosts { requires old { velocity: Velocity @ 1 } modifies { position: Position } }
    Nodes solve Solve { requires new { sums: NodeSums } computes { motion: NodeMotion } }
    Particles look_back LookBack { requires old { velocity: Velocity } modifies { position: Position } }
    Particles look_now LookNow { requires now { velocity: Velocity } modifies { position: Position } }
    Particles accelerate Accelerate { modifies { velocity: Velocity } }
    Particles accelerate_again AccelerateAgain { modifies { velocity: Velocity } }
    Particles set_volume SetVolume { requires old { mass: Mass } computes { volume: Volume } }
    Particles set_again SetVolumeAgain { requires old { mass: Mass } computes { volume: Volume } }
    Particles use_volume UseVolume { requires new { volume: Volume } modifies { velocity: Velocity } }
    Particles speed Speed { requires now { velocity: Velocity } computes { speed: SignalSpeed } }
    Particles speed_again SpeedAgain { requires now { position: Position } computes { speed: SignalSpeed } }
    Once tick Tick { requires old { speed: SignalSpeed } modifies { time: Time } }
}

type Line = (Option<usize>, Box<dyn Runnable>);

fn line(material: usize, task: impl Runnable + 'static) -> Line {
    (Some(material), Box::new(task))
}

fn shared(task: impl Runnable + 'static) -> Line {
    (None, Box::new(task))
}

/// The graph of a recipe of two materials on four patches; all that it writes to particles is wanted.
fn graph<const N: usize>(lines: [Line; N]) -> Result<TaskGraph, GraphError> {
    let entries = lines.map(|(material, task)| RecipeLine { task, material, because: String::new() });
    let recipe =
        Recipe { entries: entries.into(), ..Recipe::new(&SCHEMA, vec!["wood".into(), "iron".into()]) };
    TaskGraph::build(recipe, &[Velocity::ID, Position::ID, Volume::ID, Time::ID], 4)
}

/// Edges as (source, target, label, why), in the order of the recipe.
fn edges(graph: &TaskGraph) -> Vec<(&str, &str, &str, Why)> {
    let name = |node: NodeIndex| graph.graph[node].name.as_str();
    let mut edges: Vec<_> =
        graph.graph.edge_indices().filter_map(|e| Some((graph.graph.edge_endpoints(e)?, e))).collect();
    edges.sort();
    edges
        .iter()
        .map(|&((a, b), e)| (name(a), name(b), graph.graph[e].label.name(), graph.graph[e].why))
        .collect()
}

#[track_caller]
fn refused<const N: usize>(lines: [Line; N], facts: &[&str]) -> GraphError {
    let Err(error) = graph(lines) else { panic!("accepted") };
    for fact in facts {
        assert!(error.to_string().contains(fact), "{fact:?} is not in: {error}");
    }
    error
}

#[test]
fn data_flow_from_who_writes_to_who_reads() {
    let graph = graph([line(0, MakeFlow), line(0, UseFlow)]).expect("a graph");
    assert_eq!(edges(&graph), [("MakeFlow[wood]", "UseFlow[wood]", "MassFlow", Why::Flow)]);
}

#[test]
fn what_is_still_read_is_not_overwritten() {
    let graph = graph([line(0, LookBack), line(0, Accelerate)]).expect("a graph");
    assert_eq!(edges(&graph), [("LookBack[wood]", "Accelerate[wood]", "Velocity", Why::WriteAfterRead)]);
}

#[test]
fn writers_of_one_label_keep_their_order() {
    let again = graph([line(0, SetVolume), line(0, UseVolume), line(0, SetVolumeAgain)]).expect("a graph");
    let expected = [
        ("SetVolume[wood]", "UseVolume[wood]", "Volume", Why::Flow),
        ("SetVolume[wood]", "SetVolumeAgain[wood]", "Volume", Why::WriteAfterWrite),
        ("UseVolume[wood]", "SetVolumeAgain[wood]", "Volume", Why::WriteAfterRead),
    ];
    assert_eq!(edges(&again), expected);
    // who adds to a label sees what was there
    let twice = graph([line(0, Accelerate), line(0, AccelerateAgain)]).expect("a graph");
    assert_eq!(edges(&twice), [("Accelerate[wood]", "AccelerateAgain[wood]", "Velocity", Why::Flow)]);
}

#[test]
fn materials_meet_at_nodes_and_nowhere_else() {
    let lines = [
        line(0, MakeFlow),
        line(0, Spread),
        line(1, MakeFlow),
        line(1, Spread),
        shared(Solve),
        line(1, Collect),
    ];
    let graph = graph(lines).expect("a graph");
    let expected = [
        ("MakeFlow[wood]", "Spread[wood]", "MassFlow", Why::Flow),
        ("Spread[wood]", "Solve", "NodeSums", Why::Flow),
        ("MakeFlow[iron]", "Spread[iron]", "MassFlow", Why::Flow),
        ("Spread[iron]", "Solve", "NodeSums", Why::Flow),
        ("Solve", "Collect[iron]", "NodeMotion", Why::Flow),
    ];
    assert_eq!(edges(&graph), expected);
    let ghosts: Vec<u8> = graph.graph.edge_weights().map(|edge| edge.ghost).collect();
    assert_eq!(
        ghosts.iter().filter(|&&ghost| ghost == 3).count(),
        1,
        "Collect reads three layers around its block"
    );
}

#[test]
fn contributions_to_a_sum_need_no_order() {
    let lines = [line(0, Accelerate), line(0, Speed), line(0, Collect), line(0, SpeedAgain)];
    let lines = [line(0, MakeFlow), line(0, Spread), shared(Solve)].into_iter().chain(lines);
    let lines: [Line; 7] = lines.collect::<Vec<_>>().try_into().unwrap_or_else(|_| panic!("seven lines"));
    let graph = graph(lines).expect("a graph");
    assert!(!edges(&graph).iter().any(|edge| edge.2 == "SignalSpeed"), "{:?}", edges(&graph));
}

#[test]
fn a_label_without_producer_is_refused() {
    let error =
        refused([line(1, UseFlow)], &["UseFlow[iron]", "MassFlow", "patches 0 to 3", "no task computes"]);
    assert!(matches!(error, GraphError::NoProducer { .. }));
    // what the other material computes is no help
    refused([line(0, MakeFlow), line(1, UseFlow)], &["UseFlow[iron]", "MassFlow", "no task computes"]);
}

#[test]
fn a_producer_that_comes_later_is_refused() {
    let facts = ["UseFlow[wood]", "MassFlow", "patches 0 to 3", "MakeFlow computes it only later"];
    let error = refused([line(0, UseFlow), line(0, MakeFlow)], &facts);
    assert!(matches!(error, GraphError::RequiresBeforeComputes { .. }));
}

#[test]
fn an_old_value_that_was_overwritten_is_refused() {
    let facts = ["LookBack[wood]", "old Velocity", "patches 0 to 3", "Accelerate[wood] has overwritten"];
    let error = refused([line(0, Accelerate), line(0, LookBack)], &facts);
    assert!(matches!(error, GraphError::OldAfterWrite { .. }));
    assert!(graph([line(0, Accelerate), line(0, LookNow)]).is_ok(), "the value of now is whatever it is");
}

#[test]
fn two_producers_of_which_one_is_idle_are_refused() {
    let facts = ["SetVolumeAgain[wood]", "Volume", "patches 0 to 3", "SetVolume[wood]"];
    let error = refused([line(0, SetVolume), line(0, SetVolumeAgain)], &facts);
    assert!(matches!(error, GraphError::TwoProducers { .. }));
    assert!(graph([line(0, SetVolume), line(1, SetVolumeAgain)]).is_ok(), "of different materials");
}

#[test]
fn more_ghosts_than_are_stored_are_refused() {
    let nodes = || [line(0, MakeFlow), line(0, Spread), shared(Solve)];
    let [a, b, c] = nodes();
    let error = refused(
        [a, b, c, line(0, ReachFar)],
        &["ReachFar[wood]", "NodeMotion", "4 ghost", "patch 0 stores 3"],
    );
    assert!(matches!(error, GraphError::GhostTooWide { .. }));
    refused([line(0, SeeGhosts)], &["SeeGhosts[wood]", "Velocity", "1 ghost", "patch 0 stores 0"]);
}

#[test]
fn a_chunk_label_that_leaves_its_stage_is_refused() {
    let lines = [line(0, MakeFlow), line(0, Spread), shared(Solve), line(0, Collect), line(0, UseFlow)];
    let facts = ["UseFlow[wood]", "MassFlow", "patches 0 to 3", "chunk of MakeFlow[wood]"];
    let error = refused(lines, &facts);
    assert!(matches!(error, GraphError::ChunkLabelEscapes { .. }));
    let [flow, spread, solve, collect] =
        [line(0, MakeFlow), line(0, Spread), shared(Solve), line(0, Collect)];
    let again = [flow, spread, solve, collect, line(0, MakeFlow), line(0, UseFlow)];
    assert!(graph(again).is_ok(), "computed again, it is there");
    let pruned = [line(0, MakeFlow), line(0, Spread), shared(Solve), line(0, UseFlow)];
    assert!(graph(pruned).is_ok(), "nobody wants the nodes: there is but one stage");
}

fn build(lines: Vec<Line>, outputs: &[LabelId]) -> TaskGraph {
    let entries =
        lines.into_iter().map(|(material, task)| RecipeLine { task, material, because: String::new() });
    let recipe =
        Recipe { entries: entries.collect(), ..Recipe::new(&SCHEMA, vec!["wood".into(), "iron".into()]) };
    TaskGraph::build(recipe, outputs, 1).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn idle_tasks_go_unless_an_output_asks_for_them() {
    let lines =
        || vec![line(0, SetVolume), line(0, MakeFlow), line(0, Spread), shared(Solve), line(0, Accelerate)];
    let lean = build(lines(), &[]);
    // velocity passes to the next step; nobody reads the volume, or the nodes, and so not what they are made of
    assert_eq!(lean.pruned.len(), 4, "{:?}", lean.pruned);
    assert!(
        ["SetVolume[wood]", "MakeFlow[wood]", "Spread[wood]", "Solve"]
            .iter()
            .all(|n| lean.pruned.contains(&(*n).into()))
    );
    assert_eq!(lean.phases.len(), 1);
    let asked = build(lines(), &[Volume::ID]);
    assert!(!asked.pruned.contains(&"SetVolume[wood]".to_owned()), "{:?}", asked.pruned);
    let nodes = build(lines(), &[NodeMotion::ID]);
    assert_eq!(nodes.pruned, ["SetVolume[wood]"]);
}

#[test]
fn what_the_next_step_reads_stays() {
    let lines = vec![shared(Tick), line(0, Accelerate), line(0, Speed)];
    let graph = build(lines, &[]);
    assert_eq!(graph.pruned, [""; 0], "the step size of the next step needs the speed of this one");
    let carried: Vec<&str> = graph.carried.iter().map(|label| label.name()).collect();
    assert_eq!(carried, ["Velocity", "SignalSpeed", "Time"]);
}

/// Names of the tasks of each stage, phase by phase.
fn stages(graph: &TaskGraph) -> Vec<Vec<Vec<&str>>> {
    let names = |nodes: &[NodeIndex]| nodes.iter().map(|&n| graph.graph[n].declaration.name).collect();
    graph.phases.iter().map(|phase| phase.stages.iter().map(|s| names(&s.nodes)).collect()).collect()
}

fn step(scene: &Scene) -> TaskGraph {
    step_graph(scene, 8).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn the_step_of_the_slab_is_two_sweeps_over_particles_around_one_over_nodes() {
    let graph = step(&common::problem("slab", &[]));
    let gather = ["Mirror", "Weights", "Gather", "Stress", "Advance", "SignalSpeed"];
    let scatter = [
        "Weights",
        "MassFlow",
        "StressFlow",
        "Scatter",
        "ContactFlow",
        "ContactScatter",
        "Fold",
        "FoldSurfaces",
    ];
    let nodes = [
        "NodalVelocity",
        "ContactBegin",
        "Contact",
        "Integrate",
        "Contact",
        "Boundary",
        "ContactPower",
        "GridPower",
    ];
    assert_eq!(
        stages(&graph),
        [
            vec![vec!["TimestepSize"]],
            vec![scatter.to_vec(); 2],
            vec![nodes.to_vec()],
            vec![gather.to_vec(); 2],
            vec![vec!["AdvanceClock"]],
        ]
    );
    let domains: Vec<Domain> = graph.phases.iter().map(|phase| phase.stages[0].domain).collect();
    assert_eq!(domains, [Domain::Once, Domain::Particles, Domain::Nodes, Domain::Particles, Domain::Once]);
    assert_eq!(graph.pruned, [""; 0]);
}

const ONE: &str = r#"
[domain]
lower = [0, 0, 0]
upper = [8, 8, 8]
cell = 1
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "1 MPa"
[[body]]
name = "block"
material = "soft"
shape = { box = { lower = [2, 2, 2], upper = [6, 6, 6] } }
[run]
until = 1
"#;

/// Names of all tasks of the step.
fn names(scene: &Scene) -> Vec<&'static str> {
    step(scene).graph.node_weights().map(|node| node.declaration.name).collect()
}

#[test]
fn a_scene_has_the_tasks_that_it_asks_for_and_no_others() {
    let plain = [
        "TimestepSize",
        "Weights",
        "MassFlow",
        "StressFlow",
        "Scatter",
        "NodalVelocity",
        "Integrate",
        "GridPower",
        "Weights",
        "Gather",
        "Stress",
        "Advance",
        "SignalSpeed",
        "AdvanceClock",
    ];
    assert_eq!(names(&common::scene(ONE, &[])), plain);
    let loads: &[&str] = &["Loads", "LoadPower"];
    for (key, value, asked, line) in [
        ("load.gravity", "[0, 0, -9.81]", loads, "load"),
        ("load.damping", "3", loads, "load"),
        ("run.viscosity", "{}", &["Viscosity"], "run.viscosity"),
        ("boundary.x-min", "fixed", &["Fold", "Boundary", "Mirror"], "boundary"),
        (
            "drive",
            "[{ material = \"soft\", region = { box = { lower = [2, 2, 2], upper = [3, 6, 6] } }, velocity = [0, 0, 1] }]",
            &["DriveScatter", "DriveNodes", "Drive"],
            "drive",
        ),
    ] {
        let scene = common::scene(ONE, &[(key, value)]);
        let mut more = names(&scene);
        for task in asked {
            assert_eq!(more.iter().filter(|name| *name == task).count(), 1, "{key} asks for one {task}");
            let reason = step(&scene).why(task);
            assert!(reason.iter().all(|(_, because)| because == line), "{reason:?}");
            assert_eq!(reason.len(), 1);
        }
        more.retain(|name| !asked.contains(name));
        assert_eq!(more, plain, "{key} asks for nothing else");
    }
}

#[test]
fn labels_that_no_task_uses_take_no_memory() {
    let labels = |overrides| step(&common::scene(ONE, overrides)).particle_labels(0);
    let unused = [ViscousWork::ID, DriveIndex::ID, ReferencePosition::ID];
    assert!(unused.iter().all(|label| !labels(&[]).contains(label)));
    assert!(labels(&[("run.viscosity", "{}")]).contains(&ViscousWork::ID));
    let simulation = common::start(common::scene(ONE, &[]));
    let widths = simulation.warehouse.materials[0].layout.widths.clone();
    let taken = unused.iter().chain(&[History::ID]).map(|label| widths[label.index()]);
    assert_eq!(taken.sum::<usize>(), 0, "neo-hookean keeps no history");
}

#[test]
fn materials_that_do_not_touch_have_no_contact() {
    let none = step(&common::problem("slab-quick", &[("contact", "")]));
    assert!(stages(&none).iter().flatten().flatten().all(|name| !name.contains("Contact")));
    let free = step_program(&common::problem("slab-rigid", &[]), 1).unwrap_or_else(|e| panic!("{e}"));
    let tasks = |number: usize| -> Vec<&str> {
        free.graphs()[number].graph.node_weights().map(|node| node.declaration.name).collect()
    };
    assert!(["RigidPredict", "ToolScatter", "RigidSites"].iter().all(|name| tasks(0).contains(name)));
    assert_eq!(tasks(1), ["RigidRound", "RigidSolve"]);
    assert!(["RigidPush", "RigidMotion", "Follow"].iter().all(|name| tasks(2).contains(name)));
    let rigid = step(&common::problem("sliding-block", &[]));
    let wanted = ["RigidPlan", "ToolScatter", "Tools", "RigidCarry"];
    let names: Vec<&str> = rigid.graph.node_weights().map(|node| node.declaration.name).collect();
    assert!(wanted.iter().all(|name| names.contains(name)), "{names:?}");
    assert!(wanted.iter().all(|name| !self::names(&common::scene(ONE, &[])).contains(name)));
}

#[test]
fn the_table_and_json_have_each_task_once() {
    let scene = common::problem("slab-quick", &[]);
    let (graph, cycle) = (step(&scene), rates::at_rest(&scene));
    let tasks = graph.graph.node_count();
    assert_eq!(tasks, 1 + 8 + 8 + 8 + 6 + 6 + 1);

    let json = Shown { graph: &graph, cycle: &cycle }.to_json().to_string();
    let json: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    let ids: std::collections::BTreeSet<u64> =
        json["tasks"].as_array().expect("tasks").iter().filter_map(|task| task["id"].as_u64()).collect();
    assert_eq!(ids.len(), tasks);
    assert_eq!(json["tasks"].as_array().map(Vec::len), Some(tasks));
    let edges = json["edges"].as_array().expect("edges");
    assert_eq!(edges.len(), graph.graph.edge_count());
    let known = |end: &serde_json::Value| end.as_u64().is_some_and(|id| ids.contains(&id));
    assert!(edges.iter().all(|edge| known(&edge["from"]) && known(&edge["to"])));

    let text = Shown { graph: &graph, cycle: &cycle }.to_text();
    assert_eq!(text.lines().filter(|line| line.starts_with("  ")).count(), tasks, "{text}");
}
