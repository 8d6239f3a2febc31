//! The nodes of a block, and those around it that its particles reach: its buffer.
use super::{BlockIndex, IndexBox};

/// Cells, and nodes, of a block along an axis.
pub const BLOCK: i32 = 4;
/// Nodes of a block that has all its axes: 4x4x4.
pub const NODES: usize = 64;
/// Lines of a block's buffer along x, y, z, where it has all its axes: 8x8x8 nodes from node 4b − 1 on.
pub const STRIDE: [usize; 3] = [64, 8, 1];
/// Nodes below a block's own that its buffer holds: a particle may drift one cell out of its block.
pub const BELOW: i32 = 1;
/// Nodes of a block's buffer along an axis.
const BUFFER: i32 = BELOW + BLOCK + REACH as i32;
/// Base nodes (relative to the buffer) that a particle of the block may have along an axis.
pub const BASES: i32 = 6;
/// Most nodes that a particle touches along an axis.
pub const NODES_PER_AXIS: i32 = 3;
/// Layers of nodes beyond a block's own that its particles can reach: what ghosts are stored for.
pub const REACH: u8 = 3;

/// How the nodes of a block and of its buffer follow one another: z fastest. An axis of a level without cells is
/// collapsed: it has one layer of nodes, in blocks and in buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BlockShape {
    /// Nodes of a block along each axis.
    pub nodes: [i32; 3],
    /// From a node of a block to the next one along each axis.
    pub node_strides: [i32; 3],
    /// The logarithms of `node_strides` to base 2.
    node_shifts: [u32; 3],
    /// Nodes of a buffer along each axis.
    pub buffer: [i32; 3],
    /// From a node of a buffer to the next one along each axis.
    pub buffer_strides: [i32; 3],
    /// Nodes of a buffer below those of its block.
    pub below: [i32; 3],
    /// Along each axis, the nodes of a block that lie in the buffer of the block before it, in its own, and in that of the
    /// block behind it.
    pub shared: [[SharedNodes; 3]; 3],
}

/// All shapes: one bit an axis, set where it is collapsed.
static SHAPES: [BlockShape; 8] = {
    let (mut shapes, mut number) = ([BlockShape::FULL; 8], 0);
    while number < 8 {
        shapes[number] = BlockShape::new([number & 4 != 0, number & 2 != 0, number & 1 != 0]);
        number += 1;
    }
    shapes
};

/// Nodes of a block that lie in a buffer, along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SharedNodes {
    /// The first of them.
    pub first: i32,
    /// One past the last of them.
    pub end: i32,
    /// What to add to them to get their index in the buffer.
    pub to_buffer: i32,
}

impl SharedNodes {
    /// On an axis with so many nodes a block, in the buffer of the block `d` blocks further.
    const fn new(nodes: i32, buffer: i32, below: i32, d: i32) -> Self {
        let to_buffer = below - d * nodes;
        let first = if to_buffer < 0 { -to_buffer } else { 0 };
        let end = if buffer - to_buffer < nodes { buffer - to_buffer } else { nodes };
        Self { first, end, to_buffer }
    }

    const fn all(nodes: i32, buffer: i32, below: i32) -> [Self; 3] {
        [
            Self::new(nodes, buffer, below, -1),
            Self::new(nodes, buffer, below, 0),
            Self::new(nodes, buffer, below, 1),
        ]
    }
}

impl BlockShape {
    /// The shape on a level without a collapsed axis: what the compiler knows of most levels.
    pub const FULL: Self = Self::new([false; 3]);

    /// The shape where some axes are collapsed.
    const fn new(collapsed: [bool; 3]) -> Self {
        const fn of(collapsed: [bool; 3], [full, flat]: [i32; 2]) -> [i32; 3] {
            let [x, y, z] = collapsed;
            [if x { flat } else { full }, if y { flat } else { full }, if z { flat } else { full }]
        }
        let (nodes, buffer, below) =
            (of(collapsed, [BLOCK, 1]), of(collapsed, [BUFFER, 1]), of(collapsed, [BELOW, 0]));
        let node_strides = [nodes[1] * nodes[2], nodes[2], 1];
        Self {
            nodes,
            node_strides,
            node_shifts: [node_strides[0].trailing_zeros(), node_strides[1].trailing_zeros(), 0],
            buffer,
            buffer_strides: [buffer[1] * buffer[2], buffer[2], 1],
            below,
            shared: [
                SharedNodes::all(nodes[0], buffer[0], below[0]),
                SharedNodes::all(nodes[1], buffer[1], below[1]),
                SharedNodes::all(nodes[2], buffer[2], below[2]),
            ],
        }
    }

    /// The shape on a level of so many cells along each axis.
    pub fn of(cells: [usize; 3]) -> &'static Self {
        &SHAPES[cells.iter().fold(0, |number, &cells| 2 * number + usize::from(cells == 0))]
    }

    /// Whether no axis is collapsed.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.nodes == Self::FULL.nodes
    }

    /// Number of nodes of a block.
    #[inline]
    pub fn node_count(&self) -> usize {
        self.nodes.iter().product::<i32>() as usize
    }

    /// Which blocks around have nodes in a part of a block's buffer: bit `q` is set if the block does from which this one is seen at
    /// the `q`-th of the offsets around.
    #[inline]
    pub fn reached(&self, part: &IndexBox) -> u32 {
        let reaches = |a: usize| {
            self.shared[a].map(|SharedNodes { first, end, to_buffer }| {
                first.max(part.lower[a] - to_buffer) < end.min(part.upper[a] - to_buffer)
            })
        };
        let [x, y, z] = [reaches(0), reaches(1), reaches(2)];
        let bits = |along: [bool; 3], of_one: u32, width: u32| {
            (0..3).filter(|&d| along[d]).fold(0, |bits, d| bits | of_one << (width * d as u32))
        };
        bits(x, bits(y, bits(z, 1, 1), 3), 9)
    }

    /// Number of nodes of a buffer.
    #[inline]
    pub fn buffer_len(&self) -> usize {
        self.buffer.iter().product::<i32>() as usize
    }

    /// Whether an axis is collapsed.
    #[inline]
    pub fn is_collapsed(&self, axis: usize) -> bool {
        self.nodes[axis] == 1
    }

    /// Base nodes (relative to the buffer) that a particle of the block may have along an axis.
    #[inline]
    pub fn bases(&self, axis: usize) -> i32 {
        if self.is_collapsed(axis) { 1 } else { BASES }
    }

    /// Most nodes that a particle touches along an axis.
    #[inline]
    pub fn nodes_per_axis(&self, axis: usize) -> i32 {
        if self.is_collapsed(axis) { 1 } else { NODES_PER_AXIS }
    }

    /// Place of a block's `n`-th node along each axis, from the block's first node on.
    #[inline]
    pub fn place(&self, n: usize) -> [i32; 3] {
        // blocks have four nodes along an axis, or one
        std::array::from_fn(|a| n as i32 >> self.node_shifts[a] & (self.nodes[a] - 1))
    }

    /// The first node of a block, in nodes of the level.
    #[inline]
    pub fn first_node(&self, block: BlockIndex) -> [i32; 3] {
        std::array::from_fn(|a| self.nodes[a] * block[a])
    }

    /// The first node of a block's buffer, in nodes of the level.
    #[inline]
    pub fn first_of_buffer(&self, block: BlockIndex) -> [i32; 3] {
        std::array::from_fn(|a| self.nodes[a] * block[a] - self.below[a])
    }
}

/// Where the stencils of a block's particles are counted from.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// Node (0,0,0) of the block's buffer, in nodes of the level.
    pub node: [f64; 3],
    /// Lower corner of the level divided by the cell size.
    pub lower: [f64; 3],
    /// From a node of the buffer to the next one along each axis.
    pub strides: [f64; 3],
    /// The nodes of block and buffer.
    pub shape: &'static BlockShape,
}

impl Origin {
    /// The node of a line of the buffer, in nodes of the level.
    #[inline]
    pub fn node_at(&self, line: usize) -> [i32; 3] {
        let ([sx, sy, _], line) = (self.shape.buffer_strides, line as i32);
        let place = [line / sx, line % sx / sy, line % sy];
        std::array::from_fn(|a| self.node[a] as i32 + if self.shape.is_collapsed(a) { 0 } else { place[a] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_blocks_have_the_shape_of_the_constants() {
        let shape = BlockShape::of([9, 1, 3]);
        assert!(*shape == BlockShape::FULL && shape.is_full() && !BlockShape::of([9, 0, 3]).is_full());
        assert_eq!(shape.buffer_strides.map(|s| s as usize), STRIDE);
        assert_eq!((shape.node_count(), shape.buffer_len()), (NODES, 8 * STRIDE[0]));
        assert!((0..NODES).all(|n| shape.place(n) == [n >> 4, n >> 2 & 3, n & 3].map(|i| i as i32)));
    }

    #[test]
    fn a_block_reaches_those_whose_nodes_are_in_its_buffer() {
        for cells in [[9; 3], [9, 0, 9], [0, 9, 0]] {
            let shape = BlockShape::of(cells);
            let end = shape.buffer;
            let parts = IndexBox { lower: [0; 3], upper: end.map(|n| n + 1) };
            // every range along x, and some along y and z
            for lower in parts.iter().filter(|lower| (0..3).all(|a| a == 0 || lower[a] % 3 == 0)) {
                for upper in parts.iter().filter(|upper| (0..3).all(|a| a == 0 || upper[a] % 2 == 0)) {
                    let (part, bits) = (IndexBox { lower, upper }, shape.reached(&IndexBox { lower, upper }));
                    for (q, d) in crate::around().enumerate() {
                        // seen from there this block lies at `d`
                        let there = shape.first_node(d.map(|d| -d));
                        let first = shape.first_of_buffer([0; 3]);
                        let has = |a: usize| {
                            let mut nodes = (there[a]..there[a] + shape.nodes[a]).map(|n| n - first[a]);
                            let flat = shape.is_collapsed(a) && d[a] != 0;
                            !flat && nodes.any(|n| part.lower[a] <= n && n < part.upper[a])
                        };
                        assert_eq!(bits >> q & 1 == 1, (0..3).all(has), "{part:?} {d:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_collapsed_axis_has_one_layer() {
        let shape = BlockShape::of([8, 8, 0]);
        assert_eq!((shape.node_count(), shape.buffer_len()), (16, 64));
        assert_eq!((shape.node_strides, shape.buffer_strides), ([4, 1, 1], [8, 1, 1]));
        assert_eq!((shape.place(7), shape.first_of_buffer([2, 0, 0])), ([1, 3, 0], [7, -1, 0]));
        assert_eq!((shape.bases(2), shape.nodes_per_axis(2)), (1, 1));
    }
}
