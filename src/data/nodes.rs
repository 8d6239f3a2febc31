//! Node fields of one block, for the materials that touch it.
use crate::grid::BlockIndex;
use crate::simd::Wide;

/// Nodes that a block owns: 4x4x4, z fastest.
pub const NODES: usize = 64;

/// The node fields that outlive the node stage.
#[derive(Clone, Debug)]
pub struct NodeBlock {
    /// Which block.
    pub index: BlockIndex,
    /// Materials that touch its nodes, ascending.
    pub present: Vec<u8>,
    /// `NodeMotion`: 64 lines a present material.
    pub motion: Vec<Wide>,
    /// For each present material, its particle blocks around, in the order of `grid::around`: (patch, position).
    pub around: Vec<[(u32, u32); 27]>,
}

impl NodeBlock {
    /// A block that `present` materials touch.
    pub fn new(index: BlockIndex, present: Vec<u8>) -> Self {
        let motion = vec![Wide::default(); NODES * present.len()];
        let around = vec![[NOWHERE; 27]; present.len()];
        Self { index, present, motion, around }
    }

    /// The motion of a material, or `None` if it does not touch the block.
    pub fn motion_of(&self, material: usize) -> Option<&[Wide]> {
        let slot = self.present.iter().position(|&m| m as usize == material)?;
        Some(&self.motion[slot * NODES..(slot + 1) * NODES])
    }
}

/// A neighbor that does not exist.
pub const NOWHERE: (u32, u32) = (u32::MAX, u32::MAX);
