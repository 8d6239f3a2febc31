//! The same bits on any number of ranks, whoever has which patch. Ranks are threads of the test here; `tests/mpi.rs` runs
//! them as processes.

use crate::common::{Overrides, problem, scene};
use crate::runner::runner;
use engine::exec::ranks::local::Local;
use engine::schema::Label;
use proptest::prelude::*;
use scene::{Patches, Scene};
use simd::Isa;
use sinew::simulation::{Report, RunError, Simulation};
use tasks::labels;

/// The hash of all ranks' particles and the report at the end, on one rank in the simplest way.
fn alone(scene: &Scene) -> (u64, Report) {
    alone_with(scene, |_| {})
}

/// The same, with something done to it after each step.
fn alone_with(scene: &Scene, after: impl Fn(&mut Simulation)) -> (u64, Report) {
    let mut scene = scene.clone();
    (scene.run.patches, scene.run.threads) = (Some(Patches::Grid([1; 3])), Some(1));
    let mut simulation = Simulation::new(scene, Isa::detect()).unwrap_or_else(|e| panic!("{e}"));
    while simulation.step().unwrap_or_else(|e| panic!("{e}")) {
        after(&mut simulation);
    }
    (simulation.state_hash(), simulation.report().expect("one rank"))
}

/// What each of `ranks` ranks says at the end of what `march` does.
fn on_ranks(
    scene: &Scene,
    ranks: usize,
    march: impl Fn(&mut Simulation) -> Result<(), RunError> + Sync,
) -> Vec<Result<(u64, Report), RunError>> {
    let one = |network: Local| {
        let mut simulation = Simulation::on(Box::new(network), scene.clone(), Isa::detect())?;
        march(&mut simulation)?;
        Ok((simulation.state_hash(), simulation.report()?))
    };
    std::thread::scope(|scope| {
        let ranks: Vec<_> = Local::crew(ranks).into_iter().map(|rank| scope.spawn(|| one(rank))).collect();
        ranks.into_iter().map(|rank| rank.join().expect("a rank ends")).collect()
    })
}

/// Whoever waits for the end of a step of many ticks may end it in its middle, on any rank: all stop with the same tick. At its end there is nothing to
/// stop: steps of one tick go on.
#[test]
fn a_rank_that_cannot_wait_stops_all_of_them_within_a_step() {
    for (rates, stops) in [("per-material", true), ("common", false)] {
        let mut scene = problem("slab-quick", &[("run.rates", rates), ("run.steps", "3")]);
        (scene.run.patches, scene.run.threads) = (Some(Patches::Grid([2, 1, 2])), Some(1));
        let results = on_ranks(&scene, 3, |simulation| {
            let impatient = simulation.network().rank() == 2;
            simulation.set_impatience(Box::new(move || impatient));
            while simulation.step()? {}
            Ok(())
        });
        for result in results {
            assert_eq!(matches!(result, Err(RunError::Stopped { step: 0 })), stops, "{rates}");
            assert_eq!(result.is_ok(), !stops, "{rates}");
        }
    }
}

/// Whether all ranks say what one rank says alone.
fn check(results: &[Result<(u64, Report), RunError>], wanted: &(u64, Report)) -> Result<(), String> {
    for result in results {
        let (hash, report) = result.as_ref().map_err(ToString::to_string)?;
        if *hash != wanted.0 {
            return Err(format!("state hash {hash:x} instead of {:x}", wanted.0));
        }
        let numbers = |r: &Report| -> Vec<_> {
            r.materials
                .iter()
                .map(|m| (m.energies, m.momentum, m.center, m.counts.clone(), m.first.clone()))
                .collect()
        };
        let sums = |r: &Report| {
            let lost = (r.residual, r.deleted, r.deleted_energy, r.reflected, r.friction, r.impact);
            (lost, r.givers.clone())
        };
        if numbers(report) != numbers(&wanted.1) || sums(report) != sums(&wanted.1) {
            return Err(format!("{report:?}\ninstead of\n{:?}", wanted.1));
        }
    }
    Ok(())
}

fn steps(simulation: &mut Simulation) -> Result<(), RunError> {
    while simulation.step()? {}
    Ok(())
}

fn same(scene: &Scene, patches: [usize; 3], ranks: usize, threads: usize, wanted: &(u64, Report)) {
    let mut scene = scene.clone();
    (scene.run.patches, scene.run.threads) = (Some(Patches::Grid(patches)), Some(threads));
    check(&on_ranks(&scene, ranks, steps), wanted)
        .unwrap_or_else(|error| panic!("{patches:?} on {ranks} ranks of {threads} threads: {error}"));
}

#[test]
fn the_first_step_heeds_the_bodies_of_all_ranks() {
    let scene = scene(include_str!("../scenes/cloud.toml"), &[("run.steps", "3")]);
    let wanted = alone(&scene);
    for ranks in [2, 3] {
        same(&scene, [3, 2, 2], ranks, 1, &wanted);
    }
}

fn shot(overrides: Overrides<'_>) -> Scene {
    let soft = [("run.steps", "40")];
    problem("slab-quick", &[&soft, overrides].concat())
}

#[test]
fn a_shot_has_the_same_bits_on_any_number_of_ranks() {
    for rates in ["common", "per-material"] {
        let scene = shot(&[("run.rates", rates)]);
        let wanted = alone(&scene);
        for (patches, ranks, threads) in
            [([2, 1, 1], 2, 1), ([2, 2, 2], 3, 1), ([3, 1, 2], 4, 2), ([2, 2, 2], 8, 1)]
        {
            same(&scene, patches, ranks, threads, &wanted);
        }
    }
}

/// Two balls and a rigid one that fly at each other over the corners of patches.
const CROSSING: &str = include_str!("../scenes/crossing.toml");

/// Patches along each axis, ranks, threads, and the ranks of patches before and after a step.
fn layout() -> impl Strategy<Value = ([usize; 3], usize, usize, u64, [Vec<u32>; 2])> {
    let counts =
        prop::array::uniform3(1..=5usize).prop_filter("a patch a rank", |n| n.iter().product::<usize>() > 1);
    let shapes = (counts, 2..=5usize, 1..=2usize, 1..100u64);
    shapes.prop_flat_map(|(counts, ranks, threads, step)| {
        let patches = counts.iter().product::<usize>();
        let ranks = ranks.min(patches);
        let map = move || {
            prop::collection::vec(0..ranks as u32, patches).prop_map(move |mut of| {
                // each rank has a patch
                (0..ranks).for_each(|rank| of[rank * patches / ranks] = rank as u32);
                of
            })
        };
        (Just(counts), Just(ranks), Just(threads), Just(step), [map(), map()])
    })
}

/// All that meets bodies from outside.
#[test]
fn what_holds_and_pushes_bodies_is_the_same_on_any_ranks() {
    let texts = [
        include_str!("../scenes/held.toml"),
        include_str!("../scenes/afloat.toml"),
        include_str!("../scenes/carried.toml"),
    ];
    for (text, rates) in texts.into_iter().flat_map(|text| [(text, "common"), (text, "per-material")]) {
        let scene = scene(text, &[("run.rates", rates)]);
        let wanted = alone(&scene);
        for (patches, ranks, threads) in [([2, 1, 1], 2, 1), ([3, 2, 2], 4, 2)] {
            same(&scene, patches, ranks, threads, &wanted);
        }
    }
}

#[test]
fn random_patches_and_ranks_that_change_do_not_change_a_bit() {
    // particles that fly apart so fast that they cross blocks, patches and the faces of the domain
    let cloud = [
        ("body.a.velocity", "[170, -130, 90]"),
        ("body.b.velocity", "[-150, 160, -120]"),
        ("material.tool.angular-velocity", ""),
        ("boundary", ""),
        ("contact", ""),
    ];
    let reflected = [&cloud[..], &[("run.leaving", "reflect")]].concat();
    let scenes = [
        &[("run.rebalance-every", "7")][..],
        &[("run.rates", "per-material")],
        &[("run.shape", "linear"), ("contact", "")],
        &cloud,
        &reflected,
    ];
    for overrides in scenes {
        let scene = scene(CROSSING, overrides);
        let wanted = alone(&scene);
        println!("{} deleted, {} reflected", wanted.1.deleted, wanted.1.reflected);
        let result = runner(8).run(&layout(), |(patches, ranks, threads, step, maps)| {
            let mut scene = scene.clone();
            (scene.run.patches, scene.run.threads) = (Some(Patches::Grid(patches)), Some(threads));
            let march = |simulation: &mut Simulation| {
                simulation.set_ranks(maps[0].clone())?;
                while simulation.step()? {
                    if simulation.steps() == step {
                        simulation.set_ranks(maps[1].clone())?;
                    }
                }
                Ok(())
            };
            check(&on_ranks(&scene, ranks, march), &wanted).map_err(TestCaseError::fail)
        });
        result.unwrap_or_else(|error| panic!("{overrides:?}: {error}"));
    }
}

/// Blows all particles of the first material that are in the lower half of the domain far along x, at step 20.
fn gust(simulation: &mut Simulation) {
    if simulation.steps() != 20 {
        return;
    }
    let warehouse = &mut simulation.warehouse;
    let layout = &warehouse.materials[0].layout;
    for block in warehouse.particles.iter_mut().flat_map(|homes| &mut homes[0].blocks) {
        for particle in 0..block.count {
            let x = block.get(layout, labels::Position::ID, particle, 0);
            if x < -2e-3 {
                block.set(layout, labels::Position::ID, particle, 0, x + 8.7e-3);
            }
        }
    }
}

#[test]
fn particles_that_jump_over_ranks_arrive() {
    let scene = scene(CROSSING, &[("contact", "")]);
    let wanted = alone_with(&scene, gust);
    assert_ne!(wanted.0, alone(&scene).0);
    let mut scene = scene;
    (scene.run.patches, scene.run.threads) = (Some(Patches::Grid([5, 1, 1])), Some(1));
    for ranks in [2, 5] {
        let march = |simulation: &mut Simulation| {
            while simulation.step()? {
                gust(simulation);
            }
            Ok(())
        };
        check(&on_ranks(&scene, ranks, march), &wanted)
            .unwrap_or_else(|error| panic!("{ranks} ranks: {error}"));
    }
}

#[test]
fn errors_of_one_rank_are_the_same_on_all() {
    let scene = scene(
        CROSSING,
        &[("run.leaving", "error"), ("body.a.velocity", "[-300, 0, 0]"), ("boundary", ""), ("contact", "")],
    );
    let one = |ranks: usize| {
        let mut scene = scene.clone();
        (scene.run.patches, scene.run.threads) = (Some(Patches::Grid([2, 2, 1])), Some(1));
        on_ranks(&scene, ranks, steps)
            .into_iter()
            .map(|result| match result {
                Err(error) => error.to_string(),
                Ok(_) => panic!("nobody left the domain"),
            })
            .collect::<Vec<_>>()
    };
    let alone = one(1);
    assert!(alone[0].contains("left the domain"), "{}", alone[0]);
    assert_eq!(one(4), vec![alone[0].clone(); 4]);
}

#[test]
fn more_ranks_than_patches_are_refused_with_a_remedy() {
    let mut scene = scene(CROSSING, &[]);
    scene.run.patches = Some(Patches::Grid([2, 1, 1]));
    for result in on_ranks(&scene, 3, steps) {
        let error = result.map(|_| ()).expect_err("3 ranks cannot share 2 patches").to_string();
        assert!(error.contains("3 ranks") && error.contains("--patches"), "{error}");
    }
}

#[test]
fn patches_move_to_where_the_work_is_borne_evenly() {
    let mut scene = shot(&[("run.rebalance-every", "1000")]);
    let wanted = alone(&scene);
    (scene.run.patches, scene.run.threads) = (Some(Patches::Grid([4, 1, 4])), Some(1));
    let march = |simulation: &mut Simulation| {
        // one rank has nearly all
        simulation.set_ranks((0..16).map(|patch| u32::from(patch == 15)).collect())?;
        while simulation.step()? {}
        let balance = simulation.balance();
        assert!(balance.moves == 1 && balance.patches > 3, "{balance:?}");
        assert!(balance.imbalance > 1.5, "it was weighed before patches moved: {balance:?}");
        Ok(())
    };
    check(&on_ranks(&scene, 2, march), &wanted).unwrap_or_else(|error| panic!("{error}"));
}
