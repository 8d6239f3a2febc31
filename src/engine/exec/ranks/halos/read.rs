//! Node blocks that particles of another rank read.
use super::adder::Adder;
use crate::data::warehouse::{ParticlePatch, Warehouse};
use crate::exec::halo::{back, lines, overlap};
use grid::{BlockShape, IndexBox};
use std::ops::Range;

/// A node block that particles of another rank read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodesRead {
    pub material: usize,
    /// Patch and position.
    pub place: (usize, usize),
    /// Who reads: an [`Adder`], and where the node block is among those around it.
    pub readers: Vec<(usize, usize)>,
}

/// The node blocks that `adders` add to, and read in turn; in an order that both sides know.
pub fn read(warehouse: &Warehouse, adders: &[Adder]) -> Vec<NodesRead> {
    let mut read: Vec<(usize, (u32, u32), usize, usize)> = Vec::new();
    for (reader, adder) in adders.iter().enumerate() {
        let block = adder.block(&warehouse.particles);
        read.extend(adder.towards().map(|q| (adder.material, block.around[q], reader, q)));
    }
    read.sort_unstable();
    let same_nodes = |a: &(usize, (u32, u32), _, _), b: &(usize, (u32, u32), _, _)| (a.0, a.1) == (b.0, b.1);
    let read = read.chunk_by(same_nodes).map(|readers| NodesRead {
        material: readers[0].0,
        place: (readers[0].1.0 as usize, readers[0].1.1 as usize),
        readers: readers.iter().map(|&(_, _, reader, q)| (reader, q)).collect(),
    });
    read.collect()
}

impl NodesRead {
    /// The nodes that are read, from the block's first one on; all that may be, if nobody knows which.
    pub fn nodes(
        &self,
        shape: &BlockShape,
        readers: &[Adder],
        particles: &[Vec<ParticlePatch>],
        whole: bool,
    ) -> IndexBox {
        let all = IndexBox { lower: [0; 3], upper: shape.buffer };
        let touched = self.readers.iter().filter_map(|&(reader, q)| {
            let touched = if whole { &all } else { &readers[reader].block(particles).touched };
            Some(overlap(shape, back(q), touched)?.0)
        });
        let nothing = IndexBox { lower: [0; 3], upper: [0; 3] };
        touched.reduce(|a, b| a.around(&b)).unwrap_or(nothing)
    }
}

/// The lines of some nodes of a block, row by row along z.
pub fn rows(
    shape: &BlockShape,
    nodes: &IndexBox,
    width: usize,
) -> impl Iterator<Item = Range<usize>> + use<> {
    let IndexBox { lower: [x0, y0, z0], upper: [x1, y1, z1] } = *nodes;
    let [sx, sy, _] = shape.node_strides;
    (x0..x1).flat_map(move |x| {
        (y0..y1).map(move |y| {
            let first = x * sx + y * sy;
            lines((first + z0) as usize..(first + z1) as usize, width)
        })
    })
}
