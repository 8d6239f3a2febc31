//! Three hundred materials: more than any word has bits.
#![allow(missing_docs)]
mod common;

use common::{Random, finish, scene, start};
use engine::schema::Label;
use sinew::simulation::Simulation;
use std::collections::BTreeMap;
use std::fmt::Write;
use tasks::labels::{Identity, Position};

const MANY: usize = 300;

/// A material of its own, and a cube of it.
fn cube(text: &mut String, name: usize, material: usize, lower: [f64; 3], edge: f64, velocity: [f64; 3]) {
    let upper = lower.map(|x| x + edge);
    write!(
        text,
        "[[body]]\nname = \"{name}\"\nmaterial = \"m{material}\"\nparticles-per-cell = 1\n\
         shape = {{ box = {{ lower = {lower:?}, upper = {upper:?} }} }}\nvelocity = {velocity:?}\n"
    )
    .expect("text");
}

fn materials(text: &mut String, count: usize) {
    for material in 0..count {
        write!(
            text,
            "[material.m{material}]\nlaw = \"neo-hookean\"\ndensity = 1000\nbulk-modulus = \"1 MPa\"\n\
             shear-modulus = \"0.6 MPa\"\n"
        )
        .expect("text");
    }
}

/// Where each particle is.
fn positions(simulation: &Simulation) -> BTreeMap<u64, [f64; 3]> {
    let warehouse = &simulation.warehouse;
    let of = warehouse.blocks().flat_map(|(material, block)| {
        let get = move |label, p, c| block.get(&warehouse.materials[material].layout, label, p, c);
        (0..block.count).map(move |p| {
            (get(Identity::ID, p, 0).to_bits(), [0, 1, 2].map(|axis| get(Position::ID, p, axis)))
        })
    });
    of.collect()
}

/// Cubes that nobody told to touch fly through one another.
#[test]
fn three_hundred_materials_fly_freely() {
    let mut text = "[domain]\nlower = [-8, -8, -8]\nupper = [48, 48, 24]\ncell = 1\n".to_owned();
    materials(&mut text, MANY);
    let mut random = Random(7);
    let velocities: Vec<[f64; 3]> = (0..MANY).map(|_| random.vector().map(|v| 6.0 * v)).collect();
    for (m, &velocity) in velocities.iter().enumerate() {
        let lower = [m / 30, m / 3 % 10, m % 3].map(|i| 4.0 * i as f64);
        cube(&mut text, m, m, lower, 2.0, velocity);
    }
    text.push_str("[run]\nuntil = \"0.5 s\"\nthreads = 1\npatches = [2, 2, 1]\n");
    let mut simulation = start(scene(&text, &[]));
    let before = positions(&simulation);
    assert_eq!(before.len(), 8 * MANY);
    finish(&mut simulation).expect("a flight");
    let time = simulation.clock().time;
    let mut worst = 0.0f64;
    for (particle, x) in positions(&simulation) {
        let velocity = velocities[particle as usize / 8];
        (0..3).for_each(|a| worst = worst.max((x[a] - before[&particle][a] - velocity[a] * time).abs()));
    }
    println!("after {time} s particles are at most {worst:.1e} cells from where they should be");
    assert!((time - 0.5).abs() < 1e-12 && worst < 1e-10, "{worst}");
}

/// A row of cubes, each with its velocity and in contact with the next: of so many materials, in turn.
fn row(count: usize, law: &str) -> Simulation {
    let mut text = "[domain]\nlower = [-8, -4, -4]\nupper = [1208, 8, 8]\ncell = 1\n".to_owned();
    materials(&mut text, count);
    let mut random = Random(11);
    for m in 0..MANY {
        cube(&mut text, m, m % count, [4.0 * m as f64, 0.0, 0.0], 4.0, random.vector());
    }
    for m in 1..count {
        writeln!(text, "[[contact]]\nbetween = [\"m{}\", \"m{m}\"]\n{law}", m - 1).expect("text");
    }
    text.push_str("[run]\nuntil = \"0.06 s\"\nthreads = 1\npatches = [4, 1, 1]\n");
    start(scene(&text, &[]))
}

/// A cube shares nodes with its two neighbors alone: whether all others are of other materials, or every second one is of its own,
/// they must meet in the same way.
#[test]
fn three_hundred_materials_in_a_chain_meet_as_two_do() {
    for law in ["law = \"bonded\"", "law = \"friction\"\nfriction = 0.3"] {
        let (mut chain, mut two) = (row(MANY, law), row(2, law));
        let before = positions(&chain);
        assert_eq!(before, positions(&two));
        for simulation in [&mut chain, &mut two] {
            finish(simulation).expect("a run");
        }
        let (chain, two) = (positions(&chain), positions(&two));
        let apart = |x: &[f64; 3], y: &[f64; 3]| (0..3).map(|a| (x[a] - y[a]).abs()).fold(0.0, f64::max);
        let worst = |from: &BTreeMap<u64, [f64; 3]>| {
            chain.iter().map(|(particle, x)| apart(x, &from[particle])).fold(0.0, f64::max)
        };
        println!("{law}: {:.1e} cells apart, moved {:.1e}", worst(&two), worst(&before));
        assert!(worst(&two) < 1e-9 && worst(&before) > 0.02, "{law}");
    }
}
