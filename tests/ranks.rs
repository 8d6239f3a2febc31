//! The same bits on any number of ranks, whoever has which patch. Ranks are threads of the test here; `tests/mpi.rs` runs
//! them as processes.
mod common;

use common::{Overrides, problem, scene};
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

/// What each of `ranks` ranks says at the end.
fn on_ranks(scene: &Scene, ranks: usize) -> Vec<Result<(u64, Report), RunError>> {
    let one = |network: Local| {
        let mut simulation = Simulation::on(Box::new(network), scene.clone(), Isa::detect())?;
        while simulation.step()? {}
        Ok((simulation.state_hash(), simulation.report()?))
    };
    std::thread::scope(|scope| {
        let ranks: Vec<_> = Local::crew(ranks).into_iter().map(|rank| scope.spawn(|| one(rank))).collect();
        ranks.into_iter().map(|rank| rank.join().expect("a rank ends")).collect()
    })
}

fn same(scene: &Scene, patches: [usize; 3], ranks: usize, threads: usize, wanted: &(u64, Report)) {
    let mut scene = scene.clone();
    (scene.run.patches, scene.run.threads) = (Some(patches), Some(threads));
    for result in on_ranks(&scene, ranks) {
        let (hash, report) = result.unwrap_or_else(|e| panic!("{patches:?} on {ranks} ranks: {e}"));
        assert_eq!(hash, wanted.0, "{patches:?} on {ranks} ranks of {threads} threads");
        for (a, b) in report.materials.iter().zip(&wanted.1.materials) {
            assert_eq!((a.energies, a.momentum, a.failed), (b.energies, b.momentum, b.failed));
        }
        assert_eq!((report.residual, report.deleted), (wanted.1.residual, wanted.1.deleted));
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
