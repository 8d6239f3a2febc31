//! Node fields of one block, for the materials that touch it.
use crate::grid::BlockIndex;
use crate::simd::Wide;
use std::ops::Range;

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
    /// `ContactImpulse`: as `motion`, where contact acts; else empty.
    pub impulse: Vec<Wide>,
    /// For each present material, the number of the tick up to which its nodes have been integrated; below any tick
    /// where they never were.
    pub until: Vec<f64>,
    /// For each present material, its particle blocks around, in the order of `grid::around`: (patch, position).
    pub around: Vec<[(u32, u32); 27]>,
    /// Whether particles of another rank give to it.
    pub rim: bool,
    /// What work on it took, while that is weighed [ns].
    pub cost: u64,
}

impl NodeBlock {
    /// A block that `present` materials touch.
    pub fn new(index: BlockIndex, present: Vec<u8>) -> Self {
        let motion = vec![Wide::default(); NODES * present.len()];
        let around = vec![[NOWHERE; 27]; present.len()];
        let until = vec![NEVER; present.len()];
        Self { index, present, motion, impulse: Vec::new(), until, around, rim: false, cost: 0 }
    }

    /// As `old`, but for other materials: those that stay keep the motion that they have in the middle of a step.
    pub fn succeed(old: &Self, present: Vec<u8>) -> Self {
        let mut block = Self::new(old.index, present);
        if block.present.len() > 1 && !old.impulse.is_empty() {
            block.impulse = block.motion.clone();
        }
        for (to, material) in block.present.iter().enumerate() {
            let Some(from) = old.present.iter().position(|m| m == material) else { continue };
            let (to_lines, from_lines) = (to * NODES..(to + 1) * NODES, from * NODES..(from + 1) * NODES);
            block.until[to] = old.until[from];
            block.motion[to_lines.clone()].copy_from_slice(&old.motion[from_lines.clone()]);
            if !block.impulse.is_empty() {
                block.impulse[to_lines].copy_from_slice(&old.impulse[from_lines]);
            }
        }
        block
    }

    /// The materials, one bit each.
    pub fn bits(&self) -> u64 {
        self.present.iter().fold(0, |bits, material| bits | 1 << material)
    }

    /// The motion of a material, or `None` if it does not touch the block.
    pub fn motion_of(&self, material: usize) -> Option<&[Wide]> {
        self.lines_of(material).map(|lines| &self.motion[lines])
    }

    /// As [`NodeBlock::motion_of`], to write.
    pub fn motion_of_mut(&mut self, material: usize) -> Option<&mut [Wide]> {
        self.lines_of(material).map(|lines| &mut self.motion[lines])
    }

    fn lines_of(&self, material: usize) -> Option<Range<usize>> {
        let slot = self.present.iter().position(|&m| m as usize == material)?;
        Some(slot * NODES..(slot + 1) * NODES)
    }
}

/// Before any tick.
const NEVER: f64 = -1.0;

/// A neighbor that does not exist.
pub const NOWHERE: (u32, u32) = (u32::MAX, u32::MAX);
