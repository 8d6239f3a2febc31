//! The same bits as a plain sum, on any patches, threads and ranks, whoever has which patch when.
use crate::reference::Reference;
use crate::run::{Layout, level, run};
use crate::runner::runner;
use crate::state::{Particle, Start, same, start};
use crate::toy::program;
use engine::program::hazards;
use proptest::prelude::*;
use proptest::sample::Index;

/// Steps of a run: patches change their rank before the last one.
const STEPS: usize = 4;

/// A layout of some random numbers that fits a level.
pub fn layout(start: &Start, ranks: usize, threads: usize, random: &[Index]) -> Layout {
    let columns = level(start.cells).block_columns();
    let patches = [0, 1, 2].map(|a| 1 + random[a].index(columns[a]));
    let count = patches.iter().product::<usize>();
    let ranks = ranks.min(count);
    // every rank has a patch
    let of = |first: usize| {
        let rank = |patch: usize| match patch < ranks {
            true => (patch + random[first].index(ranks)) % ranks,
            false => random[first + 1 + patch % 8].index(ranks),
        };
        (0..count).map(|patch| rank(patch) as u32).collect()
    };
    Layout { patches, ranks, of: [of(3), of(12)], moves: 1 + random[21].index(3), threads }
}

pub fn random() -> impl Strategy<Value = Vec<Index>> {
    prop::collection::vec(any::<Index>(), 22)
}

pub fn expected(start: &Start, steps: usize) -> crate::state::State {
    let mut reference = Reference::new(start);
    (0..steps).for_each(|_| reference.step());
    reference.state()
}

/// Runs `test` on some random inputs, the same each time.
pub fn cases<S: Strategy>(cases: u32, input: S, test: impl Fn(S::Value)) {
    let run = runner(cases).run(&input, |input| {
        test(input);
        Ok(())
    });
    run.unwrap_or_else(|error| panic!("{error}"));
}

#[test]
fn one_patch_gives_the_plain_sums() {
    cases(48, start(), |start| {
        same("one patch", &run(&start, &Layout::alone(), STEPS), &expected(&start, STEPS))
    });
}

#[test]
fn any_patches_threads_and_ranks_give_the_same_bits() {
    cases(64, (start(), 1..=4usize, 1..=2usize, random()), |(start, ranks, threads, random)| {
        let layout = layout(&start, ranks, threads, &random);
        same(&format!("{layout:?}"), &run(&start, &layout, STEPS), &expected(&start, STEPS));
    });
}

/// A particle jumps to a block that others are in, and back: in between nobody is around the nodes where it was.
#[test]
fn nodes_that_all_have_left_forget() {
    let particle = |x, velocity| Particle {
        material: 0,
        x: [x, 0.0, 0.0],
        velocity: [velocity, 0.0, 0.0],
        charge: 0.75,
        whole: 1.0,
    };
    let start = Start {
        cells: [13, 0, 0],
        fields: vec![1],
        memory: vec![0],
        interacts: vec![vec![false]],
        particles: vec![particle(1.25, -9.0), particle(10.5, 0.0)],
    };
    let two =
        Layout { patches: [3, 1, 1], ranks: 2, of: [vec![0, 1, 0], vec![1, 0, 1]], moves: 1, threads: 1 };
    let still = Layout { moves: 0, ..two.clone() };
    for layout in [Layout::alone(), two, still] {
        for steps in 1..=4 {
            same(&format!("{layout:?}"), &run(&start, &layout, steps), &expected(&start, steps));
        }
    }
}

#[test]
fn the_toy_has_no_hazard() {
    let program = program(&[1, 2, 1], [8, 8, 8], 4).expect("a program");
    assert_eq!(hazards(&program), []);
}
