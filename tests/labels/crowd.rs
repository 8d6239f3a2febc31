//! More materials and fields than fit a word of bits.
use crate::layouts::{cases, expected};
use crate::run::{Layout, run};
use crate::state::{Particle, Start, same};
use proptest::prelude::*;

/// Particles of so many materials, every third with two fields; each interacts with the next.
fn crowd(materials: usize) -> impl Strategy<Value = Start> {
    let particle =
        (0..materials, [0.0..13.0f64, 0.0..9.0], -0.5..0.5f64).prop_map(|(material, [x, y], charge)| {
            Particle { material, x: [x, y, 0.0], velocity: [charge, 1.5 * charge, 0.0], charge, whole: 1.0 }
        });
    prop::collection::vec(particle, materials).prop_map(move |particles| Start {
        cells: [13, 9, 0],
        fields: (0..materials).map(|m| 1 + usize::from(m % 3 == 0)).collect(),
        memory: vec![0; materials],
        interacts: (0..materials).map(|m| (0..materials).map(|n| m.abs_diff(n) == 1).collect()).collect(),
        particles,
    })
}

fn same_on_ranks(materials: usize) {
    cases(1, crowd(materials), |start| {
        let expected = expected(&start, 2);
        same("one patch", &run(&start, &Layout::alone(), 2), &expected);
        let of = [vec![0, 1, 1, 0], vec![1, 0, 1, 0]];
        let layout = Layout { patches: [2, 2, 1], ranks: 2, of, moves: 1, threads: 1 };
        same("two ranks", &run(&start, &layout, 2), &expected);
    });
}

#[test]
fn a_hundred_materials_give_the_plain_sums() {
    same_on_ranks(100);
}

#[test]
fn three_hundred_materials_give_the_plain_sums() {
    same_on_ranks(300);
}
