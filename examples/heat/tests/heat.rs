//! Heat on the engine: against closed forms, and the same bits on any patches, threads and ranks.
use engine::exec::ranks::local::Local;
use engine::exec::ranks::{Alone, Network, collective};
use engine::exec::{Backend, Engine, Serial, Threads, Undirected};
use engine::grid::{Level, Partition};
use engine::program::{ProgramNode, hazards};
use engine::schema::Label;
use engine::simd::Isa;
use heat::{Heat, Identity, Position, Temperature};
use std::f64::consts::PI;

/// 100 mm of steel, in two dimensions and in three.
const PLATE: Level = Level { lower: [0.0; 3], cell: 2.5e-3, cells: [40, 8, 0] };
const BAR: Level = Level { lower: [0.0; 3], cell: 2.5e-3, cells: [40, 3, 2] };
const STEEL: Heat = Heat { capacity: 3.9e6, conductivity: 45.0, step: 0.05, tolerance: None };

/// Half a cosine along x: it decays at k/ρc (π/L)².
fn cosine(x: [f64; 3]) -> f64 {
    (PI * x[0] / 0.1).cos()
}

/// (identity, x, T) of all particles of a rank after some steps.
fn run(
    heat: Heat,
    (level, patches): (Level, [usize; 3]),
    steps: usize,
    network: &mut dyn Network,
    backend: impl Backend + 'static,
) -> Vec<(u64, [f64; 3], f64)> {
    let count = patches.iter().product();
    let program = heat.program(&level, count).expect("a program");
    assert_eq!(hazards(&program), []);
    let place = (patches, network.rank(), network.size());
    let mut warehouse =
        Heat::start(&program, (level, 2), place, |x| 300.0 + 100.0 * cosine(x)).expect("particles");
    let mut engine = Engine::new(Box::new(backend), Isa::detect(), &warehouse);
    for step in 0..steps {
        if step == steps / 2 && network.size() > 1 {
            // patches change their rank in the middle of it
            let of = (0..count).map(|patch| ((patch + 1) % network.size()) as u32).collect();
            let partition = Partition::new(of, network.rank(), network.size());
            engine.migrate(partition, &mut warehouse, network).expect("a move");
        }
        engine.execute(&program, &mut warehouse, network, &mut Undirected).expect("a step");
    }
    let mut all = Vec::new();
    for (material, block) in warehouse.blocks() {
        let get = |label, p, c| block.get(&warehouse.materials[material].layout, label, p, c);
        all.extend((0..block.count).map(|p| {
            let x = [0, 1, 2].map(|a| get(Position::ID, p, a));
            (get(Identity::ID, p, 0).to_bits(), x, get(Temperature::ID, p, 0))
        }));
    }
    all
}

/// One number for all temperatures, the same on all ranks.
fn hash(particles: &[(u64, [f64; 3], f64)], network: &mut dyn Network) -> u64 {
    let mix = |(i, _, t): &(u64, [f64; 3], f64)| {
        (t.to_bits() ^ i).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(29)
    };
    let mut sum = [particles.iter().map(mix).fold(0, u64::wrapping_add)];
    collective::sum(network, &mut sum).expect("all are here");
    sum[0]
}

/// The largest difference from the closed form after a time [K].
fn error(particles: &[(u64, [f64; 3], f64)], heat: Heat, time: f64) -> f64 {
    let decay = (-heat.conductivity / heat.capacity * (PI / 0.1).powi(2) * time).exp();
    let exact = |x| 300.0 + 100.0 * decay * cosine(x);
    particles.iter().map(|(_, x, t)| (t - exact(*x)).abs()).fold(0.0, f64::max)
}

#[test]
fn half_a_cosine_decays_as_it_should_explicit_and_implicit_in_two_and_three_dimensions() {
    for level in [PLATE, BAR] {
        let explicit = run(STEEL, (level, [2, 1, 1]), 400, &mut Alone, Serial);
        let implicit = Heat { step: 1.0, tolerance: Some(1e-10), ..STEEL };
        let implicit_after = run(implicit, (level, [2, 1, 1]), 20, &mut Alone, Serial);
        // of 80 K that are left of 100
        let (a, b) = (error(&explicit, STEEL, 20.0), error(&implicit_after, implicit, 20.0));
        println!("{:?}: explicit {a:.3} K, implicit {b:.3} K", level.cells);
        assert!(a < 0.15, "explicit steps are off by {a} K");
        assert!(b < 0.25, "implicit steps are off by {b} K");
    }
}

/// Backward Euler decays each mode by 1/(1 + rate Δt) a step, so that its error is of first order in Δt.
#[test]
fn implicit_steps_converge_with_first_order() {
    let of = |step: f64| {
        let heat = Heat { step, tolerance: Some(1e-12), ..STEEL };
        let after = run(heat, (PLATE, [1, 1, 1]), (20.0 / step) as usize, &mut Alone, Serial);
        let (_, x, t) = after[0];
        (t - 300.0) / (100.0 * cosine(x))
    };
    let [a, b, c] = [4.0, 2.0, 1.0].map(of);
    let order = ((a - b) / (b - c)).log2();
    assert!((order - 1.0).abs() < 0.1, "order {order}");
}

#[test]
fn nothing_is_lost_and_a_uniform_temperature_stays() {
    let heat = Heat { step: 1.0, tolerance: Some(1e-10), ..STEEL };
    let particles = run(heat, (PLATE, [3, 2, 1]), 10, &mut Alone, Serial);
    let mean = particles.iter().map(|(_, _, t)| t).sum::<f64>() / particles.len() as f64;
    assert!((mean - 300.0).abs() < 1e-9, "the mean is {mean}");
}

#[test]
fn one_hash_on_any_patches_threads_and_ranks() {
    for tolerance in [None, Some(1e-8)] {
        for level in [PLATE, BAR] {
            let heat = Heat { step: if tolerance.is_some() { 2.0 } else { 0.05 }, tolerance, ..STEEL };
            let alone = run(heat, (level, [1, 1, 1]), 6, &mut Alone, Serial);
            let expected = hash(&alone, &mut Alone);
            let threads = run(heat, (level, [5, 1, 1]), 6, &mut Alone, Threads::new(2).expect("threads"));
            assert_eq!(hash(&threads, &mut Alone), expected, "two threads");
            for (ranks, patches) in [(1, [3, 1, 1]), (2, [4, 1, 1]), (3, [5, 1, 1]), (4, [4, 1, 1])] {
                let hashes: Vec<u64> = std::thread::scope(|scope| {
                    let work = |mut rank: Local| {
                        let particles = run(heat, (level, patches), 6, &mut rank, Serial);
                        hash(&particles, &mut rank)
                    };
                    let ranks: Vec<_> =
                        Local::crew(ranks).into_iter().map(|rank| scope.spawn(move || work(rank))).collect();
                    ranks.into_iter().map(|rank| rank.join().expect("a rank")).collect()
                });
                assert!(
                    hashes.iter().all(|hash| *hash == expected),
                    "{ranks} ranks: {hashes:x?} not {expected:x}"
                );
            }
        }
    }
}

#[test]
fn the_program_of_an_implicit_step_is_a_loop_between_two_graphs() {
    let heat = Heat { tolerance: Some(1e-8), ..STEEL };
    let program = heat.program(&PLATE, 1).expect("a program");
    assert!(matches!(
        &program.nodes[..],
        [ProgramNode::Graph(_), ProgramNode::Loop(_), ProgramNode::Graph(_)]
    ));
    let text = program.to_string();
    for line in [
        "program implicit step",
        "  graph residual",
        "  loop until Solved, at most 1000 rounds",
        "    graph round",
    ] {
        assert!(text.lines().any(|it| it.starts_with(line)), "{text}");
    }
}
