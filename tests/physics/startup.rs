//! What a rank does at the start of a run: its own part of the scene, and a share of what is counted of all.

use crate::common::scene;
use engine::data::layout::ParticleLayout;
use engine::data::warehouse::Warehouse;
use engine::exec::ranks::Network;
use engine::exec::ranks::local::Local;
use engine::schema::Label;
use grid::{Decomposition, Partition};
use scene::{Scene, sampling};
use sinew::simulation::start::{Roll, census};
use sinew::simulation::{layout, populate};
use std::collections::BTreeMap;
use tasks::labels::{Identity, Position, SCHEMA};
use tasks::recipes;

/// A hundred million particles: a box and a ball.
const HUNDRED_MILLION: &str = r#"
[domain]
lower = [0, 0, 0]
upper = [2.5, 1, 1]
cell = "4 mm"
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "2 MPa"
shear-modulus = "1 MPa"
[[body]]
name = "box"
material = "soft"
shape = { box = { lower = [0.04, 0.04, 0.04], upper = [0.6, 0.96, 0.96] } }
[[body]]
name = "ball"
material = "soft"
shape = { sphere = { center = [1.75, 0.5, 0.5], radius = 0.449 } }
velocity = [-10, 0, 0]
[run]
until = 1
[output]
frames = 0
"#;

/// What a rank finds at the start: its particles, with identities and places alone, and what it has looked at.
struct Found {
    warehouse: Warehouse,
    visited: u64,
    particles: u64,
    largest_share: u64,
}

/// The start of a run on `ranks` ranks, of which `rank` fills its patches, and the others do what all do together.
fn begin(scene: &Scene, ranks: usize, rank: usize) -> Found {
    let one = |mut network: Local| {
        let roll = Roll::call(scene, &mut network).expect("all ranks are there");
        let census = census(scene, &roll, &mut network).expect("all ranks are there");
        // who only looks on has no patch
        let here = network.rank() == rank;
        let (cut, loads) = match here {
            true => layout::cut(scene, 8 * ranks, ranks, &census).expect("patches"),
            false => (Decomposition::new(&layout::level(scene), [1; 3]).expect("a patch"), vec![0]),
        };
        let partition = match here {
            true => Partition::by_cost(&cut, &loads, rank, ranks).expect("patches enough"),
            false => Partition::new(vec![0], 1, 2),
        };
        let mut shares = vec![0; ranks];
        (0..loads.len()).for_each(|patch| shares[partition.rank_of(patch)] += loads[patch]);
        let (particles, largest_share) = (shares[rank], shares.into_iter().max().unwrap_or(0));
        let layout = |_| ParticleLayout::new(&SCHEMA, [Identity::ID, Position::ID], BTreeMap::new());
        let mut warehouse = populate::empty(scene, cut, partition, layout, [], &recipes::tiles(scene));
        populate::populate(scene, &roll, &mut warehouse, &mut network, 2).expect("particles");
        here.then(|| Found { warehouse, visited: roll.visited(), particles, largest_share })
    };
    std::thread::scope(|scope| {
        let ranks: Vec<_> = Local::crew(ranks).into_iter().map(|rank| scope.spawn(|| one(rank))).collect();
        let mut all = ranks.into_iter().filter_map(|rank| rank.join().expect("a rank ends"));
        all.next().expect("the rank")
    })
}

/// The identity of a particle of the box from its place alone: cell by cell, z fastest, and so within a cell.
fn identity_in_the_box(x: [f64; 3]) -> u64 {
    let [from, to] = [[10, 10, 10], [150, 240, 240u64]];
    let place = x.map(|x| x / 4e-3);
    let cell: [u64; 3] = [0, 1, 2].map(|a| place[a].floor() as u64 - from[a]);
    let size: [u64; 3] = [0, 1, 2].map(|a| to[a] - from[a]);
    let within = [0, 1, 2].map(|a| u64::from(place[a].fract() > 0.5));
    8 * ((cell[0] * size[1] + cell[1]) * size[2] + cell[2]) + 4 * within[0] + 2 * within[1] + within[2]
}

#[test]
fn one_of_a_hundred_ranks_visits_a_hundredth_of_a_hundred_million_particles() {
    let scene = scene(HUNDRED_MILLION, &[]);
    let all: u64 = scene.bodies.iter().map(|body| sampling::count(&scene, body) as u64).sum();
    assert!(all > 100_000_000, "{all}");
    let boxed = sampling::count(&scene, &scene.bodies[0]) as u64;
    assert_eq!(boxed, 8 * 140 * 230 * 230);
    for rank in [3, 88] {
        let Found { warehouse, visited, particles, largest_share } = begin(&scene, 100, rank);
        println!("rank {rank} of 100 has {particles} of {all} particles and visits {visited}");
        assert_eq!(warehouse.particle_count() as u64, particles);
        assert!(largest_share < all / 80, "{largest_share}");
        // its own, and what is cut by the surface or counted for all
        assert!(visited < particles + particles / 2 && visited < all / 60, "{visited}");
        let layout = &warehouse.materials[0].layout;
        for (_, block) in warehouse.blocks() {
            let mut last = None;
            for p in 0..block.count {
                let identity = block.get(layout, Identity::ID, p, 0).to_bits();
                assert!(last < Some(identity) && identity < all);
                last = Some(identity);
                if identity < boxed {
                    let x = [0, 1, 2].map(|a| block.get(layout, Position::ID, p, a));
                    assert_eq!(identity_in_the_box(x), identity, "{x:?}");
                }
            }
        }
    }
}

/// The identities of all ranks together are those of one, each at its place.
#[test]
fn particles_have_the_identities_of_the_plain_order_on_any_ranks() {
    let coarse = [("domain.cell", "50 mm"), ("body.0.angular-velocity", "[1, 2, 3]")];
    let scene = scene(HUNDRED_MILLION, &coarse);
    let plain: Vec<[f64; 3]> = scene.bodies.iter().flat_map(|body| sampling::sample(&scene, body)).collect();
    for ranks in [1, 2, 4, 7] {
        let (mut seen, mut visited) = (vec![false; plain.len()], 0);
        for rank in 0..ranks {
            let found = begin(&scene, ranks, rank);
            visited = found.visited.max(visited);
            let layout = &found.warehouse.materials[0].layout;
            for (_, block) in found.warehouse.blocks() {
                for p in 0..block.count {
                    let identity = block.get(layout, Identity::ID, p, 0).to_bits() as usize;
                    assert!(!seen[identity]);
                    seen[identity] = true;
                    let x = [0, 1, 2].map(|a| block.get(layout, Position::ID, p, a));
                    assert_eq!(x, plain[identity]);
                }
            }
        }
        println!("{ranks} ranks: at most {visited} visited of {}", plain.len());
        assert!(seen.iter().all(|seen| *seen));
    }
}
