//! The bench: operations are counted, ceilings hold together, reports are whole. Nothing here asserts a speed.

use crate::common::{problem, scene};
use engine::exec::meter::{Tally, What};
use scene::Scene;
use simd::counting::{self, Counts};
use simd::math::exp;
use simd::{Isa, Job, Simd, Wide, load, store};
use sinew::lab::bench::{Ceiling, Plan, Report, bench, compare};
use sinew::simulation::{Simulation, step_graph};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Counts what a job does.
fn counted<J: Job>(job: J) -> Counts {
    counting::take();
    Isa::COUNTING.dispatch(job);
    counting::take()
}

/// Lines through a function of vectors.
struct Through<'a, F>(&'a mut [Wide; 2], F);

trait Function {
    fn of<S: Simd>(&self, x: S) -> S;
}

impl<F: Function> Job for Through<'_, F> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let x: [S; 2] = load(self.0);
        store(&x.map(|x| self.1.of(x)), self.0);
    }
}

/// 1 + 2x + 3x² + 4x³ by Horner's rule: three multiply-adds.
struct Cubic;
impl Function for Cubic {
    fn of<S: Simd>(&self, x: S) -> S {
        let [a, b, c, d] = [1.0, 2.0, 3.0, 4.0].map(S::splat);
        d.fma(x, c).fma(x, b).fma(x, a)
    }
}

/// √((x − 1) / (x · x)) where it is not negative.
struct Root;
impl Function for Root {
    fn of<S: Simd>(&self, x: S) -> S {
        let ratio = (x - S::splat(1.0)) / (x * x);
        S::select(ratio.ge(S::splat(0.0)), ratio.sqrt(), S::splat(0.0))
    }
}

struct Exponential;
impl Function for Exponential {
    fn of<S: Simd>(&self, x: S) -> S {
        exp(x)
    }
}

#[test]
fn operations_of_known_functions_are_counted() {
    let mut lines = [Wide([2.0; 8]); 2];
    let counts = counted(Through(&mut lines, Cubic));
    assert_eq!(counts, Counts { fused: 6, loads: 2, stores: 2, ..Counts::default() });
    assert_eq!(counts.flop(), 8 * 2 * 6);
    assert_eq!(lines, [Wide([49.0; 8]); 2], "and the result is right");
    let counts = counted(Through(&mut [Wide([5.0; 8]); 2], Root));
    assert_eq!(counts, Counts { simple: 4, slow: 4, other: 4, loads: 2, stores: 2, fused: 0 });
    // two reductions of the argument, ten terms of a polynomial; r², r⁴, the rounding's factor, and the 1 of the series
    let counts = counted(Through(&mut [Wide([0.5; 8]); 2], Exponential));
    assert_eq!((counts.fused, counts.simple, counts.slow), (2 * 12, 2 * 4, 0));
}

#[test]
fn counting_is_not_among_the_sets_of_a_machine() {
    assert!(!Isa::available().contains(&Isa::COUNTING));
}

#[test]
fn ceilings_are_numbers() {
    let _quiet = quiet();
    for isa in Isa::available() {
        for threads in [1, sinew::simulation::available_threads()] {
            let ceiling = Ceiling::measure(threads, isa);
            println!("{isa:?}: {ceiling:?}");
            let rates = [ceiling.fma_gflop_per_s, ceiling.copy_gb_per_s];
            assert!(rates.iter().all(|rate| *rate > 0.0 && rate.is_finite()));
        }
    }
}

/// A steel ball pressed into tissue: two materials, contact, failure, in 1300 particles.
const PRESSED: &str = r#"
title = "pressed"
[domain]
lower = [-6, -6, -6]
upper = [6, 6, 6]
cell = 1
[material.soft]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "0.5 MPa"
[material.hard]
law = "j2"
density = 8000
bulk-modulus = "20 MPa"
shear-modulus = "10 MPa"
yield-stress = "1 MPa"
hardening = 0
[[body]]
name = "block"
material = "soft"
shape = { box = { lower = [-3, -3, -3], upper = [3, 1, 3] } }
[[body]]
name = "ball"
material = "hard"
shape = { sphere = { center = [0.3, 2.7, 0.2], radius = 1.7 } }
velocity = [0, -20, 0]
[[contact]]
between = ["soft", "hard"]
law = "friction"
friction = 0.1
[boundary]
y-min = "fixed"
[run]
until = 1
"#;

fn pressed() -> Scene {
    scene(PRESSED, &[])
}

fn simulation(mut scene: Scene, patches: [usize; 3], threads: usize) -> Simulation {
    (scene.run.patches, scene.run.threads) = (Some(scene::Patches::Grid(patches)), Some(threads));
    Simulation::new(scene, Isa::detect()).unwrap_or_else(|e| panic!("{e}"))
}

/// Tests of this file that compute wait for each other: they would take each other's cores.
static QUIET: Mutex<()> = Mutex::new(());

fn quiet() -> MutexGuard<'static, ()> {
    QUIET.lock().unwrap_or_else(PoisonError::into_inner)
}

fn report() -> Report {
    let _quiet = quiet();
    let mut simulation = simulation(pressed(), [1, 2, 1], 2);
    let plan = Plan { steps: 2, repeat: 2, threads: 2 };
    bench(&mut simulation, &plan, &mut |_| {}).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn a_report_holds_every_task_of_the_recipe_and_survives_json() {
    let report = report();
    println!("{report}");
    let graph = step_graph(&pressed(), 1).unwrap_or_else(|e| panic!("{e}"));
    let mut tasks: Vec<&str> = graph.graph.node_weights().map(|node| node.declaration.name).collect();
    let rows = report.sweeps.iter().flat_map(|sweep| &sweep.rows);
    let (engine, rows): (Vec<_>, Vec<_>) = rows.partition(|row| row.name.starts_with('('));
    let mut found: Vec<&str> =
        rows.iter().map(|row| row.name.split(" #").next().unwrap_or_default()).collect();
    tasks.sort();
    found.sort();
    assert_eq!(found, tasks);
    for name in ["(zero partial sums)", "(load region)", "(sum partials)"] {
        assert!(engine.iter().any(|row| row.name == name), "{name}");
    }
    for name in ["Weights", "Scatter", "ContactScatter", "Gather", "Stress", "Advance", "SignalSpeed"] {
        for row in rows.iter().filter(|row| row.name == name) {
            assert!(row.one_thread_ns > 0.0 && row.vectors.loads > 0.0 && row.flop > 0.0, "{row:?}");
        }
    }
    for sweep in report.sweeps.iter().filter(|sweep| !sweep.name.starts_with("once")) {
        assert!(sweep.total.bytes > 0.0 && sweep.particles > 0, "{}", sweep.name);
    }
    let text = serde_json::to_string(&report).expect("JSON");
    assert!(serde_json::from_str::<Report>(&text).expect("the report") == report, "{text}");
}

#[test]
fn a_report_against_itself_is_all_ones() {
    let report = report();
    let comparison = compare(&report, &report);
    assert!(comparison.pairs.len() > 100 && comparison.notes.is_empty());
    for pair in &comparison.pairs {
        assert_eq!((pair.ratio, pair.normalized), (1.0, 1.0), "{}", pair.path);
    }
    let mut slower = report.clone();
    slower.one_core.fma_gflop_per_s *= 0.5;
    slower.one_thread.best_updates_per_s *= 0.5;
    slower.one_thread.best_update_ns *= 2.0;
    let comparison = compare(&slower, &report);
    for path in ["one_thread.best_updates_per_s", "one_thread.best_update_ns"] {
        let pair = comparison.pairs.iter().find(|pair| pair.path == path).expect("a pair");
        assert_eq!(pair.normalized, 1.0, "a machine half as fast, {path}: {}", pair.ratio);
    }
}

/// Operations of every task in the steps after some.
fn operations(scene: Scene, patches: [usize; 3], threads: usize) -> Vec<Counts> {
    let mut simulation = simulation(scene, patches, threads);
    (0..5).for_each(|_| assert!(simulation.step().unwrap_or_else(|e| panic!("{e}"))));
    simulation.go_on_with(threads, Isa::COUNTING).unwrap_or_else(|e| panic!("{e}"));
    simulation.set_meter(true);
    (0..2).for_each(|_| assert!(simulation.step().unwrap_or_else(|e| panic!("{e}"))));
    let tally: Tally = simulation.take_meter();
    (0..simulation.graph().recipe.entries.len()).map(|entry| tally.cost(What::Entry(entry)).counts).collect()
}

#[test]
fn operations_do_not_depend_on_threads_and_patches() {
    let _quiet = quiet();
    for scene in [pressed(), problem("slab-quick", &[("body.bullet.shape.sphere.center.1", "4.6 mm")])] {
        let one = operations(scene.clone(), [1, 1, 1], 1);
        assert!(one.iter().any(|counts| counts.fused > 1000));
        assert_eq!(operations(scene.clone(), [2, 2, 2], 2), one);
        assert_eq!(operations(scene, [1, 3, 1], 4), one);
    }
}

#[test]
fn the_meter_does_not_change_the_run() {
    let _quiet = quiet();
    let hash = |metered: bool| {
        let mut simulation = simulation(pressed(), [2, 1, 1], 2);
        simulation.set_meter(metered);
        (0..6).for_each(|_| assert!(simulation.step().unwrap_or_else(|e| panic!("{e}"))));
        simulation.state_hash()
    };
    assert_eq!(hash(true), hash(false));
}

#[test]
fn a_step_that_is_not_metered_leaves_no_trace() {
    let mut simulation = simulation(pressed(), [1, 1, 1], 1);
    simulation.step().unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(simulation.take_meter().laps(), 0);
}
