//! Blocks that are there before particles come into them.
use crate::layouts::{cases, layout, random};
use crate::run::{Layout, warehouse};
use crate::state::{Particle, Start, start};
use crate::toy::*;
use engine::data::activate::FARTHEST;
use engine::data::extent::{NOBODY, include, out_of_reach};
use engine::exec::Serial;
use engine::prelude::*;
use grid::IndexBox;
use std::cell::Cell;

/// As the engine does it once lists were built, on one rank of a layout.
fn ready(start: &Start, layout: &Layout, rank: usize) -> Warehouse {
    let program = program(&start.fields, start.cells, layout.patches.iter().product()).expect("a program");
    let mut warehouse = warehouse(start, layout, &program, rank);
    assert!(!warehouse.is_arranged());
    warehouse.activate(&Serial);
    assert!(warehouse.is_arranged() || warehouse.particle_count() == 0);
    drift(&mut warehouse);
    warehouse.vacate(&Serial);
    warehouse.make_ready(&Serial);
    warehouse.arrange(&Serial);
    warehouse
}

/// Particles drift less than a cell, and stay in the level and in their blocks.
fn drift(warehouse: &mut Warehouse) {
    let Warehouse { level, materials, particles, .. } = warehouse;
    for homes in particles {
        for (home, data) in homes.iter_mut().zip(materials.iter()) {
            for block in &mut home.blocks {
                for (p, axis) in (0..block.count).flat_map(|p| (0..3).map(move |axis| (p, axis))) {
                    let identity = block.get(&data.layout, Identity::ID, p, 0).to_bits();
                    // seven steps of the cell one way and seven the other way
                    let way = ((identity * 3 + axis as u64) * 11 % 15) as f64 / 7.5 - 14.0 / 15.0;
                    let mut x = [0, 1, 2].map(|a| block.get(&data.layout, Position::ID, p, a));
                    x[axis] += level.cell * way;
                    let base = level.base(x, data.half_size)[axis];
                    if level.contains(x) && !out_of_reach(level, block.index, axis, base) {
                        block.set(&data.layout, Position::ID, p, axis, x[axis]);
                    }
                }
                block.extent = NOBODY;
                for p in 0..block.count {
                    let x = [0, 1, 2].map(|a| block.get(&data.layout, Position::ID, p, a));
                    include(&mut block.extent, level.base(x, data.half_size));
                }
            }
        }
    }
}

#[test]
fn whoever_crosses_a_border_soon_finds_a_block() {
    let (crossed, made) = (Cell::new(0), Cell::new(0));
    cases(100, start(), |start| {
        let warehouse = ready(&start, &Layout::alone(), 0);
        made.set(made.get() + warehouse.blocks().filter(|(_, block)| block.count == 0).count());
        for (material, block) in warehouse.blocks() {
            let (level, data) = (&warehouse.level, &warehouse.materials[material]);
            let ways = |p: usize| (0..3).flat_map(move |axis| [-0.12, 0.12].map(|way| (p, axis, way)));
            for (particle, axis, way) in (0..block.count).flat_map(ways) {
                let mut x = [0, 1, 2].map(|a| block.get(&data.layout, Position::ID, particle, a));
                x[axis] += way * level.cell;
                let leaves = out_of_reach(level, block.index, axis, level.base(x, data.half_size)[axis]);
                if leaves && warehouse.home(material, x).is_ok() {
                    assert!(warehouse.is_occupied(material, x), "{:?} to {x:?}", block.index);
                    crossed.set(crossed.get() + 1);
                }
            }
        }
    });
    assert!(crossed.get() > 0 && made.get() > 0, "{crossed:?}, {made:?}");
}

/// Cells of a level along x.
const LONG: usize = 120;

#[test]
fn no_rank_makes_a_block_that_another_one_would_have_to_know_of() {
    let made = Cell::new(0);
    cases(100, (start(), 2..=3usize, random()), |(mut start, ranks, random)| {
        // so long that something is out of sight
        start.particles.iter_mut().for_each(|p| p.x[0] *= LONG as f64 / start.cells[0] as f64);
        start.cells[0] = LONG;
        let layout = layout(&start, ranks, 1, &random);
        for rank in 0..layout.ranks {
            let warehouse = ready(&start, &layout, rank);
            let is_mine = |patch: usize| warehouse.partition.is_mine(patch);
            for (_, block) in warehouse.blocks().filter(|(_, block)| block.count == 0) {
                let near = IndexBox::of(block.index).grown(FARTHEST);
                let owners = near.iter().filter_map(|index| warehouse.decomposition.owner(index));
                owners.for_each(|patch| assert!(is_mine(patch), "{:?}, {layout:?}", block.index));
                made.set(made.get() + 1);
            }
            // nobody is forgotten
            let here = |p: &&Particle| warehouse.home(p.material, p.x).is_ok_and(|(_, patch)| is_mine(patch));
            assert_eq!(warehouse.particle_count(), start.particles.iter().filter(here).count());
        }
    });
    assert!(made.get() > 0);
}
