//! What follows from the set of occupied blocks: their order, node blocks, neighbors, and who is near whom.
use super::fields::FieldSet;
use super::layout::NodeLayout;
use super::map::Map;
use super::nearby::Nearby;
use super::nodes::{NOWHERE, NodeBlock, Place, Present};
use super::particles::ParticleBlock;
use super::warehouse::{NodePatch, ParticlePatch, Warehouse};
use grid::{BlockIndex, IndexBox};
use std::collections::HashMap;
use std::ops::Range;

/// The farthest [`Warehouse::sight`].
pub const FARTHEST: i32 = 3;

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
        let homes: Vec<_> = (0..self.materials.len()).map(|m| Map::of_places(indices(m))).collect();
        self.link(&homes);
        self.mark_meeting(&homes);
        self.mark_near();
        self.mark_rim();
        self.reactivate = false;
    }

    /// Marks the blocks whose particles are near others, or near what the application says.
    pub fn mark_near(&mut self) {
        let Self { particles, shared, level, nearby, .. } = self;
        for homes in particles {
            for (material, home) in homes.iter_mut().enumerate() {
                for block in &mut home.blocks {
                    let middle = level.middle(block.index);
                    let beside = |nearby: &Nearby| nearby.is_beside(shared, material, middle);
                    block.near = block.meets || nearby.as_ref().is_some_and(beside);
                }
            }
        }
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
        let Self { decomposition, partition, node_layout, particles, .. } = self;
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
            let block =
                old.remove(&(material, index)).unwrap_or_else(|| ParticleBlock::new(index, node_layout));
            particles[patch][material].blocks.push(block);
        }
        for patch in (0..particles.len()).filter(|&patch| !partition.is_mine(patch)) {
            particles[patch].iter_mut().for_each(|home| home.blocks.sort_by_key(|block| block.index));
        }
    }

    /// Node blocks: wherever a material's occupied block, or a neighbor of one, lies. Of other ranks, those that particles
    /// here read, with all their fields: which labels are there depends on how many there are.
    fn activate_nodes(&mut self, reach: IndexBox) {
        let Self { decomposition, partition, fields, node_layout, particles, nodes, .. } = self;
        let map = || Map::new(reach, FieldSet::words(fields.len()), 0u64);
        let (mut touched, of) = (map(), |material: usize| fields.of(material));
        mark(&mut touched, particles, of, |_| true);
        for patch in partition.mine() {
            let blocks = decomposition.patches[patch].blocks;
            renew(&mut nodes[patch], blocks, [&touched; 2], node_layout);
            nodes[patch].settle(blocks);
        }
        if partition.ranks == 1 {
            return;
        }
        let mut read = map();
        mark(&mut read, particles, of, |patch| partition.is_mine(patch));
        for patch in (0..nodes.len()).filter(|&patch| !partition.is_mine(patch)) {
            let blocks = decomposition.patches[patch].blocks.common(&reach);
            renew(&mut nodes[patch], blocks, [&read, &touched], node_layout);
        }
    }

    /// Neighbor tables between particle and node blocks.
    fn link(&mut self, homes: &[Map<Place>]) {
        let indices = self.nodes.iter().map(|patch| patch.blocks.iter().map(|block| block.index));
        let map = Map::of_places(indices);
        let of_homes: Vec<[isize; 27]> = homes.iter().map(Map::deltas).collect();
        for patch in self.partition.mine() {
            for block in &mut self.nodes[patch].blocks {
                for (around, &field) in block.around.iter_mut().zip(&block.present) {
                    let material = self.fields.material(field);
                    *around = homes[material].around(block.index, &of_homes[material]);
                }
            }
        }
        let deltas = map.deltas();
        for block in self.particles.iter_mut().flatten().flat_map(|home| &mut home.blocks) {
            block.meets = false;
            block.around = map.around(block.index, &deltas);
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

    /// Marks the particle blocks whose particles may share nodes with a material with which theirs interacts: now, or, where
    /// materials have rates of their own, before their own step ends.
    fn mark_meeting(&mut self, homes: &[Map<Place>]) {
        let apart = self.sight();
        let cube = IndexBox { lower: [-apart; 3], upper: [apart + 1; 3] };
        let count = |m: usize| self.particles.iter().map(|patch| patch[m].blocks.len()).sum::<usize>();
        let counts: Vec<usize> = (0..homes.len()).map(count).collect();
        for (m, _) in self.materials.iter().enumerate().filter(|(m, material)| material.interacts[*m]) {
            let blocks = self.particles.iter_mut().flat_map(|patch| &mut patch[m].blocks);
            blocks.for_each(|block| block.meets = true);
        }
        for [a, b] in (0..homes.len()).flat_map(|a| (0..a).map(move |b| [a, b])) {
            if !self.materials[a].interacts[b] {
                continue;
            }
            let (few, many) = if counts[a] <= counts[b] { (a, b) } else { (b, a) };
            let deltas: Vec<isize> = cube.iter().map(|offset| homes[many].delta(offset)).collect();
            for patch in 0..self.particles.len() {
                for position in 0..self.particles[patch][few].blocks.len() {
                    let index = self.particles[patch][few].blocks[position].index;
                    for (patch_of_other, other) in beside(&homes[many], index, (&cube, &deltas)) {
                        self.particles[patch_of_other as usize][many].blocks[other as usize].meets = true;
                        self.particles[patch][few].blocks[position].meets = true;
                    }
                }
            }
        }
    }
}

/// The blocks of a map in a cube around an index, which may lie outside of the map.
fn beside<'a>(
    map: &'a Map<Place>,
    index: BlockIndex,
    (cube, deltas): (&'a IndexBox, &'a [isize]),
) -> impl Iterator<Item = Place> + 'a {
    let inside = map.holds(index, cube.upper[0] - 1).then(|| map.at(index));
    let near = inside.into_iter().flat_map(move |at| deltas.iter().map(move |&delta| map.place(at, delta)));
    let far = inside.is_none().then(|| cube.iter()).into_iter().flatten();
    let far = far.filter_map(move |offset| {
        let at = map.find([0, 1, 2].map(|a| index[a] + offset[a]))?;
        Some(map.place(at, 0))
    });
    near.chain(far).filter(|&place| place != NOWHERE)
}

/// Marks the blocks around the occupied ones of some patches, one bit a field; `of` says which fields a material has.
fn mark(
    touched: &mut Map<u64>,
    particles: &[Vec<ParticlePatch>],
    of: impl Fn(usize) -> Range<usize>,
    wanted: impl Fn(usize) -> bool,
) {
    let deltas = touched.deltas();
    for (_, homes) in particles.iter().enumerate().filter(|(patch, _)| wanted(*patch)) {
        for (material, home) in homes.iter().enumerate() {
            for field in of(material) {
                let (word, bit) = (field / 64, 1 << (field % 64));
                for block in &home.blocks {
                    let at = touched.at(block.index);
                    deltas.iter().for_each(|&d| *touched.word_mut(at.wrapping_add_signed(d), word) |= bit);
                }
            }
        }
    }
}

/// Makes node blocks where something is `wanted`, of the fields that touch them; one that stays as it was keeps its memory.
fn renew(nodes: &mut NodePatch, blocks: IndexBox, [wanted, touched]: [&Map<u64>; 2], layout: &NodeLayout) {
    let fields = |set: &FieldSet<'_>| set.iter().collect::<Present>();
    // both lists are in x-major order
    let mut old = std::mem::take(&mut nodes.blocks).into_iter().peekable();
    let all = blocks.iter().map(|index| (index, touched.at(index)));
    for (index, at) in all.filter(|(_, at)| !FieldSet(wanted.get(*at)).is_empty()) {
        let set = FieldSet(touched.get(at));
        while old.next_if(|block| block.index < index).is_some() {}
        nodes.blocks.push(match old.next_if(|block| block.index == index) {
            Some(block) if set.is(&block.present) => block,
            Some(block) => NodeBlock::succeed(&block, fields(&set), layout),
            None => NodeBlock::new(index, fields(&set), layout),
        });
    }
}
