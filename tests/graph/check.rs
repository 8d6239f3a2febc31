//! Hazards in graphs that are wrong on purpose.

use crate::common;
use crate::common::tasks;

use engine::graph::build::TaskGraph;
use engine::graph::check::{Hazard, hazards};
use engine::graph::error::GraphError;
use engine::graph::recipe::{Recipe, RecipeLine};
use engine::graph::task::Runnable;
use engine::schema::Label;
use tasks::labels::*;

tasks! {
    Particles make_flow MakeFlow { requires old { mass: Mass } computes { flow: MassFlow } }
    Particles make_both MakeBoth { requires old { mass: Mass } computes { flow: MassFlow, more: StressFlow } }
    Particles spread Spread { requires new { flow: MassFlow } computes { nodes: NodeSums @ 3 } }
    Particles work Work { requires new { flow: MassFlow } computes { nodes: NodeSums @ 3 } scratch { rows: ScatterRows } }
    Particles collect Collect { requires new { nodes: NodeMotion @ 3 } modifies { position: Position } }
    Nodes solve Solve { requires new { sums: NodeSums } computes { motion: NodeMotion } }
    Particles look_back LookBack { requires old { velocity: Velocity } modifies { position: Position } }
    Particles accelerate Accelerate { modifies { velocity: Velocity } }
    Particles speed Speed { requires now { velocity: Velocity } computes { speed: SignalSpeed } }
    Particles again LookBackAndAgain {
        requires now { velocity: Velocity }
        computes { speed: SignalSpeed }
        modifies { position: Position }
    }
    Once fast Fast { requires new { speed: SignalSpeed } modifies { time: Time } }
}

fn build(lines: Vec<(Option<usize>, Box<dyn Runnable>)>) -> (TaskGraph, Vec<GraphError>) {
    let entries =
        lines.into_iter().map(|(material, task)| RecipeLine { task, material, because: String::new() });
    let recipe =
        Recipe { entries: entries.collect(), ..Recipe::new(&SCHEMA, vec!["wood".into(), "iron".into()]) };
    TaskGraph::inspect(recipe, &[Velocity::ID, Position::ID, Time::ID], 4)
}

macro_rules! lines {
    ($($material:expr => $task:expr),* $(,)?) => {
        vec![$(($material, Box::new($task) as Box<dyn Runnable>)),*]
    };
}

const WOOD: Option<usize> = Some(0);
const IRON: Option<usize> = Some(1);

fn cycle() -> Vec<(Option<usize>, Box<dyn Runnable>)> {
    lines![WOOD => MakeFlow, WOOD => Spread, IRON => MakeFlow, IRON => Spread, None => Solve, WOOD => Collect, IRON => Collect]
}

#[track_caller]
fn good(lines: Vec<(Option<usize>, Box<dyn Runnable>)>) -> TaskGraph {
    let (graph, refusals) = build(lines);
    assert_eq!(refusals, []);
    graph
}

#[test]
fn a_whole_cycle_is_clean_and_working_memory_is_not_idle() {
    assert_eq!(hazards(&good(cycle()), 4, &[]), []);
    let mut lines = cycle();
    lines[1] = (WOOD, Box::new(Work));
    assert_eq!(hazards(&good(lines), 4, &[]), []);
}

#[test]
fn an_edge_that_is_missing_is_a_race() {
    let mut graph = good(lines![WOOD => LookBack, WOOD => Accelerate, IRON => Accelerate]);
    assert_eq!(hazards(&graph, 4, &[]), []);
    let edges: Vec<_> = graph.graph.edge_indices().collect();
    edges.into_iter().for_each(|edge| {
        graph.graph.remove_edge(edge);
    });
    let race = Hazard::Race {
        first: "LookBack[wood]".into(),
        second: "Accelerate[wood]".into(),
        label: Velocity::ID,
    };
    let words = race.to_string();
    assert_eq!(hazards(&graph, 4, &[]), [race]);
    assert!(words.contains("LookBack[wood]") && words.contains("Velocity"), "{words}");
}

#[test]
fn nodes_that_are_read_before_all_have_given_are_found() {
    let mut graph = good(cycle());
    graph.phases.iter_mut().for_each(|phase| phase.halos.clear());
    let missing = |task: &str, label| Hazard::UndeclaredHalo { task: task.into(), label };
    let all = [
        missing("Solve", NodeSums::ID),
        missing("Collect[wood]", NodeMotion::ID),
        missing("Collect[iron]", NodeMotion::ID),
    ];
    assert_eq!(hazards(&graph, 4, &[]), all);
    // the nodes solved in the stage that gives to them
    let mut fused = good(cycle());
    let solve = fused.phases.remove(1);
    fused.phases[0].halos = solve.halos.clone();
    fused.phases[0].stages[0].nodes.extend(&solve.stages[0].nodes);
    assert!(hazards(&fused, 4, &[]).contains(&missing("Solve", NodeSums::ID)));
}

#[test]
fn a_label_that_nobody_reads_is_idle() {
    let mut lines = cycle();
    lines[0] = (WOOD, Box::new(MakeBoth));
    let graph = good(lines);
    let idle = Hazard::Idle { task: "MakeBoth[wood]".into(), label: StressFlow::ID };
    assert_eq!(hazards(&graph, 4, &[]), [idle]);
    assert_eq!(hazards(&graph, 4, &[StressFlow::ID]), []);
}

#[test]
fn ghosts_wider_than_a_patch_are_found() {
    let found = hazards(&good(cycle()), 2, &[]);
    let wide = |hazard: &&Hazard| matches!(hazard, Hazard::WideGhost { ghost: 3, narrowest: 2, .. });
    assert_eq!(found.iter().filter(wide).count(), 4, "two give, two take: {found:?}");
}

#[test]
fn a_reduction_that_is_read_before_all_have_added_is_found() {
    let early = good(lines![WOOD => Accelerate, WOOD => Speed, None => Fast, WOOD => LookBackAndAgain]);
    let expected = Hazard::EarlyReduction {
        task: "Fast".into(),
        label: SignalSpeed::ID,
        contributor: "LookBackAndAgain[wood]".into(),
    };
    assert!(hazards(&early, 4, &[]).contains(&expected), "{:?}", hazards(&early, 4, &[]));
    let late = good(lines![WOOD => Speed, IRON => Speed, None => Fast]);
    assert_eq!(hazards(&late, 4, &[]), []);
}

#[test]
fn what_only_one_of_several_materials_has_is_found() {
    let graph =
        good(lines![WOOD => MakeFlow, WOOD => Spread, None => Solve, WOOD => Collect, IRON => Collect]);
    let lonely = Hazard::OneMaterial { task: "Solve".into(), label: NodeSums::ID, material: "wood".into() };
    assert_eq!(hazards(&graph, 4, &[]), [lonely]);
}

#[test]
fn all_refusals_are_reported_at_once() {
    let (graph, refusals) =
        build(lines![WOOD => Spread, None => Solve, WOOD => Collect, WOOD => Accelerate, WOOD => LookBack]);
    assert!(
        matches!(refusals[..], [GraphError::NoProducer { .. }, GraphError::OldAfterWrite { .. }]),
        "{refusals:?}"
    );
    assert_eq!(graph.graph.node_count(), 5);
}

#[test]
fn shipped_scenes_are_clean() {
    for name in [
        "slab",
        "slab-150",
        "slab-coarse",
        "slab-quick",
        "slab-rigid",
        "sliding-block",
        "taylor-rod",
        "tension",
        "two-spheres",
    ] {
        for rates in ["common", "per-material"] {
            let scene = common::problem(name, &[("run.rates", rates)]);
            let (program, refusals) = sinew::lab::plan::inspect(&scene, 1);
            assert_eq!(refusals, []);
            assert_eq!(
                hazards(program.main_graph(), 4, &sinew::lab::plan::read_by_reports(&scene)),
                [],
                "{name}, {rates}"
            );
        }
    }
}
