//! What follows from the set of occupied blocks: their order, node blocks, neighbors, and who is near whom.
use super::nodes::{NOWHERE, NodeBlock};
use super::particles::ParticleBlock;
use super::warehouse::{NodePatch, ParticlePatch, Warehouse};
use crate::grid::{BlockIndex, IndexBox, around};
use std::collections::HashMap;

/// Layers around the level that maps hold, so that no neighbor is outside of them.
const PADDING: i32 = 3;
/// The farthest [`Warehouse::sight`].
pub const FARTHEST: i32 = 3;

/// Patch and position of a block, or `NOWHERE`.
type Place = (u32, u32);

/// Something for each block of the level, and of some layers around it.
struct Map<T> {
    bounds: IndexBox,
    strides: [isize; 3],
    cells: Vec<T>,
}

impl<T: Copy> Map<T> {
    fn new(level: IndexBox, value: T) -> Self {
        let bounds = level.grown(PADDING);
        let [_, ny, nz] = bounds.size().map(|n| n as isize);
        Self { bounds, strides: [ny * nz, nz, 1], cells: vec![value; bounds.len()] }
    }

    /// Where a block of the level is.
    fn at(&self, index: BlockIndex) -> usize {
        self.delta([0, 1, 2].map(|a| index[a] - self.bounds.lower[a])) as usize
    }

    /// From a block to the one at `offset`.
    fn delta(&self, offset: [i32; 3]) -> isize {
        (0..3).map(|a| offset[a] as isize * self.strides[a]).sum()
    }

    /// From a block to those around it.
    fn deltas(&self) -> [isize; 27] {
        let mut deltas = [0; 27];
        deltas.iter_mut().zip(around()).for_each(|(delta, offset)| *delta = self.delta(offset));
        deltas
    }
}

/// Where all blocks are, from the indices of each patch's blocks in their order.
fn places<I: Iterator<Item = BlockIndex>>(level: IndexBox, patches: impl Iterator<Item = I>) -> Map<Place> {
    let mut map = Map::new(level, NOWHERE);
    for (patch, indices) in (0..).zip(patches) {
        for (position, index) in (0..).zip(indices) {
            let at = map.at(index);
            map.cells[at] = (patch, position);
        }
    }
    map
}

impl Warehouse {
    /// Rebuilds what follows from the set of occupied blocks. [`Warehouse::set_beyond`] comes before it.
    pub fn activate(&mut self) {
        for patch in self.partition.mine() {
            let blocks = self.decomposition.patches[patch].blocks;
            self.particles[patch].iter_mut().for_each(|home| home.settle(blocks));
        }
        let reach = self.reach();
        self.activate_nodes(reach);
        let indices = |m: usize| {
            let homes = self.particles.iter().map(move |patch| &patch[m].blocks);
            homes.map(|blocks| blocks.iter().map(|block| block.index))
        };
        let homes: Vec<_> = (0..self.materials.len()).map(|m| places(reach, indices(m))).collect();
        self.link(reach, &homes);
        self.mark_near(&homes);
        self.mark_rim();
        self.stale = false;
    }

    /// How far blocks count: particles of two materials may meet at nodes if their blocks are two apart, and one more
    /// where a material moves while another waits.
    pub fn sight(&self) -> i32 {
        if self.own_rates { FARTHEST } else { FARTHEST - 1 }
    }

    /// A box around all blocks that this rank knows.
    fn reach(&self) -> IndexBox {
        let mut boxes = self.partition.mine().map(|patch| self.decomposition.patches[patch].blocks);
        let first = boxes.next().unwrap_or(IndexBox { lower: [0; 3], upper: [0; 3] });
        let all = boxes.fold(first, |a, b| a.around(&b));
        if self.partition.ranks == 1 { all } else { all.grown(self.sight()) }
    }

    /// Notes the occupied blocks of other ranks in sight of this one's, each a material and an index, in any order. Those
    /// known before keep what they gave to nodes.
    pub fn set_beyond(&mut self, occupied: impl Iterator<Item = (usize, BlockIndex)>) {
        let Self { decomposition, partition, particles, .. } = self;
        let mut old: HashMap<(usize, BlockIndex), ParticleBlock> = HashMap::new();
        for patch in (0..particles.len()).filter(|&patch| !partition.is_mine(patch)) {
            for (material, home) in particles[patch].iter_mut().enumerate() {
                old.extend(home.blocks.drain(..).map(|block| ((material, block.index), block)));
            }
        }
        for (material, index) in occupied {
            let Some(patch) = decomposition.owner(index).filter(|&patch| !partition.is_mine(patch)) else {
                continue;
            };
            let block = old.remove(&(material, index)).unwrap_or_else(|| ParticleBlock::new(index));
            particles[patch][material].blocks.push(block);
        }
        for patch in (0..particles.len()).filter(|&patch| !partition.is_mine(patch)) {
            particles[patch].iter_mut().for_each(|home| home.blocks.sort_by_key(|block| block.index));
        }
    }

    /// Node blocks: wherever a material's occupied block, or a neighbor of one, lies. Of other ranks, those that particles
    /// here read.
    fn activate_nodes(&mut self, reach: IndexBox) {
        let Self { decomposition, partition, particles, nodes, .. } = self;
        let mut touched = Map::new(reach, 0u64);
        mark(&mut touched, particles, |patch| partition.is_mine(patch));
        for patch in (0..nodes.len()).filter(|&patch| !partition.is_mine(patch)) {
            renew(&mut nodes[patch], decomposition.patches[patch].blocks.common(&reach), &touched);
        }
        mark(&mut touched, particles, |patch| !partition.is_mine(patch));
        for patch in partition.mine() {
            let blocks = decomposition.patches[patch].blocks;
            renew(&mut nodes[patch], blocks, &touched);
            nodes[patch].settle(blocks);
        }
    }

    /// Neighbor tables between particle and node blocks.
    fn link(&mut self, reach: IndexBox, homes: &[Map<Place>]) {
        let indices = self.nodes.iter().map(|patch| patch.blocks.iter().map(|block| block.index));
        let map = places(reach, indices);
        let deltas = map.deltas();
        let neighbors = |map: &Map<Place>, index| {
            let at = map.at(index);
            deltas.map(|delta| map.cells[at.wrapping_add_signed(delta)])
        };
        for patch in self.partition.mine() {
            for block in &mut self.nodes[patch].blocks {
                for (around, &material) in block.around.iter_mut().zip(&block.present) {
                    *around = neighbors(&homes[material as usize], block.index);
                }
            }
        }
        for block in self.particles.iter_mut().flatten().flat_map(|home| &mut home.blocks) {
            block.near = false;
            block.around = neighbors(&map, block.index);
        }
    }

    /// Marks the node blocks that wait for what other ranks give, and the particle blocks that give to those, or to nodes
    /// of other ranks.
    fn mark_rim(&mut self) {
        let Self { partition, particles, nodes, .. } = self;
        let beyond = |place: &Place| *place != NOWHERE && !partition.is_mine(place.0 as usize);
        for patch in partition.mine() {
            for block in &mut nodes[patch].blocks {
                block.rim = block.around.iter().flatten().any(beyond);
            }
        }
        for patch in partition.mine() {
            for block in particles[patch].iter_mut().flat_map(|home| &mut home.blocks) {
                let mut around = block.around.iter().filter(|place| **place != NOWHERE);
                let waits = |&(patch, at): &Place| nodes[patch as usize].blocks[at as usize].rim;
                block.rim = around.any(|place| beyond(place) || waits(place));
            }
        }
    }

    /// Marks the particle blocks whose particles may share nodes with a contacting material: now, or, where materials
    /// have rates of their own, before their own step ends.
    fn mark_near(&mut self, homes: &[Map<Place>]) {
        let apart = self.sight();
        let cube = IndexBox { lower: [-apart; 3], upper: [apart + 1; 3] };
        let count = |m: usize| self.particles.iter().map(|patch| patch[m].blocks.len()).sum::<usize>();
        let counts: Vec<usize> = (0..homes.len()).map(count).collect();
        for [a, b] in (0..homes.len()).flat_map(|a| (0..a).map(move |b| [a, b])) {
            if !self.materials[a].contacts[b] {
                continue;
            }
            let (few, many) = if counts[a] <= counts[b] { (a, b) } else { (b, a) };
            let deltas: Vec<isize> = cube.iter().map(|offset| homes[many].delta(offset)).collect();
            for patch in 0..self.particles.len() {
                for position in 0..self.particles[patch][few].blocks.len() {
                    let at = homes[many].at(self.particles[patch][few].blocks[position].index);
                    let others = deltas.iter().map(|&delta| homes[many].cells[at.wrapping_add_signed(delta)]);
                    for (patch_of_other, other) in others.filter(|&place| place != NOWHERE) {
                        self.particles[patch_of_other as usize][many].blocks[other as usize].near = true;
                        self.particles[patch][few].blocks[position].near = true;
                    }
                }
            }
        }
    }
}

/// Marks the blocks around the occupied ones of some patches, one bit a material.
fn mark(touched: &mut Map<u64>, particles: &[Vec<ParticlePatch>], wanted: impl Fn(usize) -> bool) {
    let deltas = touched.deltas();
    for (_, homes) in particles.iter().enumerate().filter(|(patch, _)| wanted(*patch)) {
        for (material, home) in homes.iter().enumerate() {
            for block in &home.blocks {
                let at = touched.at(block.index);
                deltas.iter().for_each(|&d| touched.cells[at.wrapping_add_signed(d)] |= 1 << material);
            }
        }
    }
}

/// Makes node blocks where `touched` says so; one that stays as it was keeps its memory.
fn renew(nodes: &mut NodePatch, blocks: IndexBox, touched: &Map<u64>) {
    let materials = |bits: u64| (0..64).filter(|m| bits >> m & 1 == 1).collect::<Vec<u8>>();
    // both lists are in x-major order
    let mut old = std::mem::take(&mut nodes.blocks).into_iter().peekable();
    let all = blocks.iter().map(|index| (index, touched.cells[touched.at(index)]));
    for (index, bits) in all.filter(|&(_, bits)| bits != 0) {
        while old.next_if(|block| block.index < index).is_some() {}
        nodes.blocks.push(match old.next_if(|block| block.index == index) {
            Some(block) if block.bits() == bits => block,
            Some(block) => NodeBlock::succeed(&block, materials(bits)),
            None => NodeBlock::new(index, materials(bits)),
        });
    }
}
