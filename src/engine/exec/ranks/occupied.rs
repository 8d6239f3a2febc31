//! Ranks tell their neighbors which of their blocks are occupied.
use super::{Channel, Network, NetworkError, pack, unpack};
use crate::data::activate::FARTHEST;
use crate::data::warehouse::Warehouse;
use grid::{BlockIndex, Decomposition, IndexBox, Partition};

/// Another rank in sight, and its patches that are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Beside {
    /// The rank.
    pub rank: usize,
    /// The blocks of its patches that are in sight of this rank's.
    pub patches: Vec<IndexBox>,
}

/// The ranks that have blocks in sight of this one's, ascending.
pub fn beside(decomposition: &Decomposition, partition: &Partition) -> Vec<Beside> {
    let mut ranks: Vec<Beside> = Vec::new();
    let mine: Vec<IndexBox> =
        partition.mine().map(|patch| decomposition.patches[patch].blocks.grown(FARTHEST)).collect();
    for patch in decomposition.patches.iter().filter(|patch| !partition.is_mine(patch.id)) {
        if mine.iter().any(|seen| !seen.common(&patch.blocks).is_empty()) {
            let rank = partition.rank_of(patch.id);
            match ranks.iter_mut().find(|known| known.rank == rank) {
                Some(known) => known.patches.push(patch.blocks),
                None => ranks.push(Beside { rank, patches: vec![patch.blocks] }),
            }
        }
    }
    ranks.sort_by_key(|beside| beside.rank);
    ranks
}

/// Tells the ranks `beside` which blocks here are occupied in their sight, and hears the same from them.
///
/// # Errors
/// If one of them is gone.
pub fn tell(
    network: &mut dyn Network,
    warehouse: &mut Warehouse,
    beside: &[Beside],
) -> Result<(), NetworkError> {
    let sight = warehouse.sight();
    for Beside { rank, patches } in beside {
        let boxes: Vec<IndexBox> = patches.iter().map(|patch| patch.grown(sight)).collect();
        let occupied = warehouse.blocks().filter(|(_, block)| block.count > 0);
        let seen = occupied.filter(|(_, block)| boxes.iter().any(|seen| seen.contains(block.index)));
        let words: Vec<u64> = seen.map(|(material, block)| encode(material, block.index)).collect();
        network.send(*rank, Channel::Occupied, pack(&words));
    }
    let mut occupied = Vec::new();
    for Beside { rank, .. } in beside {
        let message = network.receive(*rank, Channel::Occupied)?;
        occupied.extend(unpack(&message).iter().map(|&word| decode(word)));
    }
    warehouse.set_beyond(occupied.into_iter());
    Ok(())
}

/// Bits of an index along one axis.
const BITS: u32 = 19;
/// What makes an index positive: blocks begin at −1.
const SHIFT: i32 = 16;

fn encode(material: usize, index: BlockIndex) -> u64 {
    index.iter().fold(material as u64, |word, i| word << BITS | (i + SHIFT) as u64)
}

fn decode(word: u64) -> (usize, BlockIndex) {
    let axis = |a: u32| (word >> (BITS * (2 - a)) & ((1 << BITS) - 1)) as i32 - SHIFT;
    ((word >> (3 * BITS)) as usize, [axis(0), axis(1), axis(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_survive_a_message() {
        for block in [(0, [-1, 0, 1]), (63, [300_000, 2, -1]), (7, [5, 300_000, 300_000])] {
            assert_eq!(decode(encode(block.0, block.1)), block);
        }
    }
}
