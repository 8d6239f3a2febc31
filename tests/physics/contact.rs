//! Contact: momentum to rounding, Coulomb's law, the gap at which it begins, rigid bodies.

use crate::common;
use crate::common::{
    Overrides, Random, finish, instruction_sets, minus, momentum, norm, place, problem, run, scene, start,
};
use engine::data::fields::FieldId;
use engine::data::schedule::FieldTime;
use engine::data::workspace::{Workspace, no_columns};
use engine::graph::task::Runnable;
use engine::schema::{Label, LabelId};
use grid::{BlockShape, Lattice, Level, NODES};
use physics::contact::AnyContactLaw;
use physics::contact::bonded::Bonded;
use physics::contact::friction::{Criterion, Friction};
use physics::contact::surface::SurfaceTable;
use simd::{Isa, Wide};
use std::array::from_fn;
use tasks::contact::{Contact, FieldPair};
use tasks::labels::{self, SCHEMA};

const CRITERIA: [Criterion; 3] =
    [Criterion::Approach, Criterion::ApproachOrCompression, Criterion::ApproachAndCompression];

/// One block of nodes that `materials` touch, with random masses over six decades, velocities, forces and surfaces.
struct Nodes {
    columns: [(LabelId, Vec<Wide>); 4],
    present: Vec<usize>,
}

impl Nodes {
    fn random(materials: usize, lattice: &Lattice, random: &mut Random) -> Self {
        let mut columns = [
            labels::NodeSums::ID,
            labels::ContactSums::ID,
            labels::NodeMotion::ID,
            labels::ContactImpulse::ID,
        ]
        .map(|label| (label, vec![Wide::default(); NODES * materials]));
        let [(_, sums), (_, surfaces), (_, motions), _] = &mut columns;
        let shape = BlockShape::of([1; 3]);
        for (line, ((sum, surface), motion)) in sums.iter_mut().zip(surfaces).zip(motions).enumerate() {
            let (mass, f, v) = (10f64.powf(3.0 * random.sign()), random.vector(), random.vector());
            let (node, g) = (lattice.position(shape.place(line % NODES)), random.vector());
            // the center of mass of what a node sees lies within a cell of it
            let x: [f64; 3] = from_fn(|a| node[a] + 0.3 * lattice.cell * random.sign());
            *sum = Wide([mass, mass * v[0], mass * v[1], mass * v[2], f[0], f[1], f[2], 1.0]);
            *surface = Wide([0.0, mass * x[0], mass * x[1], mass * x[2], g[0], g[1], g[2], 0.0]);
            *motion = Wide([v[0], v[1], v[2], 0.0, 0.0, 0.0, 0.0, 0.0]);
        }
        Self { columns, present: (0..materials).collect() }
    }

    fn momentum(&self, n: usize) -> ([f64; 3], f64) {
        let [(_, sums), _, (_, motions), _] = &self.columns;
        let lines = (0..self.present.len()).map(|m| NODES * m + n);
        lines.fold(([0.0; 3], 0.0), |(p, size), line| {
            let (m, v) = (sums[line].0[0], motions[line].0);
            (from_fn(|a| p[a] + m * v[a]), size + m * norm([v[0], v[1], v[2]]))
        })
    }

    fn run(&mut self, task: &Contact, isa: Isa) {
        let origin = Level { lower: [0.0; 3], cell: 0.1, cells: [4; 3] }.origin([0; 3]);
        // in the midst of a step of every other material
        let field = |&material: &usize| FieldTime {
            field: FieldId::new(material),
            material,
            begins: false,
            ends: material % 2 == 0,
            elapsed: 1e-3 * material as f64,
            missed: 0.0,
            tick: 1e-3,
            step: 1e-2,
        };
        let fields: Vec<FieldTime> = self.present.iter().map(field).collect();
        let at = place(origin, 0, &fields);
        let columns = no_columns(Vec::new(), SCHEMA.len());
        let mut reactions = vec![Wide::default(); labels::Reactions::ID.width()];
        let mut space = Workspace { columns, chunk: 0..0, ahead: 0, widths: &[] };
        space.columns[labels::Reactions::ID.index()] = &mut reactions;
        for (label, column) in &mut self.columns {
            space.columns[label.index()] = column;
        }
        task.run_on(isa, &at, &mut space);
    }
}

#[test]
fn every_node_keeps_its_momentum_whoever_meets_there() {
    let lattice = Lattice { lower: [0.0; 3], cell: 0.1 };
    let mut random = Random(3);
    let friction = |criterion| AnyContactLaw::from(Friction { coefficient: 0.4, criterion });
    for law in [Bonded::FOREVER.into(), friction(CRITERIA[0]), friction(CRITERIA[1]), friction(CRITERIA[2])] {
        for materials in [2, 3] {
            let pairs: &[[usize; 2]] = if materials == 2 { &[[0, 1]] } else { &[[0, 1], [0, 2], [1, 2]] };
            let pair = |it: &[usize; 2]| FieldPair { between: it.map(FieldId::new), law, gap: 0.0, tile: 0 };
            let task = Contact {
                pairs: pairs.iter().map(pair).collect(),
                lattice,
                least_mass: 1e-14,
                surfaces: vec![SurfaceTable::new(0.25, 0.25); materials],
                interpolated: false,
            };
            let (mut worst, mut changed) = (0.0f64, 0);
            for isa in instruction_sets() {
                for _ in 0..20 {
                    let mut nodes = Nodes::random(materials, &lattice, &mut random);
                    let before: Vec<_> = (0..NODES).map(|n| nodes.momentum(n)).collect();
                    let motions = nodes.columns[2].1.clone();
                    nodes.run(&task, isa);
                    for (n, (p, size)) in before.into_iter().enumerate() {
                        worst = worst.max(norm(minus(nodes.momentum(n).0, p)) / size);
                    }
                    changed += motions.iter().zip(&nodes.columns[2].1).filter(|(a, b)| a != b).count();
                }
            }
            println!("{law:?} of {materials}: worst node {worst:.1e}, {changed} velocities changed");
            assert!(changed > 100, "something touches");
            assert!(worst < 1e-13);
        }
    }
}

#[test]
fn balls_that_bounce_keep_the_momentum_and_most_of_the_energy() {
    let bounce = |cell: &str| {
        let mut simulation = start(problem("two-spheres", &[("domain.cell", cell)]));
        let before = simulation.report().expect("one rank");
        let after = finish(&mut simulation).unwrap_or_else(|e| panic!("{e}"));
        let one = norm(before.materials[0].momentum);
        let drift = norm(minus(momentum(&after), momentum(&before))) / one;
        let [left, right] = [0, 1].map(|m| after.materials[m].velocity()[0]);
        let (lost, total) = (1.0 - after.energy().total() / before.energy().total(), before.energy().total());
        println!(
            "cells of {cell}: momentum {drift:.0e}, velocities {left:.4} {right:.4}, energy lost {lost:.4}: \
             impact {:.4}, residual {:.4}, vibration {:.4}",
            after.impact / total,
            after.residual / total,
            after.energy().strain / total
        );
        assert!(drift < 1e-12);
        assert_eq!(after.friction, 0.0, "smooth balls lose nothing to friction");
        assert!(left < -0.7 && (left + right).abs() < 1e-12, "they part as they came");
        lost
    };
    // 5, 10 and 16 cells across a ball: 35 %, 11.7 % and 6.2 % are lost, most of it by the transfer between particles
    // and nodes, and hardly less with smaller steps
    let [coarse, middle, fine] = ["4 mm", "2 mm", "1.25 mm"].map(bounce);
    assert!(coarse < 0.36 && middle < 0.12 && fine < 0.065);
    assert!(fine < middle && middle < coarse, "less is lost on a finer grid");
}

/// Velocity of the block down the slope after 50 ms.
fn slide(friction: &str) -> (f64, f64) {
    let report = run(problem("sliding-block", &[("contact.0.friction", friction), ("run.until", "50 ms")]));
    let plane = &report.materials[1];
    assert_eq!(plane.velocity(), [0.0; 3], "the plane rests");
    (report.materials[0].velocity()[0], report.time)
}

#[test]
fn a_block_slides_down_the_slope_as_coulomb_says() {
    let (v, t) = slide("0.3");
    let exact = (4.905 - 0.3 * 8.495709) * t;
    println!("{v} m/s, not {exact} m/s: {:.2} %", 100.0 * (v / exact - 1.0));
    assert!((v / exact - 1.0).abs() < 0.02);
}

/// The slice between planes of symmetry slides without friction as if it fell down the slope.
#[test]
fn planes_of_symmetry_do_not_hold_a_smooth_block() {
    let (v, t) = slide("0");
    println!("{v} m/s, not {} m/s: {:.2} %", 4.905 * t, 100.0 * (v / (4.905 * t) - 1.0));
    assert!((v / (4.905 * t) - 1.0).abs() < 0.005);
}

#[test]
fn a_block_sticks_to_a_rough_slope() {
    let (v, t) = slide("0.7");
    println!("{v} m/s where free fall down the slope is {} m/s", 4.905 * t);
    assert!(v.abs() < 0.02 * 4.905 * t);
}

const BLOCKS: &str = r#"
[domain]
lower = [-12, -4, -4]
upper = [12, 4, 4]
cell = 1
[material.left]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 MPa"
shear-modulus = "0.5 MPa"
[material.right]
law = "neo-hookean"
density = 1500
bulk-modulus = "1 MPa"
shear-modulus = "0.5 MPa"
[[body]]
name = "left"
material = "left"
shape = { box = { lower = [-9, -2, -2], upper = [-4, 2, 2] } }
velocity = [1, 0, 0]
[[body]]
name = "right"
material = "right"
shape = { box = { lower = [0, -2, -2], upper = [5, 2, 2] } }
[[contact]]
between = ["left", "right"]
law = "friction"
friction = 0.2
[run]
until = 20
threads = 1
patches = 2
"#;

/// Gaps between the blocks in cells when any impulse passes, and when the first has lost 0.2 % of its velocity.
fn gaps_at_first_touch(overrides: Overrides<'_>) -> [f64; 2] {
    let mut simulation = start(scene(BLOCKS, overrides));
    let (mut gap, mut first) = (f64::NAN, None);
    while simulation.step().unwrap_or_else(|e| panic!("{e}")) {
        let report = simulation.report().expect("one rank");
        let [left, right] = [0, 1].map(|m| report.materials[m].center[0]);
        if first.is_none() && report.impact != 0.0 {
            first = Some(gap);
        }
        if report.materials[0].velocity()[0] < 0.998 {
            return [first.unwrap_or(f64::NAN), gap];
        }
        gap = right - left - 5.0; // both are 5 long
    }
    panic!("they never met");
}

/// The gaps for seven velocities of the other block: the faster it runs away, the farther from a node they meet.
fn gaps(n: &str, width: usize) -> Vec<[f64; 2]> {
    let gaps = ["0", "0.013", "0.047", "0.08", "0.11", "0.15", "-0.21"].map(|away| {
        let velocity = format!("[{away}, 0, 0]");
        let corner = |x: i32, sign: i32| format!("[{x}, {0}, {0}]", sign * width as i32);
        let (lower, upper) = (corner(-9, -1), corner(-4, 1));
        gaps_at_first_touch(&[
            ("body.0.particles-per-cell", n),
            ("body.1.particles-per-cell", n),
            ("body.0.shape.box.lower", &lower),
            ("body.0.shape.box.upper", &upper),
            ("body.1.velocity", &velocity),
        ])
    });
    println!("{n} particles a cell, {width} cells wide: {gaps:.3?}");
    gaps.into()
}

/// A narrow block against a wide one, whose normal is that of its face.
#[test]
fn blocks_feel_each_other_when_their_surfaces_meet() {
    for n in ["1", "2", "3", "4"] {
        assert!(gaps(n, 1).iter().flatten().all(|gap| gap.abs() < 0.01), "remaining gap in cells");
    }
}

/// Where two edges lie in one plane, nodes beside them see normals that lean out of it; the sides of the blocks must not
/// be taken for surfaces that touch.
#[test]
fn blocks_with_flush_edges_feel_each_other_when_their_surfaces_meet() {
    assert!(gaps("2", 2).iter().flatten().all(|gap| gap.abs() < 0.01), "remaining gap in cells");
}

/// With a gap of their own they feel each other so far away.
#[test]
fn a_gap_is_where_contact_begins() {
    for gap in ["0.2", "0.4"] {
        let found = gaps_at_first_touch(&[("contact.0.gap", gap)]);
        println!("gap {gap}: {found:.3?}");
        let wanted: f64 = gap.parse().expect("a number");
        assert!(found.iter().all(|found| (found - wanted).abs() < 0.1), "{gap}: {found:?}");
    }
}

const BALL: [(&str, &str); 6] = [
    ("material.left", "{ law = \"rigid\", motion = \"free\", density = 4000 }"),
    ("body.0.shape", "{ sphere = { center = [-3, 0.3, 0.2], radius = 2.5 } }"),
    ("body.0.velocity", "[2, 0.5, 0.2]"),
    ("body.1.velocity", "[-1, 0, 0]"),
    ("domain.cell", "0.5"),
    ("run.until", "1"),
];

#[test]
fn a_free_rigid_ball_and_what_it_hits_conserve_momentum() {
    for density in ["400", "4000"] {
        let ball = format!("{{ law = \"rigid\", motion = \"free\", density = {density} }}");
        let mut simulation =
            start(scene(BLOCKS, &[&[("material.left", ball.as_str())], &BALL[1..]].concat()));
        let before = simulation.report().expect("one rank");
        let after = finish(&mut simulation).unwrap_or_else(|e| panic!("{e}"));
        let drift = norm(minus(momentum(&after), momentum(&before))) / norm(before.materials[0].momentum);
        let angular = norm(minus(common::angular_momentum(&after), common::angular_momentum(&before)));
        let (total, speed) = (before.energy().total(), after.materials[0].velocity());
        println!(
            "density {density}: momentum {drift:.0e}, angular {:.1e}, ball at {speed:.3?}, friction {:.3} impact {:.3} residual {:.3}",
            angular / norm(common::angular_momentum(&before)),
            after.friction / total,
            after.impact / total,
            after.residual / total
        );
        assert!(norm(minus(speed, [2.0, 0.5, 0.2])) > 0.3, "they hit");
        assert!(drift < 1e-12);
        assert!(after.residual.abs() < 0.2 * total);
    }
}

/// Head-on against a block at rest: at any time the ball has lost what the block has gained.
#[test]
fn a_free_rigid_ball_slows_down_by_what_the_block_gains() {
    let ball = ("material.left", "{ law = \"rigid\", motion = \"free\", density = 4000 }");
    let flight = [("body.0.velocity", "[2, 0, 0]"), ("body.1.velocity", "[0, 0, 0]")];
    for rates in ["common", "per-material"] {
        let more = [&[ball, BALL[1], BALL[4], BALL[5], ("run.rates", rates)][..], &flight].concat();
        let mut simulation = start(scene(BLOCKS, &more));
        let before = simulation.report().expect("one rank").materials;
        let (p, mut worst, mut slowest, mut pulled) = (norm(before[0].momentum), 0.0f64, 2.0f64, 0.0f64);
        while simulation.step().unwrap_or_else(|e| panic!("{e}")) {
            let now = simulation.report().expect("one rank").materials;
            let [lost, gained] =
                [minus(before[0].momentum, now[0].momentum), minus(now[1].momentum, before[1].momentum)];
            worst = worst.max(norm(minus(lost, gained)) / p);
            pulled = pulled.max(now[0].velocity()[0] - slowest);
            slowest = slowest.min(now[0].velocity()[0]);
        }
        println!("{rates}: slowest {slowest:.4} m/s, momentum {worst:.0e}, sped up by {pulled:.1e} m/s");
        assert!(worst < 1e-12 && slowest < 1.7);
        assert!(pulled < 5e-5, "nothing pulls the ball but rim nodes whose normals lean");
    }
}

#[test]
fn a_prescribed_rigid_ball_keeps_its_velocity() {
    let ball = (
        "material.left",
        "{ law = \"rigid\", motion = \"prescribed\", velocity = [2, 0.5, 0.2], density = 4000 }",
    );
    let changes = [&BALL[1..2], &[ball, ("body.0.velocity", "")], &BALL[3..]].concat();
    let after = run(scene(BLOCKS, &changes));
    let change = |m: usize, before| norm(minus(after.materials[m].velocity(), before));
    assert!(change(0, [2.0, 0.5, 0.2]) < 1e-13 && change(1, [-1.0, 0.0, 0.0]) > 0.1, "they hit");
}
