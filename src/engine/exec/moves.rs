//! What moving particles means for one block: who leaves it, and who goes and comes. Blocks are worked on side by side.
use super::traveler::Traveler;
use crate::data::extent::{out_of_reach, outside};
use crate::data::particles::ParticleBlock;
use crate::data::warehouse::{MaterialData, Warehouse};
use grid::Level;
use simd::Isa;

/// Those that are about to leave a block.
pub struct Departure<'a> {
    /// Patch and material of the block, and its position there.
    pub place: [usize; 3],
    /// The block.
    pub block: &'a ParticleBlock,
    /// Their positions in the block.
    pub positions: Vec<usize>,
    /// Those that go to other blocks.
    pub travelers: Vec<Traveler>,
    /// Those that leave the level.
    pub lost: Vec<Traveler>,
}

impl<'a> Departure<'a> {
    /// Nobody yet.
    pub fn new(place: [usize; 3], block: &'a ParticleBlock) -> Self {
        Self { place, block, positions: Vec::new(), travelers: Vec::new(), lost: Vec::new() }
    }

    /// Finds them.
    pub fn find(&mut self, warehouse: &Warehouse, isa: Isa) {
        let ([patch, material, _], block) = (self.place, self.block);
        let (level, data, roles) =
            (&warehouse.level, &warehouse.materials[material], &warehouse.schema.roles);
        let (layout, half) = (&data.layout, data.half_size);
        for particle in block.strays(isa, layout, level, half) {
            let get = |label, component| block.get(layout, label, particle, component);
            let position: [f64; 3] = [0, 1, 2].map(|a| get(roles.position, a));
            let y = level.base(position, half);
            let gone = (0..3).any(|a| outside(level, a, y[a], half[a])) || !level.contains(position);
            if !gone && !(0..3).any(|a| out_of_reach(level, block.index, a, y[a])) {
                continue;
            }
            self.positions.push(particle);
            let identity = get(roles.identity, 0).to_bits();
            let mut record = Vec::with_capacity(layout.total);
            block.read(layout, particle, &mut record);
            let traveler =
                Traveler { from: (block.index, particle), material, patch, identity, position, record };
            match gone || warehouse.home(material, position).is_err() {
                true => self.lost.push(traveler),
                false => self.travelers.push(traveler),
            }
        }
    }
}

/// Those that leave a block and those that come to it.
pub struct Move<'a> {
    /// The grid.
    pub level: &'a Level,
    /// The material.
    pub data: &'a MaterialData,
    /// The block.
    pub block: &'a mut ParticleBlock,
    /// Positions of those that leave, ascending.
    pub leaving: &'a [usize],
    /// Those that come, in the order in which they are taken.
    pub arriving: Vec<&'a Traveler>,
}

impl Move<'_> {
    /// Moves them.
    pub fn carry_out(&mut self) {
        let Self { level, data, block, leaving, arriving } = self;
        let rest = level.middle(block.index);
        if !leaving.is_empty() {
            block.remove(&data.layout, rest, leaving);
        }
        for traveler in arriving {
            block.push(&data.layout, rest, level.base(traveler.position, data.half_size), &traveler.record);
        }
    }
}
