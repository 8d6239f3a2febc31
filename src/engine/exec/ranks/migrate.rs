//! Whole patches move to other ranks, between two steps. Blocks travel as they are, so that no bit changes.
use super::{Channel, Network, NetworkError};
use crate::data::nodes::NodeBlock;
use crate::data::particles::ParticleBlock;
use crate::data::warehouse::Warehouse;
use grid::{BlockIndex, Partition};
use simd::Wide;

/// Moves patches to where `partition` wants them. All ranks call it, with the same partition.
///
/// # Errors
/// If a rank is gone, or a patch arrives broken.
pub fn migrate(
    network: &mut dyn Network,
    warehouse: &mut Warehouse,
    partition: Partition,
) -> Result<(), NetworkError> {
    let old = warehouse.partition.clone();
    let moves: Vec<usize> =
        (0..warehouse.particles.len()).filter(|&p| old.rank_of(p) != partition.rank_of(p)).collect();
    for &patch in moves.iter().filter(|&&patch| old.is_mine(patch)) {
        network.send(partition.rank_of(patch), Channel::Patches, pack(warehouse, patch));
    }
    warehouse.set_partition(partition);
    for &patch in &moves {
        let from = old.rank_of(patch);
        if warehouse.partition.is_mine(patch) {
            let message = network.receive(from, Channel::Patches)?;
            unpack(warehouse, patch, &message).ok_or(NetworkError::Patch { patch, rank: from })?;
        }
    }
    network.settle();
    Ok(())
}

/// For each material the number of particle blocks, then the blocks; and the same of nodes, if they carry something.
fn pack(warehouse: &Warehouse, patch: usize) -> Vec<Wide> {
    let mut message = Vec::new();
    for (home, data) in warehouse.particles[patch].iter().zip(&warehouse.materials) {
        let blocks = home.blocks.iter().filter(|block| block.count > 0);
        message.push(bytemuck::cast([blocks.clone().count() as u64; 8]));
        blocks.for_each(|block| block.to_lines(&data.layout, &mut message));
    }
    let layout = &warehouse.node_layout;
    if layout.carried().next().is_some() {
        let blocks = &warehouse.nodes[patch].blocks;
        message.push(bytemuck::cast([blocks.len() as u64; 8]));
        blocks.iter().for_each(|block| block.to_lines(layout, &mut message));
    }
    message
}

fn unpack(warehouse: &mut Warehouse, patch: usize, mut lines: &[Wide]) -> Option<()> {
    let Warehouse { level, materials, node_layout, particles, nodes, .. } = warehouse;
    let middle = |index: BlockIndex| level.middle(index);
    let count = |lines: &mut &[Wide]| {
        let (head, rest) = lines.split_first()?;
        *lines = rest;
        Some(bytemuck::cast::<Wide, [u64; 8]>(*head)[0])
    };
    for (home, data) in particles[patch].iter_mut().zip(materials) {
        for _ in 0..count(&mut lines)? {
            home.blocks.push(ParticleBlock::from_lines(&data.layout, node_layout, middle, &mut lines)?);
        }
    }
    if node_layout.carried().next().is_some() {
        for _ in 0..count(&mut lines)? {
            nodes[patch].blocks.push(NodeBlock::from_lines(node_layout, &mut lines)?);
        }
    }
    lines.is_empty().then_some(())
}
