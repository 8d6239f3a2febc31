//! Counts what patches and ranks send each other: from the blocks as they are, nothing is sent.
use super::halo::{back, overlap};
use super::ranks::collective::{self, Act};
use super::ranks::occupied::beside;
use crate::data::extent;
use crate::data::nodes::{NOWHERE, is_there};
use crate::data::particles::ParticleBlock;
use crate::data::warehouse::Warehouse;
use crate::graph::traffic::{Lines, Traffic};
use crate::schema::{Crossing, LabelId};
use grid::{Decomposition, IndexBox, Partition};
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
    Traffic {
        ranks: partition.ranks,
        particles: by_material(&|block| block.count),
        near: by_material(&|block| if block.near { block.count } else { 0 }),
        blocks: by_material(&|_| 1),
        of_material: of_material(warehouse),
        nodes: nodes(warehouse),
        between: between(warehouse, |patch| patch, false),
        to_rank: between(warehouse, |patch| rank_of[patch], false),
        whole: between(warehouse, |patch| rank_of[patch], true),
        adders: adders(warehouse, &rank_of),
        neighbors: neighbors(&warehouse.decomposition, &rank_of, partition.ranks),
        reduction: reduction(partition.ranks),
        rank_of,
    }
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

/// Lines from each patch to each receiver, where patch p belongs to receiver `part(p)`; if `whole`, of all nodes that
/// particles may touch.
fn between(
    warehouse: &Warehouse,
    part: impl Fn(usize) -> usize,
    whole: bool,
) -> BTreeMap<(usize, usize), Lines> {
    let mut all: BTreeMap<(usize, usize), Lines> = BTreeMap::new();
    let mut add = |from, to, label, material, lines: usize| {
        *all.entry((from, to)).or_default().entry((label, material)).or_default() += lines as u64;
    };
    let shape = warehouse.level.shape();
    let labels = |partial: bool| {
        let crosses = move |label: &LabelId| match label.crossing() {
            Crossing::None => false,
            Crossing::Partials(_) => partial,
            Crossing::Values(_) => !partial,
        };
        warehouse.schema.labels().filter(crosses)
    };
    let fields = |material| warehouse.fields.of(material).len();
    // the smallest box around the nodes of a block that a receiver's particles of a material read
    let mut read: BTreeMap<((u32, u32), usize, usize), IndexBox> = BTreeMap::new();
    for (patch, homes) in warehouse.particles.iter().enumerate() {
        for (material, block) in
            homes.iter().enumerate().flat_map(|(m, home)| home.blocks.iter().map(move |b| (m, b)))
        {
            let touched = match whole {
                true => IndexBox { lower: [0; 3], upper: shape.buffer },
                false => extent::touched(&block.extent, &warehouse.level, block.index),
            };
            for (q, &place) in block.around.iter().enumerate().filter(|(_, place)| **place != NOWHERE) {
                let Some((nodes, _)) = overlap(&shape, back(q), &touched) else { continue };
                let to = part(place.0 as usize);
                for label in labels(true).filter(|label| block.near || !label.where_fields_meet()) {
                    add(patch, to, label, material, nodes.len() * label.width() * fields(material));
                }
                let known = read.entry((place, material, part(patch))).or_insert(nodes);
                *known = known.around(&nodes);
            }
        }
    }
    for (((patch, at), material, to), nodes) in read {
        let present = warehouse.nodes[patch as usize].blocks[at as usize].present.len();
        for label in labels(false).filter(|label| is_there(*label, present)) {
            add(patch as usize, to, label, material, nodes.len() * label.width() * fields(material));
        }
    }
    all
}

/// For each patch and rank, the particle blocks of the patch that have node blocks of the rank around them.
fn adders(warehouse: &Warehouse, rank_of: &[usize]) -> BTreeMap<(usize, usize), u64> {
    let mut adders = BTreeMap::new();
    for (patch, homes) in warehouse.particles.iter().enumerate() {
        for block in homes.iter().flat_map(|home| &home.blocks) {
            let nodes = block.around.iter().filter(|place| **place != NOWHERE);
            let ranks: BTreeSet<usize> = nodes.map(|place| rank_of[place.0 as usize]).collect();
            ranks.into_iter().for_each(|rank| *adders.entry((patch, rank)).or_default() += 1);
        }
    }
    adders
}

/// Pairs of ranks that have blocks in sight of each other.
fn neighbors(decomposition: &Decomposition, rank_of: &[usize], ranks: usize) -> BTreeSet<(usize, usize)> {
    let of = || rank_of.iter().map(|&rank| rank as u32).collect();
    let seen = |rank| beside(decomposition, &Partition::new(of(), rank, ranks)).into_iter();
    (0..ranks).flat_map(|rank| seen(rank).map(move |other| (rank, other.rank))).collect()
}

/// Messages of `ranks::collective::reduce`.
fn reduction(ranks: usize) -> Vec<(usize, usize)> {
    let sent = |rank| {
        collective::acts(rank, ranks).filter_map(move |act| match act {
            Act::Send(to) => Some((rank, to)),
            Act::Merge(_) | Act::Take(_) => None,
        })
    };
    (0..ranks).flat_map(sent).collect()
}
