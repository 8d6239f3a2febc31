//! Which blocks the particles of a scene occupy at its start, and how many are in each.
use super::roll::Roll;
use super::share;
use crate::simulation::layout;
use engine::exec::ranks::{Network, NetworkError, collective};
use grid::{BlockIndex, IndexBox, Level};
use scene::Scene;
use scene::sampling::{Filling, Span, size};
use tasks::recipes;

/// The points of a body's lattice by the blocks to which they belong. A block takes neighboring points along each axis.
pub struct Blocks<'a> {
    filling: &'a Filling,
    /// The blocks that have some.
    all: IndexBox,
    /// The first point of each block along each axis, and the end.
    starts: [Vec<i64>; 3],
}

impl<'a> Blocks<'a> {
    /// Those of a lattice whose particles have this half-size [cells].
    pub fn new(level: &Level, half_size: [f64; 3], filling: &'a Filling) -> Self {
        let (mut all, mut starts) = (IndexBox { lower: [0; 3], upper: [0; 3] }, [const { Vec::new() }; 3]);
        for (a, starts) in starts.iter_mut().enumerate().filter(|_| size(filling.span()) > 0) {
            let range = filling.span()[a].clone();
            let block = |j: i64| Level::block_of(level.base_node([filling.at(a, j); 3], half_size))[a];
            (all.lower[a], all.upper[a]) = (block(range.start), block(range.end - 1) + 1);
            let mut next = range.start;
            for index in all.lower[a]..all.upper[a] {
                starts.push(next);
                while next < range.end && block(next) <= index {
                    next += 1;
                }
            }
            starts.push(range.end);
        }
        Self { filling, all, starts }
    }

    /// The points of some blocks.
    pub fn points(&self, blocks: &IndexBox) -> Span {
        let blocks = blocks.common(&self.all);
        std::array::from_fn(|a| {
            let at =
                |index: i32| self.starts[a].get((index - self.all.lower[a]) as usize).copied().unwrap_or(0);
            at(blocks.lower[a])..at(blocks.upper[a])
        })
    }

    /// Visits those of some blocks that may have particles, with their points, and whether all of these are particles.
    pub fn visit(&self, blocks: &IndexBox, each: &mut impl FnMut(BlockIndex, Span, bool)) {
        let blocks = blocks.common(&self.all);
        let points = self.points(&blocks);
        if size(&points) == 0 {
            return;
        }
        match self.filling.holds(&points) {
            Some(false) => {}
            Some(true) => {
                blocks.iter().for_each(|index| each(index, self.points(&IndexBox::of(index)), true))
            }
            None if blocks.len() == 1 => each(blocks.lower, points, false),
            None => halves(&blocks).iter().for_each(|half| self.visit(half, each)),
        }
    }

    /// Columns of blocks along z.
    fn columns(&self) -> usize {
        let [x, y, _] = self.all.size();
        x * y
    }

    fn column(&self, number: usize) -> IndexBox {
        let IndexBox { mut lower, mut upper } = self.all;
        let across = self.all.size()[1];
        (lower[0], lower[1]) = (lower[0] + (number / across) as i32, lower[1] + (number % across) as i32);
        (upper[0], upper[1]) = (lower[0] + 1, lower[1] + 1);
        IndexBox { lower, upper }
    }
}

/// Blocks in two along their longest axis.
fn halves(blocks: &IndexBox) -> [IndexBox; 2] {
    let length = |a: usize| blocks.upper[a] - blocks.lower[a];
    let axis = (1..3).fold(0, |most, a| if length(a) > length(most) { a } else { most });
    let (mut first, mut second) = (*blocks, *blocks);
    first.upper[axis] = blocks.lower[axis] + length(axis) / 2;
    second.lower[axis] = first.upper[axis];
    [first, second]
}

/// The occupied blocks, with their particles. All ranks call it, and each counts its share of the columns of blocks.
///
/// # Errors
/// If a rank is gone.
pub fn census(
    scene: &Scene,
    roll: &Roll,
    network: &mut dyn Network,
) -> Result<Vec<(BlockIndex, u64)>, NetworkError> {
    let (level, mut words) = (layout::level(scene), Vec::new());
    for (number, body) in scene.bodies.iter().enumerate() {
        let Some(filling) = roll.of(number).map(|numbering| numbering.filling()) else { continue };
        let blocks = Blocks::new(&level, recipes::half_size(scene, body.material), filling);
        for column in share(network, blocks.columns()) {
            blocks.visit(&blocks.column(column), &mut |[x, y, z], points, all| {
                let count = if all { size(&points) } else { filling.count(&points) };
                let half = |i: i32| u64::from(i.cast_unsigned());
                words.extend([half(x) << 32 | half(y), half(z), count]);
            });
        }
    }
    let all = if network.size() == 1 { vec![words] } else { collective::share(network, &words)? };
    let block =
        |&[xy, z, count]: &[u64; 3]| ([xy >> 32, xy, z].map(|half| (half as u32).cast_signed()), count);
    let blocks = all.iter().flat_map(|words| words.as_chunks().0.iter().map(block));
    let mut census: Vec<(BlockIndex, u64)> = blocks.filter(|(_, count)| *count > 0).collect();
    census.sort_unstable();
    // several bodies may be in a block
    census.dedup_by(|next, first| {
        let same = next.0 == first.0;
        first.1 += if same { next.1 } else { 0 };
        same
    });
    Ok(census)
}
