//! A label to which not all materials add again, and what a task that runs once does to reduced labels.
use crate::run::{Layout, state, together, warehouse};
use crate::state::{Particle, Start};
use crate::toy::*;
use engine::exec::ranks::Network;
use engine::exec::{Engine, Serial, Undirected};
use engine::prelude::*;
use engine::simd::Isa;

kernel! { /// Adds 1 to the lowest node.
    AddOne() in add_one: Particles { requires now { position: Position } computes { sum: StageSum @ 3 } }
    |_it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let line = (io.position[tile][0].0[lane].floor() - at.origin.node[0]) as i32 * at.origin.shape.buffer_strides[0];
        io.sum[line as usize].0[0] += 1.0;
    }
}
kernel! { /// Keeps the sum of a graph in a place of its own.
    Keep(usize) in keep: Nodes { requires new { sum: StageSum } modifies { kept: KeptOwn } }
    |it, _at, io| for (sum, kept) in io.sum.iter().zip(io.kept.iter_mut()) {
        kept[0].0[it.0] = sum.0[0];
    }
}
kernel! { /// The largest charge.
    Largest() in largest: Particles { requires old { charge: Charge } computes { most: RunMost } }
    |_it, at, io| for p in 0..at.count {
        io.most[0].0[0] = io.most[0].0[0].max(io.charge[p / 8].0[p % 8]);
    }
}
kernel! { /// The largest is what all agree on, and one more.
    Raise() in raise: Once { modifies { most: RunMost } }
    |_it, _at, io| io.most[0].0[0] += 1.0
}

/// Two particles of two materials, at one node beside the other patch.
pub fn start() -> Start {
    let particle =
        |material| Particle { material, x: [4.0; 3], velocity: [0.0; 3], charge: 0.25, whole: 1.0 };
    Start {
        cells: [8, 0, 0],
        fields: vec![1, 1],
        memory: vec![0, 0],
        interacts: vec![vec![false; 2]; 2],
        particles: [0, 1].map(particle).into(),
    }
}

pub fn program() -> Program {
    let recipe = || Recipe::new(&SCHEMA, vec!["a".to_owned(), "b".to_owned()]);
    let (mut both, mut one) = (recipe(), recipe());
    both.add(0, "", add_one::AddOne());
    both.add(1, "", add_one::AddOne());
    both.all("", keep::Keep(0));
    one.add(0, "", add_one::AddOne());
    one.all("", keep::Keep(1));
    (0..2).for_each(|m| one.add(m, "", largest::Largest()));
    one.all("", raise::Raise());
    let script = vec![Script::Graph("both", both), Script::Graph("one", one)];
    Program::build("again", script, &[KeptOwn::ID, RunMost::ID], 2).expect("a program")
}

#[test]
fn who_does_not_add_again_has_nothing_there_and_ranks_agree_on_what_is_done_once() {
    for of in [vec![0, 0], vec![0, 1], vec![1, 0]] {
        let ranks = of.iter().max().map_or(1, |rank| 1 + *rank as usize);
        let layout = Layout { patches: [2, 1, 1], ranks, of: [of.clone(), of], moves: 0, threads: 1 };
        let found = together(&layout, |mut network| {
            let program = program();
            let mut warehouse = warehouse(&start(), &layout, &program, network.rank());
            let mut engine = Engine::new(Box::new(Serial), Isa::detect(), &warehouse);
            for _ in 0..2 {
                engine.execute(&program, &mut warehouse, &mut network, &mut Undirected).expect("a step");
            }
            state(&warehouse)
        });
        let kept = |field| &found.nodes[&("KeptOwn".to_owned(), field, [4, 0, 0])][0][..2];
        assert_eq!(kept(0), [1.0_f64, 1.0].map(f64::to_bits), "{layout:?}");
        assert_eq!(kept(1), [1.0_f64, 0.0].map(f64::to_bits), "{layout:?}");
        assert_eq!(f64::from_bits(found.shared["RunMost"][0][0]), 1.25, "{layout:?}");
    }
}
