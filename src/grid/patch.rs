use super::{BlockIndex, IndexBox, Level};
use std::cmp::Reverse;

/// A box of whole blocks: the unit of ownership.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patch {
    /// Position in the decomposition.
    pub id: usize,
    /// Position along each axis.
    pub index: [usize; 3],
    /// Its blocks, with those beyond the level's faces that particles at the faces reach.
    pub blocks: IndexBox,
}

/// How a level is cut into patches.
#[derive(Clone, Debug, PartialEq)]
pub struct Decomposition {
    /// Patches along each axis.
    pub counts: [usize; 3],
    /// The patches, x-major.
    pub patches: Vec<Patch>,
    /// First block of each patch along each axis, and the end.
    cuts: [Vec<i32>; 3],
}

/// The most patches: each takes some hundred bytes on every rank, and patches are numbered by 32 bits.
pub const MOST_PATCHES: usize = 1 << 24;
/// The most blocks of a patch: their places in it are numbered by 32 bits, with one number for "nowhere".
pub const MOST_BLOCKS: usize = u32::MAX as usize - 1;

impl Decomposition {
    /// Cuts `level` into `counts` patches along each axis, as evenly as whole blocks allow.
    ///
    /// # Errors
    /// More patches than blocks along an axis, or none; more patches, or larger ones, than can be numbered. The message says
    /// how many are possible.
    pub fn new(level: &Level, counts: [usize; 3]) -> Result<Self, String> {
        let columns = level.block_columns();
        for axis in 0..3 {
            if counts[axis] == 0 || counts[axis] > columns[axis] {
                return Err(format!(
                    "{} patches along {} cannot be cut from {} blocks of 4 cells: choose 1 to {}",
                    counts[axis],
                    ["x", "y", "z"][axis],
                    columns[axis],
                    columns[axis]
                ));
            }
        }
        if counts.iter().map(|&n| n as f64).product::<f64>() > MOST_PATCHES as f64 {
            let [x, y, z] = counts;
            return Err(format!(
                "{x}x{y}x{z} patches are too many: choose at most {MOST_PATCHES} of them, with --patches or run.patches"
            ));
        }
        let all = level.blocks();
        let cuts: [Vec<i32>; 3] = std::array::from_fn(|a| {
            let mut cuts: Vec<i32> = (0..=counts[a]).map(|i| (i * columns[a] / counts[a]) as i32).collect();
            (cuts[0], cuts[counts[a]]) = (all.lower[a], all.upper[a]);
            cuts
        });
        let longest = |cuts: &Vec<i32>| cuts.windows(2).map(|ends| ends[1] - ends[0]).max().unwrap_or(0);
        let largest = cuts.iter().map(|cuts| f64::from(longest(cuts))).product::<f64>();
        if largest > MOST_BLOCKS as f64 {
            return Err(format!(
                "a patch has {largest:.3e} blocks of 4x4x4 cells, but at most {MOST_BLOCKS} are possible: choose more patches \
                 with --patches or run.patches, or larger cells"
            ));
        }
        let [nx, ny, nz] = counts;
        let indices = (0..nx * ny * nz).map(|id| [id / (ny * nz), id / nz % ny, id % nz]);
        let patches = indices.enumerate().map(|(id, index)| {
            let corner = |shift: usize| std::array::from_fn(|a| cuts[a][index[a] + shift]);
            Patch { id, index, blocks: IndexBox { lower: corner(0), upper: corner(1) } }
        });
        let patches = patches.collect();
        Ok(Self { counts, patches, cuts })
    }

    /// The patch that owns `block`, if the block exists.
    pub fn owner(&self, block: BlockIndex) -> Option<usize> {
        let mut id = 0;
        for axis in 0..3 {
            let cuts = &self.cuts[axis];
            let position = cuts.partition_point(|&cut| cut <= block[axis]);
            if position == 0 || position == cuts.len() {
                return None;
            }
            id = id * self.counts[axis] + position - 1;
        }
        Some(id)
    }

    /// The patches that hold some of `blocks`.
    pub fn holders(&self, blocks: IndexBox) -> impl Iterator<Item = usize> {
        let [lower, upper]: [[i32; 3]; 2] = std::array::from_fn(|end| {
            std::array::from_fn(|a| {
                let (cuts, index) = (&self.cuts[a], [blocks.lower[a], blocks.upper[a] - 1][end]);
                let position = cuts.partition_point(|&cut| cut <= index) as i32;
                position.clamp(1, self.counts[a] as i32) - 1 + end as i32
            })
        });
        let [_, ny, nz] = self.counts;
        IndexBox { lower, upper }
            .iter()
            .map(move |[x, y, z]| (x as usize * ny + y as usize) * nz + z as usize)
    }

    /// About as many patches as asked for, at least so many if the level has the blocks, cut where that spreads the load
    /// best: `loads` are the occupied blocks with what each costs.
    pub fn automatic(level: &Level, wanted: usize, loads: &[(BlockIndex, u64)]) -> [usize; 3] {
        let columns = level.block_columns();
        let mut counts = [1; 3];
        while counts.iter().product::<usize>() < wanted {
            let halved = |axis: usize| {
                let mut counts = counts;
                counts[axis] *= 2;
                let heaviest = Self::new(level, counts).map(|it| it.loads(loads).into_iter().max());
                // of two that are as good, the one that cuts the longer side
                heaviest.map(|most| (most, Reverse(columns[axis] / counts[axis]), axis)).ok()
            };
            let Some((.., axis)) = (0..3).filter_map(halved).min() else { break };
            counts[axis] *= 2;
        }
        counts
    }

    /// What the blocks of each patch cost together.
    pub fn loads(&self, blocks: &[(BlockIndex, u64)]) -> Vec<u64> {
        let mut loads = vec![0; self.patches.len()];
        for &(block, load) in blocks {
            self.owner(block).into_iter().for_each(|patch| loads[patch] += load);
        }
        loads
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn holders_are_the_owners_of_blocks_in_the_level() {
        let level = Level { lower: [0.0; 3], cell: 1.0, cells: [40, 20, 0] };
        let patches = Decomposition::new(&level, [4, 2, 1]).expect("patches that fit");
        for side in 1..=4 {
            for lower in level.blocks().grown(-side + 1).iter() {
                let blocks = IndexBox { lower, upper: lower.map(|i| i + side) }.grown(1);
                let owners: BTreeSet<usize> =
                    blocks.iter().filter_map(|block| patches.owner(block)).collect();
                assert!(patches.holders(blocks).eq(owners), "{blocks:?}");
            }
        }
    }

    #[test]
    fn more_than_can_be_numbered_is_refused() {
        let level = Level { lower: [0.0; 3], cell: 1.0, cells: [1 << 20; 3] };
        let refused = |counts| Decomposition::new(&level, counts).expect_err("too many");
        let error = refused([1; 3]);
        for fact in ["1.801e16 blocks", "4294967294", "--patches"] {
            assert!(error.contains(fact), "{error}");
        }
        let error = refused([1 << 18, 1 << 18, 1 << 18]);
        assert!(error.contains("262144x262144x262144 patches") && error.contains("16777216"), "{error}");
        // so many, but not more
        let thin = Level { cells: [1 << 20, 1 << 20, 4], ..level };
        assert!(
            Decomposition::new(&thin, [1 << 12, 1 << 13, 1]).expect_err("2^25 of them").contains("16777216")
        );
        let fits = Decomposition::new(&thin, [64, 64, 1]).expect("they can be numbered");
        assert!(fits.patches.iter().all(|patch| patch.blocks.len() <= MOST_BLOCKS));
    }
}
