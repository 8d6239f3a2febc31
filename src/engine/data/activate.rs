//! What follows from the set of occupied blocks: their order, node blocks, neighbors, and who is near whom.
use super::fields::FieldSet;
use super::layout::NodeLayout;
use super::map::Map;
use super::nearby::Nearby;
use super::nodes::{NOWHERE, NodeBlock, Place, Present};
use super::particles::ParticleBlock;
use super::spread::{Spread, each_of, many};
use super::warehouse::{NodePatch, ParticlePatch, Warehouse};
use grid::{BlockIndex, IndexBox};
use std::collections::HashMap;
use std::ops::Range;

/// The farthest [`Warehouse::sight`].
pub const FARTHEST: i32 = 3;

impl Warehouse {
    /// Drops empty blocks, and rebuilds what follows from the set of the others. [`Warehouse::set_beyond`] comes before it.
    pub fn activate(&mut self, spread: &dyn Spread) {
        self.vacate(spread);
        self.arrange(spread);
    }

    /// Drops empty blocks.
    pub fn vacate(&mut self, spread: &dyn Spread) {
        each_of(spread, &mut self.homes_mut(), 1, |home| home.vacate());
    }

    /// The blocks of this rank's patches.
    fn homes_mut(&mut self) -> Vec<&mut ParticlePatch> {
        let Self { partition, particles, .. } = self;
        let mine = particles.iter_mut().enumerate().filter(|(patch, _)| partition.is_mine(*patch));
        mine.flat_map(|(_, homes)| homes).collect()
    }

    /// Rebuilds what follows from the set of blocks.
    pub fn arrange(&mut self, spread: &dyn Spread) {
        let shape = self.level.shape();
        each_of(spread, &mut self.homes_mut(), 1, |home| home.settle(shape));
        self.activate_nodes(spread);
        let indices = |m: usize| {
            let homes = self.particles.iter().map(move |patch| &patch[m].blocks);
            homes.map(|blocks| blocks.iter().map(|block| block.index))
        };
        let mut homes: Vec<_> = self.materials.iter().map(|_| Map::new(1, NOWHERE)).collect();
        let mut numbered: Vec<_> = homes.iter_mut().enumerate().collect();
        each_of(spread, &mut numbered, 1, |(m, home)| **home = Map::of_places(indices(*m)));
        self.link(&homes, spread);
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

    /// Notes the occupied blocks of other ranks in sight of this one's, each a material and an index, in any order. Those
    /// known before keep what they gave to nodes.
    pub fn set_beyond(&mut self, occupied: impl Iterator<Item = (usize, BlockIndex)>) {
        let Self { level, decomposition, partition, node_layout, particles, .. } = self;
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
            particles[patch].iter_mut().for_each(|home| {
                home.blocks.sort_by_key(|block| block.index);
                home.note_briefs(level.shape());
            });
        }
    }

    /// Node blocks: wherever a material's occupied block, or a neighbor of one, lies. Of other ranks, those that particles
    /// here read, with all their fields: which labels are there depends on how many there are.
    fn activate_nodes(&mut self, spread: &dyn Spread) {
        let Self { decomposition, partition, fields, node_layout, particles, nodes, .. } = self;
        let map = || Map::new(FieldSet::words(fields.len()), 0u64);
        let (mut touched, of) = (map(), |material: usize| fields.of(material));
        mark(&mut touched, particles, of, |_| true);
        let mut read = map();
        if partition.ranks > 1 {
            mark(&mut read, particles, of, |patch| partition.is_mine(patch));
        }
        // of this rank's patches all that is touched, of others' what is read here
        let owner = |index: BlockIndex| decomposition.owner(index);
        let mine = touched.set().filter_map(|(index, words)| Some((owner(index)?, (index, words))));
        let mut lists: Vec<Vec<(BlockIndex, &[u64])>> = vec![Vec::new(); nodes.len()];
        mine.filter(|(patch, _)| partition.is_mine(*patch))
            .for_each(|(patch, block)| lists[patch].push(block));
        for (index, _) in read.set() {
            if let (Some(patch), Some(words)) = (owner(index), touched.get(index))
                && !partition.is_mine(patch)
            {
                lists[patch].push((index, words));
            }
        }
        let mut patches: Vec<_> = nodes.iter_mut().zip(lists).enumerate().collect();
        each_of(spread, &mut patches, 1, |(patch, (nodes, list))| {
            list.sort_unstable_by_key(|(index, _)| *index);
            renew(nodes, list, node_layout);
            if partition.is_mine(*patch) {
                nodes.settle();
            }
        });
    }

    /// Neighbor tables between particle and node blocks.
    fn link(&mut self, homes: &[Map<Place>], spread: &dyn Spread) {
        let Self { partition, fields, particles, nodes, .. } = self;
        let map = Map::of_places(nodes.iter().map(|patch| patch.blocks.iter().map(|block| block.index)));
        let mine = nodes.iter_mut().enumerate().filter(|(patch, _)| partition.is_mine(*patch));
        let mut blocks: Vec<&mut NodeBlock> = mine.flat_map(|(_, patch)| &mut patch.blocks).collect();
        many(spread, &mut blocks, |block| {
            for (around, &field) in block.around.iter_mut().zip(&block.present) {
                *around = homes[fields.material(field)].around(block.index);
            }
        });
        let mut blocks: Vec<&mut ParticleBlock> =
            particles.iter_mut().flatten().flat_map(|home| &mut home.blocks).collect();
        many(spread, &mut blocks, |block| {
            block.meets = false;
            block.around = map.around(block.index);
        });
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
        let cube = |index: BlockIndex| IndexBox::of(index).grown(apart);
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
            for patch in 0..self.particles.len() {
                for position in 0..self.particles[patch][few].blocks.len() {
                    let index = self.particles[patch][few].blocks[position].index;
                    for (patch_of_other, other) in homes[many].inside(cube(index)) {
                        self.particles[patch_of_other as usize][many].blocks[other as usize].meets = true;
                        self.particles[patch][few].blocks[position].meets = true;
                    }
                }
            }
        }
    }
}

/// Marks the blocks around the occupied ones of some patches, one bit a field; `of` says which fields a material has.
fn mark(
    touched: &mut Map<u64>,
    particles: &[Vec<ParticlePatch>],
    of: impl Fn(usize) -> Range<usize>,
    wanted: impl Fn(usize) -> bool,
) {
    for (_, homes) in particles.iter().enumerate().filter(|(patch, _)| wanted(*patch)) {
        for (material, home) in homes.iter().enumerate() {
            for block in &home.blocks {
                for place in touched.places_around(block.index) {
                    let words = touched.words_mut(place);
                    of(material).for_each(|field| words[field / 64] |= 1 << (field % 64));
                }
            }
        }
    }
}

/// Makes node blocks of a patch where a list says, which is in x-major order, of the fields that touch them; one that stays as it
/// was keeps its memory.
fn renew(nodes: &mut NodePatch, list: &[(BlockIndex, &[u64])], layout: &NodeLayout) {
    let fields = |set: &FieldSet<'_>| set.iter().collect::<Present>();
    let mut old = std::mem::take(&mut nodes.blocks).into_iter().peekable();
    for &(index, words) in list {
        let set = FieldSet(words);
        while old.next_if(|block| block.index < index).is_some() {}
        nodes.blocks.push(match old.next_if(|block| block.index == index) {
            Some(block) if set.is(&block.present) => block,
            Some(block) => NodeBlock::succeed(&block, fields(&set), layout),
            None => NodeBlock::new(index, fields(&set), layout),
        });
    }
}
