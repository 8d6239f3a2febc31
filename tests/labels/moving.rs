//! Particles that change their block: everybody who must go is found, those that stay and those that come have all their numbers.
use crate::runner::runner;
use crate::toy::{Identity, Position, SCHEMA, Velocity};
use engine::data::extent::{out_of_reach, outside};
use engine::data::layout::{NodeLayout, ParticleLayout};
use engine::data::particles::ParticleBlock;
use engine::schema::Label;
use engine::simd::{Isa, LANES};
use grid::Level;
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

const LEVEL: Level = Level { lower: [-1.0, 2.0, 0.0], cell: 0.5, cells: [24, 12, 9] };
const REST: [f64; 3] = [7.0, 8.0, 9.0];

fn layout() -> ParticleLayout {
    ParticleLayout::new(&SCHEMA, [Identity::ID, Position::ID, Velocity::ID], BTreeMap::new())
}

fn empty(index: [i32; 3]) -> ParticleBlock {
    ParticleBlock::new(index, &NodeLayout::new(&SCHEMA, [], LEVEL.shape()))
}

fn record(layout: &ParticleLayout, who: usize, x: [f64; 3]) -> Vec<f64> {
    let mut record = layout.inert_record(REST);
    let mut set = |label: engine::schema::LabelId, numbers: [f64; 3]| {
        let width = layout.width(label);
        record[layout.starts[label.index()]..][..width].copy_from_slice(&numbers[..width]);
    };
    set(Identity::ID, [f64::from_bits(who as u64); 3]);
    set(Position::ID, x);
    set(Velocity::ID, [who as f64, 0.5, -1.0]);
    record
}

fn numbers(layout: &ParticleLayout, block: &ParticleBlock, particle: usize) -> Vec<u64> {
    let mut record = Vec::new();
    block.read(layout, particle, &mut record);
    record.into_iter().map(f64::to_bits).collect()
}

#[test]
fn whoever_must_go_is_found() {
    let index = [-1..7i32, -1..4, -1..3];
    let half = prop_oneof![Just(0.0), Just(0.25), Just(0.5)];
    // in base nodes from the block's first node on
    let places = prop::collection::vec([-3.0..9.0f64, -3.0..9.0, -3.0..9.0], 1..70);
    let check = |(index, half, places): ([i32; 3], f64, Vec<[f64; 3]>)| {
        let (layout, half) = (layout(), [half; 3]);
        let mut block = empty(index);
        for (who, place) in places.iter().enumerate() {
            let x = [0, 1, 2]
                .map(|a| LEVEL.lower[a] + LEVEL.cell * (f64::from(4 * index[a]) + place[a] + half[a]));
            block.push(&layout, REST, LEVEL.base(x, half), &record(&layout, who, x));
        }
        for isa in Isa::available() {
            let found: Vec<usize> = block.strays(isa, &layout, &LEVEL, half).collect();
            prop_assert!(found.is_sorted() && found.iter().all(|&p| p < places.len()));
            for particle in 0..places.len() {
                let x = [0, 1, 2].map(|a| block.get(&layout, Position::ID, particle, a));
                let y = LEVEL.base(x, half);
                let must =
                    |a: usize| outside(&LEVEL, a, y[a], half[a]) || out_of_reach(&LEVEL, index, a, y[a]);
                // somebody who is well inside is not looked at again
                let well = |a: usize| {
                    [-1e-5, 1e-5].iter().all(|d| {
                        let y = y[a] + d;
                        !outside(&LEVEL, a, y, half[a]) && !out_of_reach(&LEVEL, index, a, y)
                    })
                };
                let is_found = found.contains(&particle);
                prop_assert!(is_found || !(0..3).any(must), "{isa:?}: {particle} at {y:?} is not found");
                prop_assert!(!is_found || !(0..3).all(well), "{isa:?}: {particle} at {y:?} is found");
            }
        }
        Ok(())
    };
    runner(200).run(&(index, half, places), check).unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn those_that_stay_keep_all_their_numbers() {
    let some = prop::collection::btree_set(0..100usize, 0..100);
    let check = |(count, leaving, more): (usize, BTreeSet<usize>, usize)| {
        let (layout, mut block) = (layout(), empty([0; 3]));
        let at = |who: usize| [0.01 * who as f64, 3.0, 0.5];
        let push = |block: &mut ParticleBlock, who| {
            block.push(&layout, REST, LEVEL.base(at(who), [0.25; 3]), &record(&layout, who, at(who)));
        };
        (0..count).for_each(|who| push(&mut block, who));
        let leaving: Vec<usize> = leaving.into_iter().filter(|&p| p < count).collect();
        let mut wanted: Vec<usize> = (0..count).collect();
        // the last ones take the places of those that leave
        let kept = count - leaving.len();
        let mut last = (kept..count).filter(|p| !leaving.contains(p));
        leaving.iter().filter(|&&p| p < kept).for_each(|&p| wanted[p] = last.next().expect("as many"));
        wanted.truncate(kept);
        block.remove(&layout, REST, &leaving);
        (count..count + more).for_each(|who| push(&mut block, who));
        wanted.extend(count..count + more);
        prop_assert_eq!(block.count, wanted.len());
        for (particle, &who) in wanted.iter().enumerate() {
            let expected = record(&layout, who, at(who)).into_iter().map(f64::to_bits).collect::<Vec<_>>();
            prop_assert_eq!(numbers(&layout, &block, particle), expected);
        }
        let nobody: Vec<u64> = layout.inert_record(REST).into_iter().map(f64::to_bits).collect();
        for lane in wanted.len()..wanted.len().next_multiple_of(LANES) {
            prop_assert_eq!(numbers(&layout, &block, lane), nobody.clone());
        }
        Ok(())
    };
    runner(200).run(&(1..100usize, some, 0..20usize), check).unwrap_or_else(|e| panic!("{e}"));
}
