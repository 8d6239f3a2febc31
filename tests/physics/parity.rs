//! The same bits for any number of patches and threads, and other bits for any other input.

use crate::common;
use crate::common::{Overrides, Random, finish, instruction_sets, problem, scene, soft_shot};
use scene::Scene;
use simd::Isa;
use sinew::simulation::{Report, RunError, Simulation};

type Layout = ([usize; 3], usize);

const LAYOUTS: [Layout; 4] = [([1, 1, 1], 1), ([2, 1, 2], 2), ([3, 2, 1], 4), ([6, 5, 4], 3)];

fn simulate(mut scene: Scene, (patches, threads): Layout, isa: Isa) -> (u64, Report) {
    (scene.run.patches, scene.run.threads) = (Some(scene::Patches::Grid(patches)), Some(threads));
    let mut simulation = Simulation::new(scene, isa).unwrap_or_else(|e| panic!("{e}"));
    let report = finish(&mut simulation).unwrap_or_else(|e| panic!("{e}"));
    (simulation.state_hash(), report)
}

/// The scene ends in the same bits, and reports the same bits, on all layouts. Returns one report.
#[track_caller]
fn same(scene: &Scene, layouts: &[Layout], isa: Isa) -> Report {
    let (hash, report) = simulate(scene.clone(), layouts[0], isa);
    for &layout in &layouts[1..] {
        let (other, its) = simulate(scene.clone(), layout, isa);
        // as text, every number has its shortest exact form, and -0 is not 0
        assert_eq!(format!("{its:?}"), format!("{report:?}"), "{layout:?} on {isa:?}");
        assert_eq!(other, hash, "{layout:?} on {isa:?}");
    }
    report
}

fn shot(overrides: Overrides<'_>) -> Scene {
    soft_shot("60", overrides)
}

#[test]
fn a_shot_has_the_same_bits_on_all_patches_and_threads() {
    for isa in instruction_sets() {
        let report = same(&shot(&[]), &LAYOUTS, isa);
        let [matrix, fiber, total] = ["matrix", "fiber", "total"].map(|kind| report.materials[0].count(kind));
        println!("{isa:?}: {} s, failed {:?}", report.time, report.materials[0].counts);
        assert!(matrix + total > 100 && fiber + total > 100, "the shot must fail tissue to test failure");
        assert!(report.friction > 0.0 && report.materials[1].energies.plastic > 0.0);
    }
}

#[test]
fn the_slab_of_the_paper_has_the_same_bits_on_8_patches() {
    let slab = problem("slab", &[("run.steps", "3"), ("body.bullet.shape.sphere.center.1", "4.55 mm")]);
    same(&slab, &[([1, 1, 1], 1), ([2, 2, 2], 2)], Isa::detect());
}

/// Two balls and a rigid one that fly at each other over the corners of patches.
const CROSSING: &str = include_str!("../scenes/crossing.toml");

#[test]
fn bodies_that_cross_corners_of_random_patches_keep_their_bits() {
    let mut random = Random(1);
    let mut any = || {
        let count = |r: &mut Random| 1 + (5.0 * r.unit()) as usize;
        ([count(&mut random), count(&mut random), count(&mut random)], 1 + (3.0 * random.unit()) as usize)
    };
    // hats pass through each other: a particle that is pressed over a cell's edge may invert
    for overrides in [&[][..], &[("run.shape", "linear"), ("contact", "")]] {
        let layouts: Vec<Layout> = (0..4).map(|_| any()).collect();
        println!("{layouts:?}");
        for isa in instruction_sets() {
            same(&scene(CROSSING, overrides), &layouts, isa);
        }
    }
}

/// All that meets bodies from outside.
#[test]
fn what_holds_and_pushes_bodies_keeps_its_bits() {
    let [held, afloat, carried] = [
        include_str!("../scenes/held.toml"),
        include_str!("../scenes/afloat.toml"),
        include_str!("../scenes/carried.toml"),
    ];
    let layouts = [([1; 3], 1), ([2; 3], 2), ([5, 3, 4], 3)];
    let runs =
        [held, afloat, carried].into_iter().flat_map(|text| [(text, "common"), (text, "per-material")]);
    for ((text, rates), isa) in runs.zip(instruction_sets().into_iter().rev().cycle()) {
        let report = same(&scene(text, &[("run.rates", rates)]), &layouts, isa);
        let gives = |it: &&sinew::simulation::GiverReport| common::norm(it.impulse) > 0.0;
        let (giving, all) = (report.givers.iter().filter(gives).count(), report.givers.len());
        assert!(giving + 1 >= all, "{giving} of {all} give something");
    }
}

#[test]
fn materials_with_rates_of_their_own_keep_their_bits_too() {
    let own = ("run.rates", "per-material");
    let hard = [("material.lead.bulk-modulus", "46 GPa"), ("material.lead.shear-modulus", "5.6 GPa")];
    for isa in instruction_sets() {
        let report = same(&shot(&[&[own][..], &hard].concat()), &LAYOUTS, isa);
        let [matrix, fiber, total] = ["matrix", "fiber", "total"].map(|kind| report.materials[0].count(kind));
        println!("{isa:?}: {} s, failed {:?}", report.time, report.materials[0].counts);
        assert!(report.time > 1e-4, "steps as long as tissue can take");
        assert!(matrix + total > 100 && fiber + total > 100, "the shot must fail tissue to test failure");
        let crossing = scene(CROSSING, &[own, ("material.b.bulk-modulus", "500 MPa")]);
        same(&crossing, &[LAYOUTS[0], LAYOUTS[1], ([5, 5, 4], 3)], isa);
    }
}

#[test]
fn a_millionth_of_any_input_is_seen() {
    let base = [("run.steps", "20"), ("output.frames", "0")];
    let hash = |more: Overrides<'_>| simulate(shot(&[&base, more].concat()), ([2, 1, 2], 2), Isa::detect()).0;
    let mut hashes = vec![hash(&[])];
    for change in [
        ("material.tissue.density", "1000.001"),
        ("material.lead.bulk-modulus", "46.000046 MPa"),
        ("contact.0.friction", "0.08000008"),
        ("body.bullet.velocity.1", "-50.00005"),
        ("run.cfl", "0.4000004"),
        ("body.slab.fibers.turning.angle", "180.00018 deg"),
    ] {
        hashes.push(hash(&[change]));
    }
    assert_eq!(hash(&[]), hashes[0], "the same input twice");
    hashes.sort();
    hashes.dedup();
    assert_eq!(hashes.len(), 7, "each input has a hash of its own");
}

/// A cloud of particles that fly apart so fast that they cross blocks, patches and the faces of the domain.
fn cloud(overrides: Overrides<'_>) -> Scene {
    let fast = [
        ("body.a.velocity", "[170, -130, 90]"),
        ("body.b.velocity", "[-150, 160, -120]"),
        ("material.tool.angular-velocity", ""),
        ("boundary", ""),
        ("contact", ""),
    ];
    scene(CROSSING, &[&fast, overrides].concat())
}

#[test]
fn particles_that_leave_are_deleted_the_same_way_everywhere() {
    let scene = cloud(&[("run.steps", "90")]);
    for isa in instruction_sets() {
        let report = same(&scene, &LAYOUTS[..3], isa);
        let left: u64 = report.materials.iter().map(|m| m.particles).sum();
        println!("{isa:?}: {} deleted, {left} left", report.deleted);
        assert!(report.deleted > 100 && left > 100 && report.deleted_energy > 0.0);
        let all: usize = scene.bodies.iter().map(|body| scene::sampling::count(&scene, body)).sum();
        assert_eq!(report.deleted + left, all as u64, "every particle is here or accounted for");
    }
}

#[test]
fn a_particle_that_must_not_leave_is_named_with_its_patch_and_time() {
    let error = |layout: Layout| {
        let mut scene = cloud(&[("run.leaving", "error")]);
        (scene.run.patches, scene.run.threads) = (Some(scene::Patches::Grid(layout.0)), Some(layout.1));
        let mut simulation = Simulation::new(scene, Isa::detect()).unwrap_or_else(|e| panic!("{e}"));
        match finish(&mut simulation) {
            Err(error) => (error.to_string(), error),
            Ok(_) => panic!("nothing left the domain"),
        }
    };
    let (text, one) = error(([1, 1, 1], 1));
    let (split, many) = error(([2, 3, 2], 2));
    println!("{text}\n{split}");
    let RunError::Left { identity, position, time, patch: 0, others, .. } = &one else { panic!("{one}") };
    let RunError::Left { identity: i, position: x, time: t, others: o, patch, .. } = &many else {
        panic!("{many}")
    };
    assert_eq!((identity, position, time, others), (i, x, t, o));
    assert!(*patch < 12);
    for fact in [format!("particle {identity} of"), "patch 0".into(), "t = ".into(), "run.leaving".into()] {
        assert!(text.contains(&fact), "{fact:?} is not in: {text}");
    }
}
