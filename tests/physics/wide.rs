//! Small bodies in domains of 4096³ cells and more: memory and work follow what is there, and no bit depends on where the faces are.

use crate::common::{Overrides, run, scene, start};
use engine::exec::ranks::local::Local;
use scene::{Patches, Scene};
use simd::Isa;
use sinew::simulation::Simulation;

/// Cells of 2⁻¹² m, so that a place has the same bits from whatever face it is counted; in a domain that is a little larger than the bodies.
const TIGHT: &str = r#"
[domain]
lower = [0.49609375, 0.49609375, 0.49609375]
upper = [0.5078125, 0.5078125, 0.5078125]
cell = 0.000244140625
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "2 MPa"
shear-modulus = "1 MPa"
[material.stiff]
law = "neo-hookean"
density = 2000
bulk-modulus = "5 MPa"
shear-modulus = "2 MPa"
[[contact]]
between = ["soft", "stiff"]
law = "friction"
friction = 0.2
[[body]]
name = "cube"
material = "soft"
shape = { box = { lower = [0.5, 0.5, 0.5], upper = [0.501953125, 0.501953125, 0.501953125] } }
velocity = [20, 3, -2]
[[body]]
name = "ball"
material = "stiff"
shape = { sphere = { center = [0.5034, 0.5013, 0.5007], radius = 0.00098 } }
velocity = [-25, 0, 4]
[run]
until = 1
steps = 40
leaving = "error"
[output]
frames = 0
"#;

/// The same bodies in the middle of 4096³ cells.
const WIDE: Overrides<'_> = &[("domain.lower", "[0, 0, 0]"), ("domain.upper", "[1, 1, 1]")];

fn hash(mut scene: Scene, patches: Option<Patches>, threads: usize) -> u64 {
    (scene.run.patches, scene.run.threads) = (patches, Some(threads));
    let mut simulation = start(scene);
    while simulation.step().unwrap_or_else(|e| panic!("{e}")) {}
    simulation.state_hash()
}

/// The hash of all ranks, which is one.
fn hash_on_ranks(mut scene: Scene, patches: Option<Patches>, ranks: usize) -> u64 {
    (scene.run.patches, scene.run.threads) = (patches, Some(1));
    scene.run.rebalance_every = 7;
    let one = |network: Local| {
        let mut simulation =
            Simulation::on(Box::new(network), scene.clone(), Isa::detect()).unwrap_or_else(|e| panic!("{e}"));
        while simulation.step().unwrap_or_else(|e| panic!("{e}")) {}
        simulation.state_hash()
    };
    let hashes: Vec<u64> = std::thread::scope(|scope| {
        let ranks: Vec<_> = Local::crew(ranks).into_iter().map(|rank| scope.spawn(|| one(rank))).collect();
        ranks.into_iter().map(|rank| rank.join().expect("a rank ends")).collect()
    });
    assert!(hashes.iter().all(|hash| *hash == hashes[0]));
    hashes[0]
}

#[test]
fn bodies_in_a_wide_domain_have_the_bits_of_the_same_bodies_in_a_tight_one() {
    let report = run(scene(TIGHT, &[]));
    assert!(report.friction > 0.0, "they must meet");
    for rates in ["common", "per-material"] {
        let more = [("run.rates", rates)];
        let tight = hash(scene(TIGHT, &more), Some(Patches::Grid([1; 3])), 1);
        let wide = || scene(TIGHT, &[WIDE, &more].concat());
        for (patches, threads) in [
            (None, 2),
            (Some(Patches::Total(5)), 1),
            (Some(Patches::Grid([1; 3])), 1),
            (Some(Patches::Grid([2, 3, 1])), 2),
            // patches of which one border goes through the bodies
            (Some(Patches::Grid([512, 2, 2])), 1),
        ] {
            assert_eq!(hash(wide(), patches, threads), tight, "{patches:?} on {threads} threads, {rates}");
        }
        for (patches, ranks) in [(None, 3), (Some(Patches::Grid([2, 2, 2])), 2)] {
            assert_eq!(hash_on_ranks(wide(), patches, ranks), tight, "{patches:?} on {ranks} ranks, {rates}");
        }
    }
}

/// Three bodies at the corners of 2²⁰ cells along each axis; one of them flies.
#[test]
fn bodies_that_are_far_apart_take_what_they_need_alone() {
    let far = [
        ("domain.lower", "[0, 0, 0]"),
        ("domain.upper", "[256, 256, 256]"),
        ("run.steps", "60"),
        ("body.0.velocity", "[900, -700, 800]"),
        ("body.1.shape.sphere.center", "[255.99, 255.99, 0.01]"),
    ];
    let text = TIGHT.replace(
        "[run]",
        "[[body]]\nname = \"third\"\nmaterial = \"stiff\"\nvelocity = [0, 1, 0]\n\
         shape = { box = { lower = [0.0009765625, 255.5, 128], upper = [0.001953125, 255.501, 128.001] } }\n[run]",
    );
    let wide = || scene(&text, &far);
    let mut simulation =
        start(Scene { run: scene::Run { threads: Some(1), patches: None, ..wide().run }, ..wide() });
    let blocks = |s: &Simulation| s.warehouse.blocks().map(|(_, block)| block.index).collect::<Vec<_>>();
    let before = blocks(&simulation);
    while simulation.step().unwrap_or_else(|e| panic!("{e}")) {}
    let now = blocks(&simulation);
    assert!(now.iter().filter(|index| !before.contains(index)).count() > 20, "it must fly into other blocks");
    // nodes only around what is there, and patches only where it is
    let (particles, nodes) = (now.len(), simulation.warehouse.node_count() / 64);
    assert!(nodes <= 27 * particles, "{nodes} blocks of nodes around {particles} blocks of particles");
    let loads = |s: &Simulation| {
        let all = s.warehouse.particles.iter();
        all.filter(|homes| homes.iter().any(|home| !home.blocks.is_empty())).count()
    };
    assert!(loads(&simulation) >= 3, "{}", loads(&simulation));
    let alone = simulation.state_hash();
    for (patches, threads) in [(Some(Patches::Grid([4, 2, 3])), 2), (Some(Patches::Total(64)), 1)] {
        assert_eq!(hash(wide(), patches, threads), alone, "{patches:?}");
    }
    for ranks in [2, 5] {
        assert_eq!(hash_on_ranks(wide(), None, ranks), alone, "{ranks} ranks");
    }
}

/// No more patches than layers of blocks can be parted, all of them with particles, wherever the bodies are.
#[test]
fn patches_of_a_small_body_are_where_it_is() {
    let mut small = scene(TIGHT, &[WIDE, &[("contact", ""), ("run.steps", "1")]].concat());
    small.run.threads = Some(1);
    let simulation = start(small);
    let homes = &simulation.warehouse.particles;
    let filled = homes.iter().filter(|homes| homes.iter().any(|home| !home.blocks.is_empty())).count();
    println!("{filled} of {} patches hold particles", homes.len());
    assert!(homes.len() >= 8 && 2 * filled >= homes.len(), "{filled} of {}", homes.len());
}
