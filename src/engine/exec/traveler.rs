//! Particles on their way to other blocks, and those that have left the level, also as words of messages.
use crate::data::warehouse::MaterialData;
use crate::schema::LabelId;
use grid::BlockIndex;

/// A particle on its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Traveler {
    /// Block and position that it left: arrivals are taken in this order, whatever the patches are.
    pub from: (BlockIndex, usize),
    /// Its material.
    pub material: usize,
    /// Its patch before it left.
    pub patch: usize,
    /// Its identity.
    pub identity: u64,
    /// Where it is [m].
    pub position: [f64; 3],
    /// All its numbers, label after label.
    pub record: Vec<f64>,
}

impl Traveler {
    /// Words before the record.
    const HEAD: usize = 10;

    /// Its numbers of a label.
    pub fn numbers(&self, materials: &[MaterialData], label: LabelId) -> &[f64] {
        let layout = &materials[self.material].layout;
        &self.record[layout.starts[label.index()]..][..layout.width(label)]
    }

    /// Its numbers of a label, to write. Its place is [`Traveler::position`], too.
    pub fn numbers_mut(&mut self, materials: &[MaterialData], label: LabelId) -> &mut [f64] {
        let layout = &materials[self.material].layout;
        &mut self.record[layout.starts[label.index()]..][..layout.width(label)]
    }

    /// Appends it to a message.
    pub fn write(&self, words: &mut Vec<u64>) {
        let (block, place) = self.from;
        words.extend([self.material as u64, self.patch as u64, self.identity]);
        words.extend(self.position.map(f64::to_bits));
        words.extend(block.map(|i| i as u32 as u64));
        words.push(place as u64);
        words.extend(self.record.iter().map(|x| x.to_bits()));
    }

    /// Takes one from the beginning of a message; `None` at its end.
    pub fn read(words: &mut &[u64], materials: &[MaterialData]) -> Option<Self> {
        let (head, rest) = words.split_first_chunk::<{ Self::HEAD }>()?;
        let &[material, patch, identity, x, y, z, bx, by, bz, place] = head;
        let material = material as usize;
        let (record, rest) = rest.split_at_checked(materials.get(material)?.layout.total)?;
        *words = rest;
        let block = [bx, by, bz].map(|i| i as u32 as i32);
        let record = record.iter().map(|&bits| f64::from_bits(bits)).collect();
        let position = [x, y, z].map(f64::from_bits);
        let (from, patch) = ((block, place as usize), patch as usize);
        Some(Self { from, material, patch, identity, position, record })
    }
}
