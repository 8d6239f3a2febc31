//! The same bits on any number of ranks, whoever has which patch. Ranks are threads of the test here; `tests/mpi.rs` runs
//! them as processes.
mod common;

use common::{Overrides, problem, scene};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use sinew::exec::ranks::local::Local;
use sinew::input::scene::Scene;
use sinew::simd::Isa;
use sinew::simulation::{Report, RunError, Simulation};

/// The hash of all ranks' particles and the report at the end, on one rank in the simplest way.
fn alone(scene: &Scene) -> (u64, Report) {
    let mut scene = scene.clone();
    (scene.run.patches, scene.run.threads) = (Some([1; 3]), Some(1));
    let mut simulation = Simulation::new(scene, Isa::detect()).unwrap_or_else(|e| panic!("{e}"));
    while simulation.step().unwrap_or_else(|e| panic!("{e}")) {}
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
                .map(|m| (m.energies, m.momentum, m.center, m.failed, m.first_failure))
                .collect()
        };
        let sums =
            |r: &Report| (r.residual, r.deleted, r.deleted_energy, r.friction, r.impact, r.boundary_impulse);
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
    (scene.run.patches, scene.run.threads) = (Some(patches), Some(threads));
    check(&on_ranks(&scene, ranks, steps), wanted)
        .unwrap_or_else(|error| panic!("{patches:?} on {ranks} ranks of {threads} threads: {error}"));
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
const CROSSING: &str = include_str!("scenes/crossing.toml");

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

#[test]
fn random_patches_and_ranks_that_change_do_not_change_a_bit() {
    let scenes = [&[][..], &[("run.rates", "per-material")], &[("run.shape", "linear"), ("contact", "")]];
    for overrides in scenes {
        let scene = scene(CROSSING, overrides);
        let wanted = alone(&scene);
        let config = ProptestConfig { cases: 8, failure_persistence: None, ..ProptestConfig::default() };
        let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
        let result = runner.run(&layout(), |(patches, ranks, threads, step, maps)| {
            let mut scene = scene.clone();
            (scene.run.patches, scene.run.threads) = (Some(patches), Some(threads));
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
