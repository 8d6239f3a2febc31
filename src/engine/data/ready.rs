//! Blocks into which particles may come soon: they are there before, so that lists of blocks are not rebuilt whenever a particle
//! crosses a border. What is in them is nothing, and so is what they add: results do not depend on them.
use super::activate::FARTHEST;
use super::extent;
use super::particles::ParticleBlock;
use super::spread::{Spread, many};
use super::warehouse::Warehouse;
use grid::{BlockIndex, BlockShape, IndexBox, Level};

/// How close to the end of their reach particles are that may leave their block soon [cells].
const CLOSE: f64 = 0.125;

impl Warehouse {
    /// Whether lists of blocks were ever built.
    pub fn is_arranged(&self) -> bool {
        self.nodes.iter().any(|patch| !patch.blocks.is_empty())
    }

    /// Makes the blocks into which particles of this rank may come soon, but for those that another rank would have to know of.
    pub fn make_ready(&mut self, spread: &dyn Spread) {
        let shape = self.level.shape();
        let mine = self.partition.mine().flat_map(|patch| self.particles[patch].iter().enumerate());
        let blocks =
            mine.flat_map(|(material, home)| home.blocks.iter().map(move |block| (material, block, None)));
        let mut blocks: Vec<_> = blocks.collect();
        many(spread, &mut blocks, |(_, block, soon)| *soon = destinations(block, shape));
        let soon = blocks.into_iter().filter_map(|(material, _, soon)| Some((material, soon?)));
        for (material, index) in
            soon.flat_map(|(m, soon)| soon.iter().map(move |index| (m, index))).collect::<Vec<_>>()
        {
            if let Some(patch) = self.patch_out_of_sight(index) {
                self.particles[patch][material].position(index, &self.node_layout);
            }
        }
    }

    /// The patch of a block, if it is one of this rank's that no other rank sees.
    fn patch_out_of_sight(&self, index: BlockIndex) -> Option<usize> {
        let Self { decomposition, partition, .. } = self;
        let patch = decomposition.owner(index).filter(|patch| partition.is_mine(*patch))?;
        let alone = partition.ranks == 1
            || decomposition
                .holders(IndexBox::of(index).grown(FARTHEST))
                .all(|patch| partition.is_mine(patch));
        alone.then_some(patch)
    }
}

/// The blocks to which particles of a block may go soon, if there are some.
fn destinations(block: &ParticleBlock, shape: &BlockShape) -> Option<IndexBox> {
    let first = shape.first_of_buffer(block.index);
    let (mut bases, mut close) = ([[0; 3]; 2], false);
    for axis in (0..3).filter(|axis| !shape.is_collapsed(*axis)) {
        let (least, most) = extent::bounds(&block.extent, axis);
        let (begin, end) = (f64::from(first[axis]), f64::from(first[axis] + shape.bases(axis)));
        close |= least < begin + CLOSE || most > end - CLOSE;
        // those of which nobody knows where they are may be anywhere within reach
        let node = |y: f64| y.clamp(begin - CLOSE, end + CLOSE).floor() as i32;
        (bases[0][axis], bases[1][axis]) = (node(least - CLOSE), node(most + CLOSE));
    }
    let [lower, upper] = bases.map(Level::block_of);
    close.then(|| IndexBox { lower, upper: upper.map(|i| i + 1) })
}
