//! Programs: what passes between graphs and rounds, and what is wrong there.

use crate::common;
use crate::toy::*;
use engine::program::{Delay, Pass, Program, ProgramNode, RoundHazard, Script, Site, hazards, passes};
use engine::schema::{Label, LabelId};
use sinew::lab::plan;

#[track_caller]
fn program(script: Vec<Script>) -> Program {
    build(script).unwrap_or_else(|e| panic!("{e}"))
}

fn site(task: &str, graph: &str, label: LabelId) -> Site {
    Site { graph: graph.into(), task: task.into(), label }
}

/// The only hazard of a program, and what it says of it.
#[track_caller]
fn one(script: Vec<Script>, expected: RoundHazard, words: &[&str]) {
    let found = hazards(&program(script));
    assert_eq!(found, [expected]);
    let text = found[0].to_string();
    words.iter().for_each(|word| assert!(text.contains(word), "{word:?} is not in: {text}"));
}

fn collect() -> Script {
    graph!("collect": WOOD => Collect)
}

#[test]
fn a_loop_in_a_loop_is_clean_and_says_what_it_passes_on() {
    let nested = nested();
    assert_eq!(hazards(&nested), []);
    let all = passes(&nested);
    let name = |number: usize| nested.graphs()[number].name;
    let of = |label: LabelId, material| {
        let mine = all.iter().filter(move |p: &&Pass| p.label == label && p.material == material);
        mine.map(|p| (name(p.from), name(p.to), p.delay)).collect::<Vec<_>>()
    };
    let field = [
        ("start", "iterate", Delay::Onward),
        ("iterate", "iterate", Delay::NextRound),
        ("iterate", "collect", Delay::Onward),
    ];
    assert_eq!(of(Field::ID, Some(WOOD)), field);
    assert_eq!(of(Field::ID, Some(IRON)), field);
    assert_eq!(of(Residual::ID, None), [("iterate", "update", Delay::Onward)]);
    assert_eq!(
        of(Load::ID, Some(IRON)),
        [("collect", "start", Delay::NextStep), ("collect", "collect", Delay::NextStep)]
    );
    let tasks = |graph: usize, nodes: &[petgraph::stable_graph::NodeIndex]| {
        nodes.iter().map(|&n| nested.graphs()[graph].graph[n].name.clone()).collect::<Vec<_>>()
    };
    let round = all.iter().find(|p| p.delay == Delay::NextRound && p.material == Some(IRON)).expect("a pass");
    assert_eq!(tasks(round.from, &round.writers), ["Correct"]);
    assert_eq!(tasks(round.to, &round.readers), ["Push[iron]", "Correct"]);
}

#[test]
fn a_loop_that_runs_once_has_no_next_round() {
    let once = |most| {
        let inner = graph!("iterate": WOOD => Push, None => Correct, None => Judge);
        program(vec![
            graph!("start": WOOD => Scatter, None => Solve),
            repeat(Close::ID, most, vec![inner]),
            collect(),
        ])
    };
    let back = |most| passes(&once(most)).iter().filter(|pass| pass.delay == Delay::NextRound).count();
    assert_eq!(back(1), 0);
    assert!(back(2) > 0);
}

#[test]
fn what_nobody_has_left_is_found() {
    let expected = RoundHazard::NotLeft(site("Collect[wood]", "collect", Field::ID));
    one(
        vec![collect()],
        expected,
        &["not left", "Collect[wood]", "graph collect", "Field", "compute it before"],
    );
    // modifying it begins nothing
    let change = graph!("change": WOOD => Scatter, None => Correct);
    let expected = RoundHazard::NotLeft(site("Correct", "change", Field::ID));
    one(vec![change, collect()], expected, &["Correct", "graph change"]);
    // what comes later is left too late, outside of a loop
    let expected = RoundHazard::NotLeft(site("Collect[wood]", "collect", Field::ID));
    one(vec![collect(), graph!("start": WOOD => Scatter, None => Solve)], expected, &["graph collect"]);
}

#[test]
fn what_another_material_has_left_is_not_left() {
    let script = vec![graph!("speed": WOOD => Fast), graph!("heed": WOOD => Heed, IRON => Heed)];
    let expected = RoundHazard::NotLeft(site("Heed[iron]", "heed", Speed::ID));
    one(script, expected, &["Heed[iron]", "Speed"]);
}

#[test]
fn a_first_round_that_reads_what_only_rounds_leave_is_found() {
    let body = || {
        let make = graph!("make": WOOD => Scatter, None => Solve);
        vec![graph!("look": None => Look), make]
    };
    let expected = RoundHazard::FirstRound { site: site("Look", "look", Residual::ID), from: "make".into() };
    let words = ["first round", "Look", "Residual", "graph make", "before the loop"];
    one(vec![repeat(Close::ID, 9, body()), collect()], expected, &words);
    let first = graph!("start": WOOD => Scatter, None => Solve);
    assert_eq!(hazards(&program(vec![first, repeat(Close::ID, 9, body()), collect()])), []);
}

#[test]
fn what_lives_too_short_for_another_graph_or_round_is_found() {
    let show = graph!("show": WOOD => Scatter, None => Show);
    let expected = |task, graph, label, from: &str| RoundHazard::ShortLived {
        site: site(task, graph, label),
        from: from.into(),
    };
    let words = ["short-lived", "lives for a graph", "live for a step"];
    one(vec![show, graph!("see": WOOD => See)], expected("See[wood]", "see", Brief::ID, "show"), &words);
    // the next round of the same graph, and of another one
    let script = |body| vec![start(), repeat(Close::ID, 9, body), collect()];
    let same = graph!("round": None => GlanceAgain, None => TakeGlance);
    let from_itself = expected("GlanceAgain", "round", Glance::ID, "round");
    one(script(vec![same]), from_itself, &words);
    let other = vec![graph!("again": None => GlanceAgain), graph!("take": None => TakeGlance)];
    one(script(other), expected("GlanceAgain", "again", Glance::ID, "take"), &words);
}

#[test]
fn sums_that_nobody_adds_up_are_refused() {
    let script = vec![graph!("keep": WOOD => Keep), graph!("use": None => UseKept), collect()];
    let refused = build(script).err().expect("a refusal").to_string();
    assert!(refused.contains("Keep[wood] adds to Kept") && refused.contains("read it there"), "{refused}");
    // in one graph they are
    assert_eq!(hazards(&program(vec![graph!("all": WOOD => Keep, None => UseKept), collect()])), []);
}

#[test]
fn nodes_that_particles_have_left_do_not_keep_what_they_had() {
    let advance = graph!("advance": WOOD => Advance);
    let expected = |by: &str| RoundHazard::Moved {
        site: site("Collect[wood]", "collect", Field::ID),
        from: "start".into(),
        by: by.into(),
    };
    one(vec![start(), advance, collect()], expected("advance"), &["moved", "graph advance", "Field"]);
    // round k moves them, and round k + 1 reads what came before the loop
    let round = graph!("collect": WOOD => Collect, WOOD => Advance, None => Look);
    one(vec![start(), repeat(Close::ID, 9, vec![round])], expected("collect"), &["graph collect moves"]);
    let round = graph!("collect": WOOD => Collect, WOOD => Advance, None => Look);
    assert_eq!(hazards(&program(vec![start(), repeat(Close::ID, 1, vec![round])])), []);
}

#[test]
fn ghosts_that_no_exchange_brings_are_found() {
    let mut broken = program(vec![start(), collect()]);
    assert_eq!(hazards(&broken), []);
    let Some(ProgramNode::Graph(last)) = broken.nodes.last_mut() else { panic!("a graph") };
    last.exchanges.clear();
    let found = hazards(&broken);
    assert_eq!(found, [RoundHazard::NotSent(site("Collect[wood]", "collect", Field::ID))]);
    assert!(found[0].to_string().contains("with ghosts"), "{}", found[0]);
}

#[test]
fn a_loop_that_waits_for_what_no_round_computes_is_found() {
    let before = graph!("look": WOOD => Scatter, None => Solve, None => Look);
    let script =
        vec![before, repeat(Close::ID, 9, vec![graph!("turn": WOOD => Push, None => Correct)]), collect()];
    let expected = RoundHazard::Endless { label: Close::ID, graphs: vec!["turn".into()] };
    one(script, expected, &["endless", "Close", "graphs turn"]);
    // an inner loop does not wait for what the outer one computes
    let inner = repeat(Done::ID, 9, vec![graph!("iterate": WOOD => Push, None => Correct, None => Judge)]);
    let outer = repeat(Done::ID, 9, vec![inner, graph!("update": None => Finish)]);
    let expected = RoundHazard::Endless { label: Done::ID, graphs: vec!["iterate".into()] };
    one(vec![start(), outer, collect()], expected, &["graphs iterate"]);
}

#[test]
fn shipped_scenes_are_clean_between_rounds() {
    for name in [
        "slab",
        "slab-150",
        "slab-quick",
        "slab-rigid",
        "sliding-block",
        "taylor-rod",
        "tension",
        "two-spheres",
    ] {
        for rates in ["common", "per-material"] {
            let scene = common::problem(name, &[("run.rates", rates)]);
            let (step, refusals) = plan::inspect(&scene, 1);
            assert_eq!((refusals, hazards(&step)), (vec![], vec![]), "{name}, {rates}");
        }
    }
}
