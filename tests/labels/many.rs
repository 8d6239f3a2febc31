//! More labels of nodes than the header of a message has bits; and sums to which several stages add.
use engine::exec::ranks::local::Local;
use engine::exec::ranks::{Alone, Network};
use engine::exec::{Engine, Serial, Undirected};
use engine::prelude::{Life::*, *};
use engine::simd::Isa;

/// A toy with some labels of nodes, to all of which particles add.
macro_rules! many {
    ($($name:ident $label:ident)*) => {
        engine::labels! {
            Position: [Wide; 3] = particle("cells", "x_p").in_the_middle();
            Identity: Wide      = particle("1", "identity of p, as the bits of an integer");
            Seen: Wide          = particle("1", "what p has read");
            Extent: [Wide; 6]   = block("cells", "where the particles of a block are").largest();
            Count: ExactSum     = run("1", "particles").exact();
            Sum: Wide           = node("1", "what particles read").values(3);
            Twice: Wide         = node("1", "a sum to which two stages add").partials(3).lives(Tick);
            $($label: Wide      = node("1", "one of many").partials(3);)*
        }
        kernel! { /// The n-th label gets n + 1 at the lowest node.
            Give() in give: Particles {
                requires old { position: Position } computes { count: Count, twice: Twice @ 3, $($name: $label @ 3),* }
            }
            |_it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
                let line = lowest(&io.position[tile], lane, at);
                let mut n = 0.0;
                $(n += 1.0; io.$name[line].0[3] += n;)*
                io.twice[line].0[0] += n;
                io.count[0].add(1.0);
            }
        }
        kernel! { /// Adds to what another stage has begun: it needs the particles of all blocks.
            GiveAgain() in give_again: Particles {
                requires old { position: Position } requires new { count: Count } computes { twice: Twice @ 3 }
            }
            |_it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
                io.twice[lowest(&io.position[tile], lane, at)].0[0] += 1e4 * io.count[0].value();
            }
        }
        kernel! { /// The sum of all labels, each with a weight of its own.
            Gather() in gather: Nodes { requires new { twice: Twice, $($name: $label),* } computes { sum: Sum } }
            |_it, _at, io| for (n, sum) in io.sum.iter_mut().enumerate() {
                let mut weight = 1.0;
                sum.0[0] = io.twice[n].0[0];
                $(weight += 1.0; sum.0[0] += weight * io.$name[n].0[3];)*
            }
        }
    };
}
many! {
    a0 A0 a1 A1 a2 A2 a3 A3 a4 A4 a5 A5 a6 A6 a7 A7 a8 A8 a9 A9 b0 B0 b1 B1 b2 B2 b3 B3
    b4 B4 b5 B5 b6 B6 b7 B7 b8 B8 b9 B9 c0 C0 c1 C1 c2 C2 c3 C3 c4 C4 c5 C5 c6 C6 c7 C7
    c8 C8 c9 C9 d0 D0 d1 D1 d2 D2 d3 D3 d4 D4 d5 D5 d6 D6 d7 D7 d8 D8 d9 D9 e0 E0 e1 E1
    e2 E2 e3 E3 e4 E4 e5 E5 e6 E6 e7 E7 e8 E8 e9 E9 f0 F0 f1 F1 f2 F2 f3 F3 f4 F4 f5 F5
    f6 F6 f7 F7 f8 F8 f9 F9 g0 G0 g1 G1 g2 G2 g3 G3 g4 G4 g5 G5 g6 G6 g7 G7 g8 G8 g9 G9
}
kernel! { /// All that the lowest nodes and those above them have.
    Take() in take: Particles {
        requires old { position: Position } requires new { sum: Sum @ 3 } modifies { seen: Seen }
    }
    |_it, at, io| for (tile, lane) in (0..at.count).map(|p| (p / 8, p % 8)) {
        let line = lowest(&io.position[tile], lane, at);
        let above = line + at.origin.shape.buffer_strides[0] as usize;
        io.seen[tile].0[lane] = io.sum[line].0[0] + 1e-3 * io.sum[above].0[0];
    }
}
const ROLES: Roles =
    Roles { position: Position::ID, identity: Identity::ID, extent: Extent::ID, rates: None };
static SCHEMA: Schema = Schema::new(&ROWS, ROLES);

/// The line of the lowest node of a particle in its block's buffer, on a level with one axis.
fn lowest(x: &[Wide; 3], lane: usize, at: &At<'_>) -> usize {
    (x[0].0[lane].floor() - at.origin.node[0]) as usize * at.origin.shape.buffer_strides[0] as usize
}

/// Labels of the table.
const LABELS: usize = 70;

fn seen(network: &mut dyn Network, x: &[f64]) -> Vec<(u64, f64)> {
    let mut recipe = Recipe::new(&SCHEMA, vec!["matter".to_owned()]);
    recipe.add(0, "", give::Give());
    recipe.add(0, "", give_again::GiveAgain());
    recipe.all("", gather::Gather());
    recipe.add(0, "", take::Take());
    let program =
        Program::build("many", vec![Script::Graph("all", recipe)], &[Seen::ID], 2).expect("a program");
    let level = Level { lower: [0.0; 3], cell: 1.0, cells: [8, 0, 0] };
    let cut = Decomposition::new(&level, [2, 1, 1]).expect("patches");
    let partition = Partition::by_cost(&cut, &[1, 1], network.rank(), network.size()).expect("ranks");
    let matter = MaterialData::new(&SCHEMA, "matter", [Position::ID, Identity::ID, Seen::ID]);
    let mut warehouse = Warehouse::new(&SCHEMA, level, (cut, partition), vec![matter], program.labels());
    for (identity, &x) in (0..).zip(x) {
        let at = [x, 0.0, 0.0];
        if warehouse.partition.is_mine(warehouse.home(0, at).expect("in the level").1) {
            warehouse.insert(0, at, &[x, 0.0, 0.0, f64::from_bits(identity), 0.0]).expect("in the level");
        }
    }
    let mut engine = Engine::new(Box::new(Serial), Isa::detect(), &warehouse);
    // twice: buffers are used again
    for _ in 0..2 {
        engine.execute(&program, &mut warehouse, network, &mut Undirected).expect("a step");
    }
    let layout = &warehouse.materials[0].layout;
    let get = |(_, block): (usize, &engine::data::particles::ParticleBlock)| {
        let one = |p| (block.get(layout, Identity::ID, p, 0).to_bits(), block.get(layout, Seen::ID, p, 0));
        (0..block.count).map(one).collect::<Vec<_>>()
    };
    warehouse.blocks().flat_map(get).collect()
}

#[test]
fn more_labels_than_a_header_has_bits_come_to_other_ranks_and_stages_add_to_one_sum() {
    let x = [3.5_f64, 3.25, 4.5, 2.0, 7.75, 0.5, 5.0];
    let labels = LABELS as f64;
    let each = (1..=LABELS).map(|n| (n * (n + 1)) as f64).sum::<f64>() + labels + 1e4 * x.len() as f64;
    let at = |node: f64| each * x.iter().filter(|x| x.floor() == node).count() as f64;
    let plain: Vec<(u64, f64)> = (0..).zip(x.map(|x| at(x.floor()) + 1e-3 * at(x.floor() + 1.0))).collect();
    let sorted = |mut list: Vec<(u64, f64)>| {
        list.sort_by_key(|(identity, _)| *identity);
        list
    };
    assert_eq!(sorted(seen(&mut Alone, &x)), plain);
    let ranks: Vec<_> = std::thread::scope(|scope| {
        let rank = |mut rank: Local| scope.spawn(move || seen(&mut rank, &x));
        let ranks: Vec<_> = Local::crew(2).into_iter().map(rank).collect();
        ranks.into_iter().flat_map(|rank| rank.join().expect("a rank")).collect()
    });
    assert_eq!(sorted(ranks), plain);
}
