//! Particles on their way to other blocks, and those that have left the level, also as words of messages.
use crate::data::exact_sum::ExactSum;
use crate::data::labels::LabelId;
use crate::data::warehouse::{MaterialData, Warehouse};
use crate::grid::BlockIndex;

/// A particle on its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Traveler {
    /// Block and position that it left: arrivals are taken in this order, whatever the patches are.
    pub from: (BlockIndex, usize),
    /// Who.
    pub who: Left,
    /// All its numbers, label after label.
    pub record: Vec<f64>,
}

/// A particle that is no longer in the level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// Its material.
    pub material: usize,
    /// Its patch before it left.
    pub patch: usize,
    /// Its identity.
    pub identity: u64,
    /// Where it is [m].
    pub position: [f64; 3],
    /// How it moves [m/s].
    pub velocity: [f64; 3],
    /// Its mass [kg].
    pub mass: f64,
}

impl Traveler {
    /// Mirrors position and velocity at the faces of the level behind which the particle is, and books what the faces give
    /// it; returns whether it is in the level then.
    pub fn reflect(&mut self, warehouse: &mut Warehouse) -> bool {
        let (lower, upper) = (warehouse.level.lower, warehouse.level.upper());
        let starts = warehouse.materials[self.who.material].layout.starts;
        let boundary = warehouse.shared.column_mut(LabelId::BoundaryWork);
        let sums: &mut [ExactSum] = bytemuck::cast_slice_mut(boundary);
        for axis in 0..3 {
            let (x, v) = (&mut self.who.position[axis], &mut self.who.velocity[axis]);
            let (low, high) = (lower[axis], upper[axis]);
            if *x < low || *x > high {
                let face = if *x < low { low } else { high };
                *x = (2.0 * face - *x).clamp(low, high);
                sums[1 + axis].add(-2.0 * self.who.mass * *v);
                *v = -*v;
            }
            self.record[starts[LabelId::Position as usize] + axis] = *x;
            self.record[starts[LabelId::Velocity as usize] + axis] = *v;
        }
        warehouse.home(self.who.material, self.who.position).is_ok()
    }

    /// Words before the record.
    const HEAD: usize = 4 + Left::WORDS;

    /// Appends it to a message.
    pub fn write(&self, words: &mut Vec<u64>) {
        let (block, position) = self.from;
        self.who.write(words);
        words.extend(block.map(|i| i as u32 as u64));
        words.push(position as u64);
        words.extend(self.record.iter().map(|x| x.to_bits()));
    }

    /// Takes one from the beginning of a message; `None` at its end.
    pub fn read(words: &mut &[u64], materials: &[MaterialData]) -> Option<Self> {
        let (head, rest) = words.split_at_checked(Self::HEAD)?;
        let who = Left::read(&head[..Left::WORDS])?;
        let (record, rest) = rest.split_at_checked(materials.get(who.material)?.layout.total)?;
        *words = rest;
        let from = &head[Left::WORDS..];
        let block = [0, 1, 2].map(|a| from[a] as u32 as i32);
        let record = record.iter().map(|&bits| f64::from_bits(bits)).collect();
        Some(Self { from: (block, from[3] as usize), who, record })
    }
}

impl Left {
    /// Words of a message.
    pub const WORDS: usize = 10;

    /// Appends it to a message.
    pub fn write(&self, words: &mut Vec<u64>) {
        words.extend([self.material as u64, self.patch as u64, self.identity, self.mass.to_bits()]);
        words.extend(self.position.iter().chain(&self.velocity).map(|x| x.to_bits()));
    }

    /// From its words; `None` if they are not as many.
    pub fn read(words: &[u64]) -> Option<Self> {
        let &[material, patch, identity, mass, x, y, z, u, v, w] = words else { return None };
        Some(Self {
            material: material as usize,
            patch: patch as usize,
            identity,
            position: [x, y, z].map(f64::from_bits),
            velocity: [u, v, w].map(f64::from_bits),
            mass: f64::from_bits(mass),
        })
    }
}
