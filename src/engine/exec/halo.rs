//! Node data between blocks: what each block's particles add to nodes of others, and the nodes they read.
//!
//! Only the nodes that a block's particles can touch take part (see `ParticleBlock::touched`): the rest of its buffer
//! holds nothing.
use grid::{BlockShape, IndexBox, SharedNodes, offset};
use simd::{Job, Simd, Wide};
use std::ops::Range;

/// The nodes that a block shares with the `touched` part of the buffer of the one at `d`, and what to add to them to get their
/// index in that buffer.
#[inline(always)]
pub fn overlap(shape: &BlockShape, d: [i32; 3], touched: &IndexBox) -> Option<(IndexBox, [i32; 3])> {
    let (mut nodes, mut shift) = (IndexBox { lower: [0; 3], upper: [0; 3] }, [0; 3]);
    for a in 0..3 {
        let SharedNodes { first, end, to_buffer } = shape.shared[a][(d[a] + 1) as usize];
        let low = first.max(touched.lower[a] - to_buffer);
        let high = end.min(touched.upper[a] - to_buffer);
        if low >= high {
            return None;
        }
        (nodes.lower[a], nodes.upper[a], shift[a]) = (low, high, to_buffer);
    }
    Some((nodes, shift))
}

/// Every pencil along z that a block shares with the `touched` part of the buffer of the one at `d`: its nodes, and those of
/// the buffer. An iterator: what a closure does may be compiled as a function of its own, without the instruction set of the
/// caller.
#[inline(always)]
pub fn pencils(shape: &BlockShape, d: [i32; 3], touched: &IndexBox) -> Pencils {
    const NOTHING: (IndexBox, [i32; 3]) = (IndexBox { lower: [0; 3], upper: [0; 3] }, [0; 3]);
    let (nodes, shift) = overlap(shape, d, touched).unwrap_or(NOTHING);
    Pencils {
        at: [nodes.lower[0], nodes.lower[1]],
        nodes,
        shift,
        node_strides: shape.node_strides,
        buffer_strides: shape.buffer_strides,
    }
}

/// See [`pencils`].
pub struct Pencils {
    /// x and y of the next one.
    at: [i32; 2],
    nodes: IndexBox,
    shift: [i32; 3],
    node_strides: [i32; 3],
    buffer_strides: [i32; 3],
}

impl Iterator for Pencils {
    type Item = (Range<usize>, Range<usize>);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let ([x, y], IndexBox { lower, upper }) = (self.at, self.nodes);
        if x >= upper[0] {
            return None;
        }
        self.at = if y + 1 < upper[1] { [x, y + 1] } else { [x + 1, lower[1]] };
        let ([nx, ny, _], [bx, by, _], shift) = (self.node_strides, self.buffer_strides, self.shift);
        let own = (x * nx + y * ny + lower[2]) as usize;
        let there = ((x + shift[0]) * bx + (y + shift[1]) * by + lower[2] + shift[2]) as usize;
        let count = (upper[2] - lower[2]) as usize;
        Some((own..own + count, there..there + count))
    }
}

/// The lines of some nodes, of so many lines each.
#[inline(always)]
pub fn lines(nodes: Range<usize>, width: usize) -> Range<usize> {
    nodes.start * width..nodes.end * width
}

/// Sets the touched lines of the buffers of some fields to what adds nothing.
pub struct Clear<'a> {
    /// The buffers, one after the other.
    pub buffers: &'a mut [Wide],
    /// Lines a node.
    pub width: usize,
    /// What adds nothing.
    pub nothing: f64,
    /// How nodes follow one another.
    pub shape: &'a BlockShape,
    /// Their part.
    pub touched: &'a IndexBox,
}

impl Job for Clear<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let (shape, width) = (self.shape, self.width);
        match (shape.is_full(), width) {
            (true, 1) => self.clear::<S>(&BlockShape::FULL, 1),
            _ => self.clear::<S>(shape, width),
        }
    }
}

impl Clear<'_> {
    #[inline(always)]
    fn clear<S: Simd>(self, shape: &BlockShape, width: usize) {
        let [lower, upper] = [self.touched.lower, self.touched.upper].map(|n| n.map(|i| i as usize));
        let [sx, sy, _] = shape.buffer_strides.map(|s| s as usize);
        let nothing = S::splat(self.nothing);
        for buffer in self.buffers.chunks_exact_mut(shape.buffer_len() * width) {
            for x in lower[0]..upper[0] {
                for y in lower[1]..upper[1] {
                    let row = x * sx + y * sy;
                    let row = lines(row + lower[2]..row + upper[2], width);
                    buffer[row].iter_mut().for_each(|line| nothing.store(line));
                }
            }
        }
    }
}

/// Seen from the `q`-th block around, this one lies the other way.
#[inline(always)]
pub fn back(q: usize) -> [i32; 3] {
    let [x, y, z] = offset(q);
    [-x, -y, -z]
}
