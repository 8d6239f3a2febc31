//! The blocks of a scene at its start, and what ranks would do and send with them.
use super::load::{Counts, Listed};
use super::model::Setup;
use super::torus::Brick;
use crate::lab::plan;
use crate::simulation::layout;
use engine::data::extent::{self, MARGIN};
use engine::data::nodes::{NOWHERE, NodeBlock};
use engine::data::particles::ParticleBlock;
use engine::data::warehouse::Warehouse;
use engine::exec::traffic;
use grid::{BlockIndex, Decomposition, IndexBox, Partition};
use scene::Scene;
use std::collections::BTreeMap;

/// The blocks of a scene.
pub struct Footprint {
    /// On one patch, without any data.
    warehouse: Warehouse,
    /// Particles in each block.
    census: Vec<(BlockIndex, u64)>,
}

impl Footprint {
    /// The blocks of a scene, with the nodes that their particles touch once steps have been taken.
    ///
    /// # Errors
    /// A level that holds no patch.
    pub fn of(scene: &Scene) -> Result<Self, String> {
        let mut footprint = Self::at_start(scene)?;
        for block in footprint.warehouse.particles.iter_mut().flatten().flat_map(|home| &mut home.blocks) {
            let smaller = extent::largest(&block.extent).map(|y| y - 2.0 * MARGIN);
            block.extent = extent::from_largest(smaller);
        }
        Ok(footprint)
    }

    /// The same in the first step: the nodes beside a lattice that lies on nodes count too, since nobody has looked yet on
    /// which side its particles are to rounding.
    ///
    /// # Errors
    /// A level that holds no patch.
    pub fn at_start(scene: &Scene) -> Result<Self, String> {
        let warehouse = plan::outline(scene, Decomposition::new(&layout::level(scene), [1; 3])?);
        let mut census = BTreeMap::new();
        for (_, block) in warehouse.blocks() {
            *census.entry(block.index).or_default() += block.count as u64;
        }
        Ok(Self { warehouse, census: census.into_iter().collect() })
    }

    fn nodes(&self) -> &[NodeBlock] {
        &self.warehouse.nodes[0].blocks
    }

    /// Particles by material.
    pub fn particles(&self) -> Vec<f64> {
        let mut counts = vec![0.0; self.warehouse.materials.len()];
        self.warehouse.blocks().for_each(|(material, block)| counts[material] += block.count as f64);
        counts
    }

    /// Blocks of particles.
    pub fn blocks(&self) -> usize {
        self.warehouse.blocks().count()
    }

    /// Blocks of nodes, once for each field.
    pub fn node_blocks(&self) -> f64 {
        self.nodes().iter().map(|block| block.present.len() as f64).sum()
    }

    /// The finest patches, one block each, unless the level has more blocks than patches can be numbered.
    pub fn finest(&self) -> Option<Decomposition> {
        Decomposition::new(&self.warehouse.level, self.warehouse.level.block_columns()).ok()
    }

    /// Patches as a run on so many ranks with so many threads each cuts them.
    pub fn usual(&self, ranks: usize, threads: usize) -> Decomposition {
        Decomposition::automatic(&self.warehouse.level, 8 * ranks * threads, ranks, &self.census)
    }

    /// Blocks that hold particles.
    pub fn occupied_blocks(&self) -> usize {
        self.census.len()
    }

    /// Patches that hold particles.
    pub fn occupied(&self, patches: &Decomposition) -> usize {
        patches.loads(&self.census).into_iter().filter(|load| *load > 0).count()
    }

    /// A brick with the mean of all blocks.
    pub fn brick(&self, patches: f64) -> Brick {
        let (all, materials) = (&self.warehouse, self.warehouse.materials.len());
        let particles = self.particles();
        let sum = particles.iter().sum::<f64>().max(1.0);
        let mean = |of: &dyn Fn(usize, &ParticleBlock) -> f64| {
            all.blocks().map(|(material, block)| block.count as f64 * of(material, block)).sum::<f64>() / sum
        };
        let axes = |of: &dyn Fn(&IndexBox, usize) -> i32| {
            mean(&|_, block| {
                let touched = extent::touched(&block.extent, all.level.shape(), block.index);
                (0..3).map(|a| f64::from(of(&touched, a).max(0))).sum::<f64>() / 3.0
            })
        };
        // a buffer begins one node below its block
        let below = axes(&|touched, a| 1 - touched.lower[a]);
        let above = axes(&|touched, a| touched.upper[a] - 5);
        let share = |of: usize, near| {
            mean(&|material, block| f64::from(u8::from((material, block.near) == (of, near))))
        };
        let parts = (0..materials).map(|m| [share(m, false), share(m, true)]).collect();
        let [counts] = &self.counts(|_| 0, 1)[..] else { return Brick::default() };
        let both = |pair: &[f64; 2]| pair[0] + pair[1];
        let blocks = counts.blocks.iter().map(both).collect();
        let nodes = counts.nodes.iter().map(|(fields, pair)| (fields.clone(), both(pair))).collect();
        let fields = (0..materials).map(|m| all.fields.of(m).len()).collect();
        Brick { particles, blocks, nodes, reach: [below, above], fields, parts, patches }
    }

    /// What ranks do and send if they share `patches`.
    ///
    /// # Errors
    /// Fewer patches than ranks.
    pub fn ranks(&self, patches: &Decomposition, ranks: usize, setup: &Setup<'_>) -> Result<Listed, String> {
        let partition = Partition::by_cost(patches, &patches.loads(&self.census), 0, ranks)?;
        let rank_of = |index| patches.owner(index).map_or(0, |patch| partition.rank_of(patch));
        let mut counts = self.counts(rank_of, ranks);
        (0..patches.patches.len()).for_each(|patch| counts[partition.rank_of(patch)].patches += 1.0);
        let traffic = traffic::between_ranks(&self.warehouse, patches, &partition);
        Ok(Listed::new(&counts, &traffic, setup))
    }

    /// Rim and interior as `data::activate` marks them.
    fn counts(&self, rank_of: impl Fn(BlockIndex) -> usize, ranks: usize) -> Vec<Counts> {
        let (nodes, fields) = (self.nodes(), &self.warehouse.fields);
        let homes: Vec<usize> = nodes.iter().map(|block| rank_of(block.index)).collect();
        // on the one patch
        let around = |block: &ParticleBlock| {
            let there = block.around.into_iter().filter(|place| *place != NOWHERE);
            there.map(|(_, at)| at as usize)
        };
        let mut waits = vec![false; nodes.len()];
        for (_, block) in self.warehouse.blocks() {
            let home = rank_of(block.index);
            around(block).filter(|&node| homes[node] != home).for_each(|node| waits[node] = true);
        }
        let none = vec![[0.0; 2]; self.warehouse.materials.len()];
        let empty = Counts { particles: none.clone(), blocks: none, ..Counts::default() };
        let mut counts = vec![empty; ranks];
        for ((rank, waits), block) in homes.iter().zip(&waits).zip(nodes) {
            let of: Vec<usize> = block.present.iter().map(|&field| fields.material(field)).collect();
            let known = &mut counts[*rank].nodes;
            let at = known.iter().position(|(other, _)| *other == of).unwrap_or_else(|| {
                known.push((of, [0.0; 2]));
                known.len() - 1
            });
            known[at].1[usize::from(!waits)] += 1.0;
        }
        for (material, block) in self.warehouse.blocks() {
            let home = rank_of(block.index);
            let rim = around(block).any(|node| homes[node] != home || waits[node]);
            let part = usize::from(!rim);
            counts[home].particles[material][part] += block.count as f64;
            counts[home].blocks[material][part] += 1.0;
        }
        counts
    }
}
