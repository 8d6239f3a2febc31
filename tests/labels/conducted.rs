//! What runs of programs refuse: particles that nobody sees move or leave, materials without what tasks use.
use crate::toy::*;
use engine::data::extent::Bases;
use engine::exec::ranks::Alone;
use engine::exec::{Engine, Serial, Stopped, Undirected};
use engine::prelude::*;
use engine::schema::LabelId;
use engine::simd::Isa;

kernel! { /// Particles move, and their block does not hear of it.
    Slip() in slip: Particles { modifies { position: Position } }
    |_it, _at, io| io.position.iter_mut().for_each(|x| x[0].0[0] += 0.5)
}
kernel! { /// Particles move.
    Drift() in drift: Particles { requires now { charge: Charge } computes { extent: Extent } modifies { position: Position } }
    |_it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        io.position[tile][0].0[lane] += 0.5 * io.charge[tile].0[lane];
        let x = [0, 1, 2].map(|a| io.position[tile][a].0[lane]);
        Bases { inverse_cell: 1.0, half_size: [0.0; 3] }.include_one(&mut io.extent[0], &at.origin, lane, x);
    }
}

fn program(add: impl FnOnce(&mut Recipe)) -> Result<Program, engine::graph::error::GraphError> {
    let mut recipe = Recipe::new(&SCHEMA, vec!["matter".to_owned()]);
    add(&mut recipe);
    Program::build("step", vec![Script::Graph("move", recipe)], &[Position::ID], 1)
}

/// One particle in the middle of eight cells, with some labels.
fn particle(labels: &[LabelId], record: &[f64]) -> Warehouse {
    let level = Level { lower: [0.0; 3], cell: 1.0, cells: [8, 8, 8] };
    let cut = Decomposition::new(&level, [1; 3]).expect("a patch");
    let matter = vec![MaterialData::new(&SCHEMA, "matter", labels.iter().copied())];
    let mut warehouse = Warehouse::new(&SCHEMA, level, (cut, Partition::alone(1)), matter, []);
    warehouse.insert(0, [4.0; 3], record).expect("in the level");
    warehouse
}

fn steps(warehouse: &mut Warehouse, count: usize) -> Result<(), Stopped> {
    let program = program(|recipe| recipe.add(0, "", drift::Drift())).expect("a program");
    let mut engine = Engine::new(Box::new(Serial), Isa::detect(), warehouse);
    (0..count).try_for_each(|_| engine.execute(&program, warehouse, &mut Alone, &mut Undirected))
}

#[test]
fn who_moves_particles_says_how_far_they_reach() {
    let error = program(|recipe| recipe.add(0, "", slip::Slip())).err().expect("unseen").to_string();
    for words in ["Slip[matter] changes Position", "does not compute Extent", "Bases"] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn particles_that_leave_stop_a_program_that_nobody_conducts() {
    let mut warehouse =
        particle(&[Position::ID, Identity::ID, Charge::ID], &[4.0, 4.0, 4.0, f64::from_bits(7), 2.0]);
    assert_eq!(steps(&mut warehouse, 4), Ok(()));
    let error = steps(&mut warehouse, 1).expect_err("it is outside");
    assert!(
        matches!(error, Stopped::Left { count: 1, identity: 7, position: [9.0, 4.0, 4.0], .. }),
        "{error}"
    );
    for words in ["1 particle", "the first, 7, of matter", "Conductor"] {
        assert!(error.to_string().contains(words), "{error}");
    }
}

#[test]
#[should_panic(expected = "material matter has no Charge, which a task of graph \"move\" uses")]
fn a_material_that_lacks_a_label_is_named() {
    let _ = steps(&mut particle(&[Position::ID, Identity::ID], &[4.0, 4.0, 4.0, 0.0]), 1);
}
