//! What follows from the set of occupied blocks: their order, node blocks, neighbors, and who is near whom.
use super::nodes::{NOWHERE, NodeBlock};
use super::warehouse::{NodePatch, ParticlePatch, Warehouse};
use crate::grid::{BlockIndex, Decomposition, IndexBox, around};

/// Layers around the level that maps hold, so that no neighbor is outside of them.
const PADDING: i32 = 3;

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
    /// Rebuilds what follows from the set of occupied blocks.
    pub fn activate(&mut self) {
        let level = self.level.blocks();
        for (patch, homes) in self.decomposition.patches.iter().zip(&mut self.particles) {
            homes.iter_mut().for_each(|home| home.settle(patch.blocks));
        }
        activate_nodes(level, &self.decomposition, &self.particles, &mut self.nodes);
        let indices = |m: usize| {
            let homes = self.particles.iter().map(move |patch| &patch[m].blocks);
            homes.map(|blocks| blocks.iter().map(|block| block.index))
        };
        let homes: Vec<_> = (0..self.materials.len()).map(|m| places(level, indices(m))).collect();
        self.link(&homes);
        self.mark_near(&homes);
        self.stale = false;
    }

    /// Neighbor tables between particle and node blocks.
    fn link(&mut self, homes: &[Map<Place>]) {
        let indices = self.nodes.iter().map(|patch| patch.blocks.iter().map(|block| block.index));
        let map = places(self.level.blocks(), indices);
        let deltas = map.deltas();
        let neighbors = |map: &Map<Place>, index| {
            let at = map.at(index);
            deltas.map(|delta| map.cells[at.wrapping_add_signed(delta)])
        };
        for block in self.nodes.iter_mut().flat_map(|patch| &mut patch.blocks) {
            for (around, &material) in block.around.iter_mut().zip(&block.present) {
                *around = neighbors(&homes[material as usize], block.index);
            }
        }
        for block in self.particles.iter_mut().flatten().flat_map(|home| &mut home.blocks) {
            block.near = false;
            block.around = neighbors(&map, block.index);
        }
    }

    /// Marks the particle blocks whose particles may share nodes with a contacting material: now, or, where materials
    /// have rates of their own, before their own step ends.
    fn mark_near(&mut self, homes: &[Map<Place>]) {
        // two blocks share a node block if they are at most two apart; in a step a particle enters the next one at most
        let apart = if self.own_rates { 3 } else { 2 };
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

/// Node blocks: wherever a material's occupied block, or a neighbor of one, lies.
fn activate_nodes(
    level: IndexBox,
    decomposition: &Decomposition,
    particles: &[Vec<ParticlePatch>],
    nodes: &mut [NodePatch],
) {
    let mut touched = Map::new(level, 0u64);
    let deltas = touched.deltas();
    for (material, home) in particles.iter().flat_map(|patch| patch.iter().enumerate()) {
        for block in &home.blocks {
            let at = touched.at(block.index);
            deltas.iter().for_each(|&d| touched.cells[at.wrapping_add_signed(d)] |= 1 << material);
        }
    }
    let materials = |bits: u64| (0..64).filter(|m| bits >> m & 1 == 1).collect::<Vec<u8>>();
    for (patch, nodes) in decomposition.patches.iter().zip(nodes) {
        // both lists are in x-major order: a block that stays as it was keeps its memory
        let mut old = std::mem::take(&mut nodes.blocks).into_iter().peekable();
        let all = patch.blocks.iter().map(|index| (index, touched.cells[touched.at(index)]));
        for (index, bits) in all.filter(|&(_, bits)| bits != 0) {
            while old.next_if(|block| block.index < index).is_some() {}
            nodes.blocks.push(match old.next_if(|block| block.index == index) {
                Some(block) if block.bits() == bits => block,
                Some(block) => NodeBlock::succeed(&block, materials(bits)),
                None => NodeBlock::new(index, materials(bits)),
            });
        }
        nodes.settle(patch.blocks);
    }
}
