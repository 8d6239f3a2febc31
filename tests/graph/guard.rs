//! What a step may cost, in counts that no machine changes: allocations, passes over particles, visits of nodes,
//! operations, bytes. A change that costs more has to say so here.

use crate::common::{Overrides, problem};
use engine::exec::meter::{StagePart, Tally, What};
use engine::graph::phase::When;
use engine::graph::task::Domain;
use simd::{Isa, LANES};
use sinew::lab::bench::{Plan, bench};
use sinew::simulation::Simulation;

/// The quick slab a little before the ball meets it, in one thread and two patches.
fn shot(overrides: Overrides<'_>) -> Simulation {
    let base =
        [("run.threads", "1"), ("run.patches", "[2, 1, 1]"), ("body.bullet.shape.sphere.center.1", "4.7 mm")];
    let scene = problem("slab-quick", &[&base, overrides].concat());
    Simulation::new(scene, Isa::detect()).unwrap_or_else(|e| panic!("{e}"))
}

fn steps(simulation: &mut Simulation, count: usize) {
    for _ in 0..count {
        assert!(simulation.step().unwrap_or_else(|e| panic!("{e}")), "the run is over");
    }
}

#[test]
fn steps_allocate_nothing_but_room_for_particles_that_change_their_block() {
    // in free flight: with rates of its own the slab takes steps in which a row of the ball enters new blocks now and then
    let flight = ("body.bullet.shape.sphere.center.1", "5.9 mm");
    for (rates, warm, count) in [("common", 12, 40), ("per-material", 4, 6)] {
        let mut simulation = shot(&[("run.rates", rates), flight]);
        steps(&mut simulation, warm);
        let mut still = 0;
        for _ in 0..count {
            let counts =
                |s: &Simulation| -> Vec<usize> { s.warehouse.blocks().map(|(_, b)| b.count).collect() };
            let before = counts(&simulation);
            let info = allocation_counter::measure(|| steps(&mut simulation, 1));
            if counts(&simulation) == before {
                still += 1;
                assert_eq!(info.count_total, 0, "{rates}, step {}", simulation.steps());
            }
        }
        println!("{rates}: {still} of {count} steps in which nobody changed the block");
        assert!(still > 0);
    }
}

/// What one step takes.
fn metered(simulation: &mut Simulation) -> Tally {
    simulation.set_meter(true);
    steps(simulation, 1);
    simulation.take_meter()
}

#[test]
fn a_step_passes_twice_over_particles_and_once_over_nodes() {
    let mut simulation = shot(&[]);
    steps(&mut simulation, 5);
    let chunks = |s: &Simulation, material| -> u64 {
        let blocks = s.warehouse.blocks().filter(|(m, _)| *m == material);
        blocks.map(|(_, b)| b.tiles().div_ceil(4) as u64).sum()
    };
    let blocks = [0, 1].map(|m| simulation.warehouse.blocks().filter(|(of, _)| *of == m).count() as u64);
    let (expected, nodes) =
        ([0, 1].map(|m| chunks(&simulation, m)), simulation.warehouse.node_count() as u64 / 64);
    let tally = metered(&mut simulation);
    let graph = simulation.graph();
    for material in 0..2 {
        let stages = graph.phases.iter().flat_map(|p| &p.stages).filter(|s| s.material == Some(material));
        let sweeps: Vec<_> = stages.collect();
        assert_eq!(sweeps.iter().map(|s| s.when).collect::<Vec<_>>(), [When::Begin, When::End]);
        for &entry in sweeps.iter().flat_map(|s| &s.entries) {
            let declaration = graph.recipe.entries[entry].task.declaration();
            let (name, laps) = (declaration.name, tally.cost(What::Entry(entry)).laps);
            let wanted =
                if declaration.domain == Domain::Buffers { blocks[material] } else { expected[material] };
            assert_eq!(laps, wanted, "{name} of material {material}");
        }
    }
    // nodes that no particle touches are passed over
    let stages = graph.phases.iter().flat_map(|p| &p.stages).filter(|s| s.domain == Domain::Nodes);
    let visits = stages.flat_map(|s| &s.entries).map(|entry| tally.cost(What::Entry(*entry)).laps);
    let visits: Vec<u64> = visits.collect();
    println!("{} of {nodes} node blocks visited", visits[0]);
    assert!(visits.iter().all(|v| *v == visits[0]) && visits[0] <= nodes && 4 * visits[0] > nodes);
}

#[test]
fn with_rates_of_their_own_few_particles_move_and_few_nodes_are_visited_in_a_tick() {
    // a slab that is wide for its ball
    let mut simulation = shot(&[
        ("run.rates", "per-material"),
        ("body.bullet.shape.sphere.radius", "1.5 mm"),
        ("body.bullet.shape.sphere.center.1", "1.6 mm"),
    ]);
    steps(&mut simulation, 3);
    let (ticks, updates) = (simulation.ticks(), simulation.updates());
    let tally = metered(&mut simulation);
    let (ticks, updates) = (simulation.ticks() - ticks, simulation.updates() - updates);
    let nodes = simulation.graph().phases.iter().flat_map(|p| &p.stages).find(|s| s.domain == Domain::Nodes);
    let first = nodes.expect("a stage over nodes").entries[0];
    let visits = tally.cost(What::Part(first, StagePart::SumPartials)).laps;
    let blocks = simulation.warehouse.node_count() as u64 / 64;
    let particles = simulation.warehouse.particle_count() as u64;
    println!(
        "{ticks} ticks: {visits} visits of {blocks} node blocks, {updates} updates of {particles} particles"
    );
    assert!(ticks > 10);
    assert!(updates < ticks * particles / 8, "most particles move once a step");
    assert!(visits < ticks * blocks / 2, "most nodes are visited once a step");
}

#[test]
fn operations_and_bytes_an_update_stay_where_they_are() {
    let mut simulation = shot(&[]);
    steps(&mut simulation, 5);
    let plan = Plan { steps: 1, repeat: 1, threads: 1 };
    let report = bench(&mut simulation, &plan, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"));
    let row = |sweep: &str, row: &str| {
        let sweep = report.sweeps.iter().find(|s| s.name == sweep).expect("the sweep");
        sweep.rows.iter().find(|r| r.name == row).unwrap_or_else(|| panic!("{row}")).clone()
    };
    for (sweep, name, flop, bytes) in [
        ("P2G tissue", "Weights", 58.0, 25.0),
        ("P2G tissue", "Scatter", 830.0, 0.0),
        ("P2G tissue", "ContactScatter", 830.0, 0.0),
        ("G2P tissue", "Gather", 660.0, 0.0),
        ("G2P tissue", "Stress", 435.0, 360.0),
        ("G2P tissue", "Advance", 41.0, 82.0),
        ("G2P lead", "Stress", 445.0, 420.0),
    ] {
        let row = row(sweep, name);
        println!("{sweep} {name}: {:.1} operations, {:.1} bytes", row.flop, row.bytes);
        assert!(row.flop > 0.0 && row.flop <= flop, "{name}: {} operations", row.flop);
        assert!(row.bytes <= bytes, "{name}: {} bytes", row.bytes);
    }
    assert!(report.state.lanes > 0.95, "{LANES} lanes are nearly full: {}", report.state.lanes);
}
