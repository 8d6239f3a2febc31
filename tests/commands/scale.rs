//! `sinew scale`: the simulation of ticks against closed forms, and a short measurement through the command.

use crate::common::command::words;
use crate::common::problem;
use assert_cmd::Command;
use engine::graph::build::TaskGraph;
use engine::schema::Label;
use sinew::lab::plan;
use sinew::lab::scale::footprint::Footprint;
use sinew::lab::scale::load::{Listed, Load, Message, Ranks};
use sinew::lab::scale::model::{Cluster, Costs, PhaseCost, Setup};
use sinew::lab::scale::predict::{Outcome, simulate};
use sinew::lab::scale::series;
use sinew::lab::scale::step::Step;
use sinew::lab::scale::torus::{Brick, Torus};
use sinew::simulation::step_graph;
use std::sync::LazyLock;
use tasks::labels;

/// A tick that gives to nodes, updates them and takes from them, between two phases without a place. What it reduces takes
/// no time unless a test says so.
static STEP: LazyLock<Step<'static>> = LazyLock::new(|| step(0.0));

fn step(reduced: f64) -> Step<'static> {
    static GRAPH: LazyLock<TaskGraph> =
        LazyLock::new(|| step_graph(&problem("slab-quick", &[]), 1).unwrap_or_else(|e| panic!("{e}")));
    let mut step = Step::of(&problem("slab-quick", &[]), &GRAPH);
    step.kinds.iter_mut().for_each(|tick| tick.reduced.fill(reduced));
    step
}

fn costs() -> Costs {
    let (give, take) = (PhaseCost::Particles(vec![20.0]), PhaseCost::Particles(vec![25.0]));
    let phases = vec![PhaseCost::Once(0.0), give, PhaseCost::Nodes(900.0), take, PhaseCost::Once(0.0)];
    Costs { phases, contention: 1.0, ..Costs::default() }
}

fn setup(cluster: Cluster) -> Setup<'static> {
    Setup { step: &STEP, costs: costs(), cluster, threads: 1, steps: 5 }
}

fn brick(blocks: f64) -> Brick {
    Brick {
        particles: vec![512.0 * blocks],
        blocks: vec![blocks],
        nodes: vec![(vec![0], 1.4 * blocks)],
        reach: [0.3, 2.0],
        fields: vec![1],
        parts: vec![[1.0, 0.0]],
        patches: 8.0,
    }
}

/// Task time of giving to nodes, of nodes, and of taking from them, on the rim and in the interior.
fn work(rim: [f64; 3], inner: [f64; 3]) -> Vec<[f64; 2]> {
    let mut work = vec![[0.0; 2]; 5];
    (0..3).for_each(|phase| work[phase + 1] = [rim[phase], inner[phase]]);
    work
}

/// Ranks of which `sends` says what each sends: sums and motion.
fn listed(loads: Vec<Load>, sends: impl Fn(usize) -> Vec<(u32, [f32; 2])>) -> Listed {
    let ranks = 0..loads.len();
    let of = |exchange: usize| {
        let message = move |(to, bytes): (u32, [f32; 2])| Message { to, bytes: bytes[exchange] };
        ranks
            .clone()
            .map(|rank| sends(rank).into_iter().map(message).filter(|m| m.bytes > 0.0).collect())
            .collect()
    };
    let beside = ranks.clone().map(|rank| sends(rank).into_iter().map(|(to, _)| to).collect()).collect();
    Listed { loads: vec![loads], sends: vec![vec![of(0), of(1)]], beside }
}

fn near(a: f64, b: f64, tolerance: f64) {
    assert!((a - b).abs() <= tolerance * b.abs(), "{a} instead of {b}");
}

/// Ranks in a row, all with the same load, that send `sums` and `motion` to both sides.
fn row(count: usize, load: Load, sums: f32, motion: f32) -> Listed {
    listed(vec![load; count], |rank: usize| {
        let beside = [rank.checked_sub(1), Some(rank + 1).filter(|&next| next < count)];
        beside.into_iter().flatten().map(|to| (to as u32, [sums, motion])).collect()
    })
}

/// Two halves that exchange `bytes` of sums and of motion.
fn pair(rim: f64, inner: f64, bytes: f32) -> Listed {
    let work = work([rim; 3], [inner; 3]);
    let load = Load { work, blocks: [8.0, 64.0], slabs: 1, ..Load::default() };
    row(2, load, bytes, bytes)
}

/// Wires between machines that cost latency alone.
fn far(latency: f64) -> Cluster {
    Cluster { latency, ranks: 1, ..Cluster::free() }
}

#[test]
fn one_rank_takes_the_sum_of_its_costs() {
    let load = Load {
        work: work([0.0; 3], [3e6, 1e6, 4e6]),
        blocks: [0.0, 500.0],
        lists: 2e5,
        relocate: 1e5,
        slabs: 10,
    };
    let outcome = simulate(&row(1, load, 0.0, 0.0), &setup(Cluster::default()));
    near(outcome.step, 8.3e-3, 1e-12);
    near(outcome.shares.compute, 8.0 / 8.3, 1e-12);
    near(outcome.shares.engine, 0.3 / 8.3, 1e-12);
    assert_eq!((outcome.shares.halo, outcome.shares.reduction), (0.0, 0.0));
}

#[test]
fn several_workers_share_tasks_but_not_the_engine() {
    let work = work([0.0; 3], [8e6, 0.0, 0.0]);
    let load = Load { work, blocks: [0.0, 1000.0], lists: 1e6, slabs: 1, ..Load::default() };
    let four = Setup { threads: 4, ..setup(Cluster::default()) };
    let outcome = simulate(&row(1, load, 0.0, 0.0), &four);
    // half a block of 8 us is left over, on three of four workers
    near(outcome.step, 1e-9 * (1e6 + 2e6 + 0.5 * 8e3 * 0.75), 1e-12);
}

#[test]
fn two_ranks_that_have_nothing_else_to_do_wait_for_every_message() {
    // sums and motion wait for their messages, travelers for a third, and both reductions for one each
    let (rim, latency) = (1e6, 1e-3);
    let outcome = simulate(&pair(rim, 0.0, 64.0), &setup(far(latency)));
    near(outcome.step, 3e-9 * rim + 5.0 * latency, 1e-9);
    near(outcome.shares.halo, 2.0 * latency / outcome.step, 1e-6);
    near(outcome.path[3], 5.0 * latency / outcome.step, 1e-3);
}

#[test]
fn bytes_take_their_time_on_the_wire_and_in_packing() {
    let bytes = 1e6;
    let cluster = Cluster { bandwidth: 1e9, ..far(0.0) };
    let mut setup = setup(cluster);
    let step = |setup: &Setup<'_>| simulate(&pair(0.0, 0.0, bytes), setup).step;
    // sums and motion; the messages of travelers and reductions are lines
    near(step(&setup), 2.0 * 1e-3 + 3.0 * 64e-9, 1e-4);
    setup.costs.pack = 0.5;
    near(step(&setup), 2.0 * (1e-3 + 2.0 * 0.5e-3) + 3.0 * 64e-9, 1e-4);
}

#[test]
fn ranks_of_a_machine_share_its_wire() {
    // four ranks in a ring of two machines: each machine sends two messages of 1 MB each way
    let load = Load { work: work([1.0; 3], [0.0; 3]), blocks: [1.0, 0.0], slabs: 1, ..Load::default() };
    let ranks = listed(vec![load; 4], |rank| vec![((rank as u32 + 2) % 4, [1e6, 0.0])]);
    let cluster = Cluster { bandwidth: 1e9, ..far(0.0) };
    let alone = simulate(&ranks, &setup(cluster)).step;
    let shared = simulate(&ranks, &setup(Cluster { ranks: 2, ..cluster })).step;
    near(alone, 1e-3, 1e-2);
    near(shared, 2e-3, 1e-2);
}

#[test]
fn a_tapered_tree_slows_what_leaves_a_switch() {
    let ranks = pair(0.0, 0.0, 1e6);
    let cluster = Cluster { bandwidth: 1e9, machines: 1, taper: 1.0, ..far(0.0) };
    let full = simulate(&ranks, &setup(cluster)).step;
    let tapered = simulate(&ranks, &setup(Cluster { taper: 3.0, ..cluster })).step;
    near(tapered, 3.0 * full, 1e-3);
}

#[test]
fn a_reduction_takes_a_latency_for_each_doubling() {
    let latency = 1e-6;
    for count in [2usize, 3, 4, 5, 8, 100, 1024] {
        // nobody is beside anybody: reductions are all there is
        let load = Load { work: work([0.0; 3], [0.0; 3]), slabs: 1, ..Load::default() };
        let ranks = listed(vec![load; count], |_| Vec::new());
        let outcome = simulate(&ranks, &setup(far(latency)));
        let each = outcome.step / (2.0 * latency);
        if count.is_power_of_two() {
            near(each, f64::from(count.ilog2()), 1e-9);
        } else {
            // ranks beyond the last power of two send before the rounds and get the result after them
            let (least, most) = (f64::from(count as u32).log2().ceil(), f64::from(count.ilog2() + 2));
            assert!((least - 1e-9..=most + 1e-9).contains(&each), "{count}: {each} latencies");
        }
        near(outcome.shares.reduction, 1.0, 1e-9);
    }
}

#[test]
fn a_halo_is_hidden_while_the_interior_is_longer() {
    let latency = 1e-4;
    let step = |inner: f64| simulate(&pair(1e5, inner, 64.0), &setup(far(latency)));
    let long = step(1e6);
    // the motion goes out within the interior too; travelers and two reductions are not hidden
    near(long.step, 3e-9 * (1e5 + 1e6) + 3.0 * latency, 1e-9);
    assert!(long.shares.halo < 1e-9);
    assert!(step(1e3).shares.halo > 0.1);
}

#[test]
fn a_network_without_cost_scales_weakly_without_loss() {
    let mut setup = setup(Cluster::free());
    setup.costs.block = 100.0;
    // with neighbors on all axes ranks do the same from then on
    let points = series::weak(&brick(216.0), &setup, 4096);
    for point in &points {
        near(point.efficiency, 1.0, 1e-9);
        near(point.shares.compute + point.shares.engine, 1.0, 1e-9);
    }
}

#[test]
fn more_latency_overhead_or_noise_and_less_bandwidth_never_speed_up() {
    let torus = |count| Torus::new(&brick(64.0), &setup(Cluster::free()), count);
    for count in [2, 8, 27, 60] {
        let ranks = torus(count);
        let step = |change: &dyn Fn(&mut Cluster)| {
            let mut cluster = Cluster { ranks: 1, ..Cluster::default() };
            change(&mut cluster);
            simulate(&ranks, &setup(cluster)).step
        };
        let grows = |steps: Vec<f64>| assert!(steps.windows(2).all(|w| w[1] >= w[0]), "{count}: {steps:?}");
        let factors = [0.0, 0.5, 1.0, 2.0, 10.0, 100.0];
        grows(factors.iter().map(|f| step(&|c| c.latency *= f)).collect());
        grows(factors.iter().map(|f| step(&|c| c.overhead *= f)).collect());
        grows(factors.iter().map(|f| step(&|c| c.noise = 0.01 * f)).collect());
        grows([100.0, 10.0, 1.0, 0.1].iter().map(|f| step(&|c| c.bandwidth *= f)).collect());
    }
}

#[test]
fn shares_add_up_and_uneven_loads_are_named() {
    let mut ranks = row(8, pair(1e5, 1e6, 64.0).loads[0][0].clone(), 6400.0, 640.0);
    ranks.loads[0][3].work = work([1e5; 3], [4e6; 3]);
    let outcome = simulate(&ranks, &setup(Cluster::default()));
    let s = outcome.shares;
    near(s.compute + s.engine + s.halo + s.travel + s.reduction, 1.0, 1e-9);
    near(outcome.path.iter().sum(), 1.0, 1e-5);
    assert!(outcome.imbalance > 2.0 && s.compute < 0.5);
}

#[test]
fn the_same_question_has_the_same_answer() {
    let ranks = Torus::new(&brick(64.0), &setup(Cluster::free()), 500);
    let setup = setup(Cluster { noise: 0.05, ..Cluster::default() });
    assert_eq!(simulate(&ranks, &setup), simulate(&ranks, &setup));
}

#[test]
fn a_hundred_thousand_ranks_take_seconds() {
    let ranks = Torus::new(&brick(512.0), &setup(Cluster::free()), 100_000);
    let step = step(12e3);
    let setup = Setup { steps: 2, step: &step, ..setup(Cluster { noise: 0.01, ..Cluster::default() }) };
    let Outcome { step, shares, .. } = simulate(&ranks, &setup);
    assert!(ranks.count() == 100_000 && step > 0.0 && shares.compute > 0.5);
}

#[test]
fn ranks_of_a_scene_send_what_the_plan_counts_for_its_first_step() {
    for (patches, ranks) in [("[2, 2, 2]", 2), ("[3, 2, 4]", 5), ("[6, 3, 6]", 20)] {
        let scene = problem("slab-quick", &[("run.patches", patches)]);
        let plan = plan::plan(&scene, ranks, ranks).expect("patches that fit");
        let footprint = Footprint::at_start(&scene).expect("a footprint");
        let graph = step_graph(&scene, plan.decomposition.patches.len()).expect("a graph");
        let step = Step::of(&scene, &graph);
        let setup = Setup { step: &step, ..setup(Cluster::free()) };
        let listed = footprint.ranks(&plan.decomposition, ranks, &setup).expect("enough patches");
        let exchange = |label| {
            let halo = graph.exchanges.iter().position(|exchange| exchange.labels.contains(&label));
            halo.expect("an exchange that brings it")
        };
        let mut messages = Vec::new();
        for label in [labels::NodeSums::ID, labels::NodeMotion::ID] {
            let number = exchange(label);
            let wanted = plan.traffic.exchange(&graph.exchanges[number], |_| true);
            let mut sent = std::collections::BTreeMap::new();
            for from in 0..ranks {
                listed.sends(from, 0, Some(number), &mut messages);
                sent.extend(messages.iter().map(|m| ((from, m.to as usize), m.bytes as u64)));
            }
            let wanted = wanted.into_iter().map(|(pair, messages)| (pair, messages.bytes));
            assert_eq!(sent, wanted.collect(), "{}", label.name());
        }
        let mut pairs = std::collections::BTreeSet::new();
        for from in 0..ranks {
            listed.sends(from, 0, None, &mut messages);
            pairs.extend(messages.iter().map(|message| (from, message.to as usize)));
        }
        assert_eq!(pairs, plan.traffic.neighbors);
        let most = listed.loads[0].iter().map(|load| load.blocks[0] + load.blocks[1]).sum::<f64>();
        assert_eq!(most, footprint.blocks() as f64);
        let particles: f64 = footprint.particles().iter().sum();
        assert_eq!(particles, plan.traffic.particles.iter().flatten().sum::<u64>() as f64);
    }
}

#[test]
fn what_ranks_of_a_torus_send_is_received_and_neighbors_are_different_ranks() {
    let setup = setup(Cluster::free());
    for count in [1, 2, 3, 8, 27, 60] {
        let torus = Torus::new(&brick(64.0), &setup, count);
        let (mut sent, mut came, mut messages) = (vec![0.0; count], vec![0.0; count], Vec::new());
        for rank in 0..count {
            torus.sends(rank, 0, Some(0), &mut messages);
            assert!(messages.len() <= 26 && messages.iter().all(|message| message.to as usize != rank));
            for message in &messages {
                sent[rank] += message.bytes;
                came[message.to as usize] += message.bytes;
            }
        }
        let same = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-3 * a;
        assert!(sent.iter().zip(&came).all(same), "{count}: {sent:?} {came:?}");
    }
}

/// The command on slab-quick, with its output in a folder.
fn scale(out: &std::path::Path, more: &[&str]) -> std::process::Output {
    let mut command = Command::cargo_bin("sinew").expect("the command is built");
    command.args(["scale", "problems/slab-quick", "--quiet", "--steps=2", "--warm-up=1", "--repeat=1"]);
    command.arg("--out").arg(out).args(more).output().expect("it starts")
}

#[test]
fn a_short_measurement_has_all_rows_the_same_state_and_a_prediction() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let more = ["--patches", "1,4", "--threads", "1,2", "--most-ranks", "64", "--rank-threads", "2"];
    let output = scale(folder.path(), &more);
    let (text, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{text}{errors}");
    let csv = std::fs::read_to_string(folder.path().join("measured.csv")).expect("a table");
    let rows: Vec<Vec<&str>> = csv.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let cases: Vec<&[&str]> = rows.iter().map(|row| &row[..3]).collect();
    assert_eq!(cases, [["1", "1", "1"], ["4", "1", "1"], ["1", "2", "1"], ["4", "2", "1"]]);
    let report = std::fs::read_to_string(folder.path().join("scale.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["same_state"], true);
    let number = |value: &serde_json::Value| value.as_f64().unwrap_or_else(|| panic!("no number: {value}"));
    for row in report["rows"].as_array().expect("rows") {
        assert!(number(&row["step_ms"][0]) > 0.0 && number(&row["updates_per_s"]) > 0.0);
        let parts = &row["parts"];
        assert!((0.0..=1.0).contains(&number(&parts["task_share"])) && number(&parts["overhead_ms"]) >= 0.0);
        assert_eq!(number(&parts["messages"]), 0.0, "one rank sends nothing");
    }
    assert_eq!(number(&report["rows"][0]["efficiency"]), 1.0);
    // rows on more workers than there are cores are not checked
    let checks = report["checks"].as_array().expect("checks");
    assert!(checks.len() >= 2 && checks.iter().all(|check| number(&check["model_ms"]) > 0.0));
    for series in ["strong", "weak_points"] {
        let points = report[series].as_array().expect("points");
        assert!(points.len() > 4 && number(&points[0]["efficiency"]) == 1.0, "{series}");
    }
    for file in ["efficiency.svg", "time.svg", "patches.svg", "predicted.csv", "prediction.svg"] {
        assert!(folder.path().join(file).is_file(), "{file} is missing");
    }
}

#[test]
fn a_run_that_fails_is_a_row_and_not_the_end() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output = scale(folder.path(), &["--patches", "1,1000x1x1", "--threads", "1", "--measure-only"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("failed: 1000 patches along x"), "{text}");
    let csv = std::fs::read_to_string(folder.path().join("measured.csv")).expect("a table");
    assert_eq!(csv.lines().count(), 3);
    let nothing = scale(folder.path(), &["--patches", "1000x1x1", "--threads", "1", "--measure-only"]);
    assert_eq!(nothing.status.code(), Some(1));
}

#[test]
fn materials_at_rates_of_their_own_are_predicted() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let output =
        scale(folder.path(), &["--predict-only", "--most-ranks", "4", "--set", "run.rates=per-material"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", words(&output));
    assert!(text.contains(" ticks at rest") && folder.path().join("predicted.csv").is_file(), "{text}");
}

#[test]
fn bad_lists_and_networks_are_bad_usage() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (more, part) in [
        (["--patches", "0"], "--patches"),
        (["--threads", "1,x"], "--threads"),
        (["--network", "speed=1"], "latency"),
        (["--steps", "0"], "--steps"),
        (["--ticks", "0"], "at least 1"),
        (["--ranks", "18446744073709551615"], "16777216"),
        (["--rank-threads", "18446744073709551615"], "at most 16777216"),
        (["--most-ranks", "5000000000"], "at most 16777216"),
    ] {
        let output = scale(folder.path(), &more);
        assert_eq!(output.status.code(), Some(2), "{more:?}");
        let said = words(&output);
        assert!(said.contains(part), "{more:?}: {said}");
    }
}
