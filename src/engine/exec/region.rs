//! The region of nodes around a particle block: what its particles read.
use super::halo::{back, lines, pencils};
use crate::data::fields::FieldId;
use crate::data::nodes::{NOWHERE, NodeBlock, Place};
use crate::data::warehouse::NodePatch;
use grid::{BELOW, BLOCK, BlockShape, IndexBox, NODES, STRIDE};
use simd::{Job, Simd, Wide};

/// The values of the nodes around a particle block, as far as its particles touch them.
#[derive(Clone, Copy)]
pub struct ValuesAround<'a> {
    /// Which label (see [`NodeBlock::column`]).
    pub place: usize,
    /// The field.
    pub field: FieldId,
    /// Lines a node.
    pub width: usize,
    /// How nodes follow one another.
    pub shape: &'a BlockShape,
    /// All node blocks.
    pub nodes: &'a [NodePatch],
    /// The blocks around.
    pub around: &'a [Place; 27],
    /// The part of the block's buffer that is touched.
    pub touched: &'a IndexBox,
}

impl<'a> ValuesAround<'a> {
    #[inline(always)]
    fn block(&self, q: usize) -> Option<&'a NodeBlock> {
        let (patch, at) = *self.around.get(q).filter(|&&n| n != NOWHERE)?;
        Some(&self.nodes[patch as usize].blocks[at as usize])
    }

    /// The values of the `q`-th node block around.
    #[inline(always)]
    fn values(&self, q: usize) -> Option<&'a [Wide]> {
        let block = self.block(q)?;
        let length = self.shape.node_count() * self.width;
        let slot = block.slot(self.field)?;
        block.column(self.place).get(slot * length..(slot + 1) * length)
    }
}

/// Fills a block's buffer with the values of the nodes around; with zeros where they are not there.
pub struct LoadRegion<'a> {
    /// With what.
    pub from: ValuesAround<'a>,
    /// The buffer.
    pub region: &'a mut [Wide],
}

impl Job for LoadRegion<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { from, region } = self;
        match from.shape.is_full() && from.width == 1 {
            true => load_rows::<S>(&from, region),
            false => load::<S>(&from, region),
        }
    }
}

/// Fills a buffer block by block.
#[inline(always)]
fn load<S: Simd>(from: &ValuesAround<'_>, region: &mut [Wide]) {
    for q in 0..27 {
        let values = from.values(q);
        for (own, here) in pencils(from.shape, back(q), from.touched) {
            let (own, here) = (lines(own, from.width), lines(here, from.width));
            match values {
                Some(values) => copy::<S>(&values[own], &mut region[here]),
                None => region[here].fill(Wide::default()),
            }
        }
    }
}

#[inline(always)]
fn copy<S: Simd>(from: &[Wide], to: &mut [Wide]) {
    for (to, from) in to.iter_mut().zip(from) {
        S::load(from).store(to);
    }
}

/// As [`load`], for blocks of 4x4x4 nodes of a line each: row by row of the buffer, whose nodes are those of three blocks along z.
#[inline(always)]
fn load_rows<S: Simd>(from: &ValuesAround<'_>, region: &mut [Wide]) {
    const NOTHING: [Wide; NODES] = [Wide([0.0; 8]); NODES];
    const ENDS: [usize; 4] = [0, BELOW as usize, (BELOW + BLOCK) as usize, STRIDE[1]];
    let IndexBox { lower, upper } = *from.touched;
    let [lower, upper] = [lower, upper].map(|corner| corner.map(|i| i as usize));
    let reached = |q: &usize| {
        let d = [q / 9, q / 3 % 3, q % 3];
        (0..3).all(|a| ENDS[d[a]] < upper[a] && lower[a] < ENDS[d[a] + 1])
    };
    (0..27).filter(reached).filter_map(|q| from.block(q)).for_each(NodeBlock::announce);
    let mut values = [&NOTHING; 27];
    for q in (0..27).filter(reached) {
        if let Some(found) = from.values(q).and_then(|values| values.first_chunk()) {
            values[q] = found;
        }
    }
    for x in lower[0]..upper[0] {
        let (dx, nx) = node_of(x);
        for y in lower[1]..upper[1] {
            let (dy, ny) = node_of(y);
            let Some(row) = region[x * STRIDE[0] + y * STRIDE[1]..].first_chunk_mut::<{ STRIDE[1] }>() else {
                return;
            };
            // all of the row, touched or not: a range that varies costs more
            let own = (nx * BLOCK as usize + ny) * BLOCK as usize;
            for dz in 0..3 {
                let pencil = &values[9 * dx + 3 * dy + dz][own..own + BLOCK as usize];
                for z in ENDS[dz]..ENDS[dz + 1] {
                    S::load(&pencil[node_of(z).1]).store(&mut row[z]);
                }
            }
        }
    }
}

/// The block along an axis (0: before, 1: the own, 2: behind) that has the `n`-th node of a buffer, and which of its nodes that is.
#[inline(always)]
fn node_of(n: usize) -> (usize, usize) {
    let shifted = n + (BLOCK - BELOW) as usize;
    (shifted / BLOCK as usize, shifted % BLOCK as usize)
}
