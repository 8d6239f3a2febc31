//! What a run starts with, and what is compared after it.
use engine::simd::Wide;
use proptest::prelude::*;
use std::collections::BTreeMap;

/// A particle at the start.
#[derive(Clone, Debug)]
pub struct Particle {
    pub material: usize,
    pub x: [f64; 3],
    pub velocity: [f64; 3],
    pub charge: f64,
    pub whole: f64,
}

/// Materials and particles.
#[derive(Clone, Debug)]
pub struct Start {
    pub cells: [usize; 3],
    /// Fields of each material.
    pub fields: Vec<usize>,
    /// Numbers that each material remembers.
    pub memory: Vec<usize>,
    pub interacts: Vec<Vec<bool>>,
    pub particles: Vec<Particle>,
}

/// Three materials, one of two fields, which may interact; the first two do.
pub fn start() -> impl Strategy<Value = Start> {
    let cells = (5..18usize, 4..11usize, prop_oneof![Just(0), 4..8usize]).prop_map(|(x, y, z)| [x, y, z]);
    (cells, any::<bool>(), any::<bool>()).prop_flat_map(|(cells, simple, own)| {
        let particle = (0..3usize, unit3(simple), unit3(simple), unit(simple), whole());
        let particle = particle.prop_map(move |(material, x, velocity, charge, whole)| Particle {
            material,
            x: [0, 1, 2].map(|a| x[a] * cells[a] as f64),
            velocity: velocity.map(|v| 4.0 * (v - 0.5)),
            charge: charge - 0.5,
            whole,
        });
        prop::collection::vec(particle, 1..60).prop_map(move |particles| Start {
            cells,
            fields: vec![1, 2, 1],
            memory: vec![0, 3, 1],
            interacts: vec![vec![false, true, false], vec![true, own, false], vec![false; 3]],
            particles,
        })
    })
}

/// A number from 0 to 1: of a few bits, or of all.
fn unit(simple: bool) -> BoxedStrategy<f64> {
    if simple { (0..=16u8).prop_map(|n| f64::from(n) / 16.0).boxed() } else { (0.0..1.0f64).boxed() }
}

fn unit3(simple: bool) -> impl Strategy<Value = [f64; 3]> {
    [unit(simple), unit(simple), unit(simple)]
}

/// Whole numbers that sums in floating point lose among each other.
fn whole() -> impl Strategy<Value = f64> {
    let huge = f64::from(2u8).powi(70);
    prop_oneof![(-9..9i8).prop_map(f64::from), Just(huge), Just(-huge)]
}

/// What passes from step to step, by name, bit by bit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// By identity: position, what was read, memory.
    pub particles: BTreeMap<u64, Vec<u64>>,
    /// By label, field and node, where there is something.
    pub nodes: BTreeMap<(String, usize, [i32; 3]), Vec<[u64; 8]>>,
    pub shared: BTreeMap<String, Vec<[u64; 8]>>,
}

pub fn wide(of: impl Fn(usize) -> f64) -> Wide {
    Wide(std::array::from_fn(of))
}

fn bits(lines: &[Wide]) -> Vec<[u64; 8]> {
    lines.iter().map(|line| line.0.map(f64::to_bits)).collect()
}

impl State {
    pub fn node(&mut self, label: &str, field: usize, node: [i32; 3], lines: &[Wide]) {
        let bits = bits(lines);
        if bits.as_flattened().iter().any(|&bits| bits != 0) {
            self.nodes.insert((label.to_owned(), field, node), bits);
        }
    }

    pub fn line(&mut self, label: &str, lines: &[Wide]) {
        self.shared.insert(label.to_owned(), bits(lines));
    }

    pub fn value(&mut self, label: &str, values: &[f64]) {
        let lines: Vec<Wide> = values.iter().map(|x| Wide([*x; 8])).collect();
        self.line(label, &lines);
    }

    /// Adds what another rank has; what is the same everywhere must be.
    pub fn join(&mut self, other: Self) {
        assert!(self.shared.is_empty() || self.shared == other.shared, "ranks differ in shared labels");
        self.shared = other.shared;
        let before = self.particles.len() + self.nodes.len();
        let more = other.particles.len() + other.nodes.len();
        self.particles.extend(other.particles);
        self.nodes.extend(other.nodes);
        assert_eq!(self.particles.len() + self.nodes.len(), before + more, "something is on two ranks");
    }
}

/// What differs, in words that fit a screen.
#[track_caller]
pub fn same(what: &str, found: &State, expected: &State) {
    let list = |state: &State| -> Vec<String> {
        let numbers = |bits: &[u64]| bits.iter().map(|b| f64::from_bits(*b)).collect::<Vec<_>>();
        let particles = state.particles.iter().map(|(id, bits)| format!("particle {id} {:?}", numbers(bits)));
        let nodes =
            state.nodes.iter().map(|(key, bits)| format!("{key:?} {:?}", numbers(bits.as_flattened())));
        let shared =
            state.shared.iter().map(|(key, bits)| format!("{key} {:?}", numbers(bits.as_flattened())));
        particles.chain(nodes).chain(shared).collect()
    };
    if found != expected {
        let (found, expected) = (list(found), list(expected));
        let only = |a: &[String], b: &[String]| {
            a.iter().filter(|x| !b.contains(x)).take(8).cloned().collect::<Vec<_>>()
        };
        panic!("{what}:\nfound    {:#?}\nexpected {:#?}", only(&found, &expected), only(&expected, &found));
    }
}
