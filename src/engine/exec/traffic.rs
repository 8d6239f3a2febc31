//! Counts what patches and ranks send each other: from the blocks as they are, nothing is sent.
use super::halo::{back, overlap};
use super::ranks::collective::{self, Act};
use crate::data::activate::FARTHEST;
use crate::data::extent;
use crate::data::nodes::NOWHERE;
use crate::data::particles::ParticleBlock;
use crate::data::warehouse::Warehouse;
use crate::graph::traffic::{Between, Passing, Traffic};
use crate::schema::LabelId;
use grid::{BlockIndex, Decomposition, IndexBox, Partition};
use std::collections::{BTreeMap, BTreeSet};

/// What the patches of an activated warehouse that holds all particles send each other, if `partition` says who is on
/// which rank.
///
/// As `ranks::halos` does it: a particle block sends the lines that its particles can touch (see [`extent::touched`]) to
/// who owns the nodes; the nodes' owner sends back, from each block, a box around those that particles of the receiver
/// touch.
pub fn count(warehouse: &Warehouse, partition: &Partition) -> Traffic {
    let rank_of: Vec<usize> =
        (0..warehouse.decomposition.patches.len()).map(|patch| partition.rank_of(patch)).collect();
    let by_material = |count: &dyn Fn(&ParticleBlock) -> usize| -> Vec<Vec<u64>> {
        let of = |blocks: &[ParticleBlock]| blocks.iter().map(count).sum::<usize>() as u64;
        warehouse.particles.iter().map(|homes| homes.iter().map(|home| of(&home.blocks)).collect()).collect()
    };
    let patch_of = |index| warehouse.decomposition.owner(index).unwrap_or(0);
    let rank_at = |index| rank_of[patch_of(index)];
    Traffic {
        ranks: partition.ranks,
        particles: by_material(&|block| block.count),
        near: by_material(&|block| if block.near { block.count } else { 0 }),
        blocks: by_material(&|_| 1),
        of_material: of_material(warehouse),
        nodes: nodes(warehouse),
        fields: fields(warehouse),
        tiles: warehouse.tiles.clone(),
        between: between(warehouse, patch_of, patch_of),
        to_rank: between(warehouse, patch_of, rank_at),
        neighbors: neighbors(&warehouse.decomposition, &rank_of),
        reduction: reduction(partition.ranks),
        rank_of,
    }
}

/// What the ranks of a partition send each other, each seen as one patch, without what lies on them. The warehouse may be cut
/// into other patches than `decomposition` has.
pub fn between_ranks(warehouse: &Warehouse, decomposition: &Decomposition, partition: &Partition) -> Traffic {
    let rank_of: Vec<usize> =
        (0..decomposition.patches.len()).map(|patch| partition.rank_of(patch)).collect();
    let rank_at = |index| decomposition.owner(index).map_or(0, |patch| rank_of[patch]);
    Traffic {
        ranks: partition.ranks,
        fields: fields(warehouse),
        tiles: warehouse.tiles.clone(),
        to_rank: between(warehouse, rank_at, rank_at),
        neighbors: neighbors(decomposition, &rank_of),
        rank_of: (0..partition.ranks).collect(),
        ..Traffic::default()
    }
}

fn fields(warehouse: &Warehouse) -> Vec<u64> {
    (0..warehouse.materials.len()).map(|material| warehouse.fields.of(material).len() as u64).collect()
}

/// Lines a tile of labels whose tiles materials decide.
fn of_material(warehouse: &Warehouse) -> BTreeMap<(LabelId, usize), u64> {
    let mut lines = BTreeMap::new();
    for (material, data) in warehouse.materials.iter().enumerate() {
        for label in data.layout.labels().filter(|label| label.by_material()) {
            lines.insert((label, material), data.layout.width(label) as u64);
        }
    }
    lines
}

fn nodes(warehouse: &Warehouse) -> Vec<Vec<u64>> {
    let of = |patch: &crate::data::warehouse::NodePatch| {
        let mut counts = vec![0; warehouse.materials.len()];
        let present = patch.blocks.iter().flat_map(|block| &block.present);
        present.for_each(|&field| {
            counts[warehouse.fields.material(field)] += warehouse.node_layout.nodes as u64;
        });
        counts
    };
    warehouse.nodes.iter().map(of).collect()
}

/// What passes from the places of blocks, as `from` says, to receivers, as `to` says.
fn between(
    warehouse: &Warehouse,
    from: impl Fn(BlockIndex) -> usize,
    to: impl Fn(BlockIndex) -> usize,
) -> Between {
    let (shape, materials) = (warehouse.level.shape(), warehouse.materials.len());
    let mut all = Between::new();
    let mut at = |pair, material: usize, change: &dyn Fn(&mut Passing)| {
        change(&mut all.entry(pair).or_insert_with(|| vec![Passing::default(); materials])[material]);
    };
    // the smallest boxes around the nodes of a block that a receiver's particles of a material read, and may read
    let mut read: BTreeMap<((u32, u32), usize, usize), [IndexBox; 2]> = BTreeMap::new();
    let may = IndexBox { lower: [0; 3], upper: shape.buffer };
    let node_block = |place: (u32, u32)| &warehouse.nodes[place.0 as usize].blocks[place.1 as usize];
    for (material, block) in warehouse.blocks() {
        let touched = extent::touched(&block.extent, shape, block.index);
        let mut receivers = BTreeSet::new();
        for (q, &place) in block.around.iter().enumerate().filter(|(_, place)| **place != NOWHERE) {
            let (sender, receiver) = (from(block.index), to(node_block(place).index));
            if receivers.insert(receiver) {
                at((sender, receiver), material, &|passing| passing.adders += 1);
            }
            let nothing = IndexBox { lower: [0; 3], upper: [0; 3] };
            let nodes =
                [touched, may].map(|nodes| overlap(shape, back(q), &nodes).map_or(nothing, |(it, _)| it));
            let near = usize::from(block.near);
            at((sender, receiver), material, &|passing| passing.added[near] += nodes[0].len() as u64);
            let known = read.entry((place, material, to(block.index))).or_insert(nodes);
            for (known, nodes) in known.iter_mut().zip(nodes).filter(|(_, nodes)| !nodes.is_empty()) {
                *known = if known.is_empty() { nodes } else { known.around(&nodes) };
            }
        }
    }
    for ((place, material, reader), nodes) in read {
        let block = node_block(place);
        let (several, [read, whole]) =
            (usize::from(block.present.len() > 1), nodes.map(|it| it.len() as u64));
        at((from(block.index), reader), material, &|passing| {
            passing.read[several] += read;
            passing.whole[several] += whole;
        });
    }
    all
}

/// Pairs of ranks that have blocks in sight of each other, occupied or not.
fn neighbors(decomposition: &Decomposition, rank_of: &[usize]) -> BTreeSet<(usize, usize)> {
    let mut pairs = BTreeSet::new();
    for patch in &decomposition.patches {
        let here = rank_of[patch.id];
        let seen = decomposition.holders(patch.blocks.grown(FARTHEST)).map(|other| rank_of[other]);
        pairs.extend(seen.filter(|there| *there != here).map(|there| (here, there)));
    }
    pairs
}

/// Messages of `ranks::collective::reduce`.
fn reduction(ranks: usize) -> Vec<(usize, usize)> {
    let sent = |rank| {
        collective::acts(rank, ranks).filter_map(move |act| match act {
            Act::Send(to) => Some((rank, to)),
            Act::Merge(_) | Act::Receive(_) => None,
        })
    };
    (0..ranks).flat_map(sent).collect()
}
