//! Ranks tell their neighbors which of their blocks are occupied.
use super::{Channel, Network, NetworkError, pack, unpack};
use crate::data::activate::FARTHEST;
use crate::data::warehouse::Warehouse;
use grid::{BlockIndex, Decomposition, IndexBox, Partition};
use std::collections::BTreeSet;

/// Another rank in sight, and its patches that are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Neighbor {
    /// The rank.
    pub rank: usize,
    /// The blocks of its patches that are in sight of this rank's.
    pub patches: Vec<IndexBox>,
}

/// The ranks that have blocks in sight of this one's, ascending.
pub fn neighbors(decomposition: &Decomposition, partition: &Partition) -> Vec<Neighbor> {
    let patches = &decomposition.patches;
    let seen =
        partition.mine().flat_map(|patch| decomposition.holders(patches[patch].blocks.grown(FARTHEST)));
    let seen: BTreeSet<usize> = seen.filter(|patch| !partition.is_mine(*patch)).collect();
    let mut ranks: Vec<Neighbor> = Vec::new();
    for patch in seen {
        let (rank, blocks) = (partition.rank_of(patch), patches[patch].blocks);
        match ranks.iter_mut().find(|known| known.rank == rank) {
            Some(known) => known.patches.push(blocks),
            None => ranks.push(Neighbor { rank, patches: vec![blocks] }),
        }
    }
    ranks.sort_by_key(|neighbor| neighbor.rank);
    ranks
}

/// Tells the ranks `neighbors` which blocks here are occupied in their sight, and hears the same from them.
///
/// # Errors
/// If one of them is gone.
pub fn tell(
    network: &mut dyn Network,
    warehouse: &mut Warehouse,
    neighbors: &[Neighbor],
) -> Result<(), NetworkError> {
    let sight = warehouse.sight();
    for Neighbor { rank, patches } in neighbors {
        let boxes: Vec<IndexBox> = patches.iter().map(|patch| patch.grown(sight)).collect();
        let occupied = warehouse.blocks().filter(|(_, block)| block.count > 0);
        let seen = occupied.filter(|(_, block)| boxes.iter().any(|seen| seen.contains(block.index)));
        let words: Vec<u64> = seen.flat_map(|(material, block)| encode(material, block.index)).collect();
        network.send(*rank, Channel::Occupied, pack(&words));
    }
    let mut occupied = Vec::new();
    for Neighbor { rank, .. } in neighbors {
        let message = network.receive(*rank, Channel::Occupied)?;
        occupied.extend(unpack(&message).as_chunks().0.iter().map(decode));
    }
    warehouse.set_beyond(occupied.into_iter());
    Ok(())
}

/// Words of a block: its material, and its index on the three axes in a half each. Any of them fits.
type Words = [u64; 3];

fn encode(material: usize, index: BlockIndex) -> Words {
    let [x, y, z] = index.map(|i| u64::from(i.cast_unsigned()));
    [material as u64, x, y << 32 | z]
}

fn decode(&[material, x, yz]: &Words) -> (usize, BlockIndex) {
    let half = |word: u64| (word as u32).cast_signed();
    (material as usize, [half(x), half(yz >> 32), half(yz)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_survive_a_message() {
        let indices =
            [[-1, 0, 1], [300_000, 2, -1], [i32::MIN, i32::MAX, -1], [i32::MAX, -1, i32::MIN], [-1; 3]];
        let materials = [0, 7, 63, 127, 128, 300, 65_535, u32::MAX as usize, usize::MAX];
        let blocks = || materials.iter().flat_map(|&m| indices.map(|index| (m, index)));
        let words: Vec<u64> = blocks().flat_map(|(material, index)| encode(material, index)).collect();
        let (all, rest) = words.as_chunks();
        assert!(rest.is_empty());
        assert_eq!(all.iter().map(decode).collect::<Vec<_>>(), blocks().collect::<Vec<_>>());
    }
}
