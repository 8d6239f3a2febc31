//! The cycle of ticks in a step, as exports of the graph show it, and the rates that they estimate.

use crate::common::{Overrides, problem, scene, start};
use engine::data::rates::MaterialStep;
use engine::graph::build::TaskGraph;
use engine::graph::traffic::Traffic;
use engine::program::Program;
use engine::schema::Label;
use scene::Scene;
use sinew::lab::diagram::Chart;
use sinew::lab::diagram::export::Shown;
use sinew::simulation::rates::Cycle;
use sinew::simulation::{rates, step_graph, step_program};
use tasks::labels;

const OWN: Overrides<'_> = &[("run.rates", "per-material")];

fn export(scene: &Scene) -> (TaskGraph, Cycle) {
    (step_graph(scene, 1).unwrap_or_else(|e| panic!("{e}")), rates::at_rest(scene))
}

fn program(scene: &Scene) -> Program {
    step_program(scene, 1).unwrap_or_else(|e| panic!("{e}"))
}

/// The lines of a text that contain a word.
fn with<'a>(text: &'a str, word: &str) -> Vec<&'a str> {
    text.lines().filter(|line| line.contains(word)).collect()
}

#[test]
fn a_common_step_is_one_tick_and_the_text_does_not_mention_it() {
    let scene = problem("slab-quick", &[]);
    let (graph, cycle) = export(&scene);
    let text = Shown { graph: &graph, cycle: &cycle }.to_text();
    assert!(text.starts_with("phase 0: once\n  TimestepSize "), "{text}");
    assert!(text.contains("phase 1: particles, fused chunk by chunk of tissue\n"));
    assert!(!text.contains("tick") && !text.contains("when its step"), "{text}");
    let (program, traffic) = (program(&scene), Traffic::none(graph.recipe.materials.len()));
    let chart = Chart::new(&program, &cycle, &traffic, None, false);
    let dot = chart.to_dot();
    assert!(
        dot.contains("cluster_loop0 { label=\"loop until StepOver, once\"") && !dot.contains("cluster_tick")
    );
    assert!(
        chart.to_text().starts_with("program step\n  loop until StepOver, once\n    graph tick: 38 tasks\n")
    );
    let json = Shown { graph: &graph, cycle: &cycle }.to_json();
    assert_eq!((&json["rates"]["mode"], &json["rates"]["most"]), (&"common".into(), &1.into()));
    assert_eq!(graph.why("TimestepSize"), [("TimestepSize".to_owned(), String::new())]);
}

#[test]
fn the_text_shows_the_tick_in_the_step_and_when_each_material_acts() {
    let (graph, cycle) = export(&problem("slab-quick", OWN));
    let text = Shown { graph: &graph, cycle: &cycle }.to_text();
    let mut lines = text.lines();
    let estimate = lines.next().expect("rates");
    for word in ["estimates at rest", "tissue 37 ticks (", "lead 1 tick"] {
        assert!(estimate.contains(word), "{estimate}");
    }
    for material in ["tissue", "lead"] {
        for end in ["begins", "ends"] {
            let wanted = format!("chunk by chunk of {material}: when its step {end}");
            assert_eq!(with(&text, &wanted).len(), 1, "{wanted}: {text}");
        }
    }
    assert_eq!(with(&text, "phase 0: once each tick").len(), 1);
    assert_eq!(with(&text, "in blocks where the step of a material ends").len(), 1);
    assert_eq!(text.lines().filter(|l| l.starts_with("  ")).count(), graph.graph.node_count());
    assert_eq!(graph.why("TimestepSize"), [("TimestepSize".to_owned(), "run.rates".to_owned())]);
}

#[test]
fn dot_draws_the_stages_of_a_material_that_waits_outside_of_the_tick() {
    let scene = problem("slab-quick", OWN);
    let (graph, cycle) = export(&scene);
    let (program, traffic) = (program(&scene), Traffic::none(graph.recipe.materials.len()));
    let dot = Chart::new(&program, &cycle, &traffic, None, false).to_dot();
    assert_eq!(dot.matches('{').count(), dot.matches('}').count());
    // names of clusters in the order of the text, with how deep they lie
    let (mut depth, mut clusters) = (0, Vec::new());
    for line in dot.lines() {
        if line.contains("subgraph") {
            clusters.push((depth, line.trim()));
        }
        depth += line.matches('{').count();
        depth -= line.matches('}').count();
    }
    let at = |depth: usize, word: &str| {
        clusters.iter().filter(|(d, name)| *d == depth && name.contains(word)).count()
    };
    assert_eq!(
        (at(1, "loop until StepOver, at most 256 rounds"), at(2, "cluster_tick")),
        (1, 1),
        "{clusters:?}"
    );
    assert_eq!((at(2, "particles of tissue"), at(3, "particles of lead")), (2, 2), "{clusters:?}");
    assert_eq!((at(3, "\"once\""), at(3, "\"nodes\"")), (2, 1), "{clusters:?}");
    assert_eq!(clusters.len(), 9);
    for id in graph.graph.node_indices() {
        assert_eq!(dot.matches(&format!("    t{} [label", id.index())).count(), 1);
    }
}

#[test]
fn json_says_when_tasks_run_and_how_often() {
    for (overrides, mode, most) in [(&[][..], "common", 1), (OWN, "per-material", 256)] {
        let (graph, cycle) = export(&problem("slab-quick", overrides));
        let json: serde_json::Value =
            serde_json::from_str(&Shown { graph: &graph, cycle: &cycle }.to_json().to_string())
                .expect("valid JSON");
        for task in json["tasks"].as_array().expect("tasks") {
            let wanted = match (&task["material"], task["phase"].as_u64()) {
                (serde_json::Value::Null, _) => "tick",
                (_, Some(1)) => "begin",
                _ => "end",
            };
            assert_eq!(task["when"], wanted, "{task}");
        }
        let rates = &json["rates"];
        assert_eq!((&rates["mode"], &rates["most"]), (&mode.into(), &most.into()));
        let materials = rates["estimated_at_rest"].as_array().expect("materials");
        let ticks = materials.iter().map(|m| m["ticks"].as_u64());
        assert_eq!(ticks.collect::<Vec<_>>(), [if most == 1 { 1 } else { 37 }, 1].map(Some));
        let sizes: Vec<f64> = materials.iter().filter_map(|m| m["step_s"].as_f64()).collect();
        let tick = rates["tick_s"].as_f64().expect("a tick");
        assert!(sizes.len() == 2 && sizes[1] == tick, "{rates}");
    }
}

/// 0.4 h/(c + |v|) by hand: lead c = √((46 + 4/3·5.6) GPa/ρ), tissue c = √((100 + 4/3·4.2) kPa/ρ), the ball at 50 m/s;
/// tissue heeds the ball that touches it.
#[test]
fn estimates_are_those_of_the_speed_of_sound() {
    let (_, cycle) = export(&problem("slab-quick", OWN));
    let lead = 0.4e-3 / (((46e9f64 + 4.0 / 3.0 * 5.6e9) / 11_340.0).sqrt() + 50.0);
    let tissue = 0.4e-3 / (((100e3f64 + 4.0 / 3.0 * 4.2e3) / 1000.0).sqrt() + 50.0);
    assert!((1.0..1.03).contains(&(lead / cycle.tick)), "{lead} {cycle:?}");
    assert!((0.97..1.0 + 1e-9).contains(&(cycle.own[0].size / tissue)), "{tissue} {cycle:?}");
    assert_eq!(cycle.own[0].ticks, (tissue / lead).ceil() as u64);
    assert_eq!(cycle.fastest, 1);
}

#[test]
fn the_first_step_is_as_long_as_estimated() {
    for more in [&[][..], &[("run.most-substeps", "20")]] {
        let scene = problem("slab-quick", &[OWN, more].concat());
        let (_, cycle) = export(&scene);
        let mut simulation = start(scene);
        simulation.step().unwrap_or_else(|e| panic!("{e}"));
        for (material, own) in cycle.own.iter().enumerate() {
            let step: MaterialStep = simulation.warehouse.shared.get(labels::OwnStep::ID, material);
            assert_eq!(step.last - step.first, own.ticks as f64);
            assert!((step.size / own.size - 1.0).abs() < 0.01, "{step:?} {own:?}");
        }
    }
}

const THREE: &str = r#"
[domain]
lower = [0, 0, 0]
upper = [12, 8, 8]
cell = 1
[material.tool]
law = "rigid"
motion = "prescribed"
velocity = [30, 0, 0]
density = 1000
visible = true
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "3 kPa"
[material.hard]
law = "neo-hookean"
density = 1000
bulk-modulus = "90 MPa"
shear-modulus = "270 kPa"
[[body]]
name = "tool"
material = "tool"
shape = { box = { lower = [1, 2, 2], upper = [3, 6, 6] } }
[[body]]
name = "soft"
material = "soft"
shape = { box = { lower = [4, 2, 2], upper = [7, 6, 6] } }
[[body]]
name = "hard"
material = "hard"
shape = { box = { lower = [8, 2, 2], upper = [11, 6, 6] } }
[run]
until = 1
rates = "per-material"
"#;

/// The speeds of sound are 1 : √90, so that ten ticks make a step of the soft block. A rigid body takes every tick.
#[test]
fn rigid_bodies_take_every_tick_and_the_most_ticks_bind() {
    let ticks = |overrides| {
        let scene = scene(THREE, overrides);
        let cycle = rates::at_rest(&scene);
        (cycle.fastest, cycle.own.iter().map(|own| own.ticks).collect::<Vec<_>>())
    };
    assert_eq!(ticks(&[]), (2, vec![1, 10, 1]));
    assert_eq!(ticks(&[("run.most-substeps", "4")]), (2, vec![1, 4, 1]));
    assert_eq!(ticks(&[("run.rates", "common")]), (2, vec![1, 1, 1]));
}
