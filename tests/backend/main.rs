//! A backend that keeps labels in memory of its own: stages get what they declare and nothing else, and that is enough.
#![allow(clippy::unwrap_used, missing_docs)]
mod apart;
#[path = "../common/mod.rs"]
mod common;

use apart::Apart;
use common::problem;
use engine::exec::ranks::local::Local;
use engine::exec::ranks::{Alone, Network};
use engine::exec::{Backend, Serial};
use engine::schema::Label;
use simd::Isa;
use sinew::simulation::Simulation;
use tasks::labels;

/// The state after some steps of the quick shot.
fn hash(network: Box<dyn Network>, (rates, steps): (&str, usize), backend: Box<dyn Backend>) -> u64 {
    let overrides = &[("run.rates", rates), ("run.patches", "[2, 2, 1]"), ("run.threads", "1")];
    let mut simulation = Simulation::on(network, problem("slab-quick", overrides), Isa::detect()).unwrap();
    simulation.set_backend(backend);
    for _ in 0..steps {
        simulation.step().unwrap();
    }
    simulation.state_hash()
}

#[test]
fn the_shot_keeps_its_bits_where_labels_are_elsewhere() {
    for run in [("common", 12), ("per-material", 4)] {
        let expected = hash(Box::new(Alone), run, Box::new(Serial));
        assert_eq!(hash(Box::new(Alone), run, Box::new(Apart::default())), expected, "{run:?}");
        let ranks = Local::crew(2).into_iter().map(|rank| {
            let work = move || hash(Box::new(rank), run, Box::new(Apart::default()));
            std::thread::spawn(work)
        });
        let ranks: Vec<_> = ranks.collect();
        for rank in ranks {
            assert_eq!(rank.join().unwrap(), expected, "{run:?}, two ranks");
        }
    }
}

/// The test above can fail: a label that a stage asks for and does not get is missed.
#[test]
fn what_a_stage_asks_for_is_missed_if_it_does_not_come() {
    let step = |backend: Apart| {
        let scene = problem("slab-quick", &[("run.threads", "1")]);
        let mut simulation = Simulation::new(scene, Isa::detect()).unwrap();
        simulation.set_backend(Box::new(backend));
        simulation.step().map(|_| simulation.state_hash()).ok()
    };
    let expected = step(Apart::default());
    assert!(expected.is_some());
    for label in [labels::Velocity::ID, labels::NodeSums::ID, labels::NodeMotion::ID, labels::Mass::ID] {
        assert_ne!(step(Apart::without(label)), expected, "{}", label.name());
    }
}
