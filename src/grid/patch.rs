use super::{BlockIndex, IndexBox, Level};
use std::cmp::Reverse;
use std::collections::BTreeMap;

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
        let cut = |a: usize| (0..=counts[a]).map(|i| (i * columns[a] / counts[a]) as i32).collect();
        Ok(Self::with(level, std::array::from_fn(cut)))
    }

    /// The patches between some cuts along each axis; the first and the last one reach to the ends of the level.
    fn with(level: &Level, mut cuts: [Vec<i32>; 3]) -> Self {
        let (all, counts) = (level.blocks(), cuts.each_ref().map(|cuts| cuts.len() - 1));
        for (a, cuts) in cuts.iter_mut().enumerate() {
            (cuts[0], cuts[counts[a]]) = (all.lower[a], all.upper[a]);
        }
        let [nx, ny, nz] = counts;
        let indices = (0..nx * ny * nz).map(|id| [id / (ny * nz), id / nz % ny, id % nz]);
        let patches = indices.enumerate().map(|(id, index)| {
            let corner = |shift: usize| std::array::from_fn(|a| cuts[a][index[a] + shift]);
            Patch { id, index, blocks: IndexBox { lower: corner(0), upper: corner(1) } }
        });
        let patches = patches.collect();
        Self { counts, patches, cuts }
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

    /// About `wanted` patches, cut where that spreads the load best, wherever in the level it lies: `loads` are the occupied blocks
    /// with what each costs. There are fewer where layers of blocks would be left without any, but at least `least`, if the level has
    /// so many blocks.
    pub fn automatic(level: &Level, wanted: usize, least: usize, loads: &[(BlockIndex, u64)]) -> Self {
        let (columns, marginals) = (level.block_columns(), Marginal::all(level, loads));
        let cuts = |counts: [usize; 3]| [0, 1, 2].map(|a| marginals[a].cuts(counts[a], columns[a]));
        let places =
            |(block, load): &(BlockIndex, u64)| ([0, 1, 2].map(|a| marginals[a].place(block[a])), *load);
        let places: Vec<([usize; 3], u64)> = loads.iter().map(places).collect();
        let heaviest = |counts: [usize; 3]| {
            let (cuts, mut sums) = (cuts(counts), vec![0; counts.iter().product()]);
            let pieces = [0, 1, 2].map(|a| marginals[a].pieces(&cuts[a]));
            for (place, load) in &places {
                sums[(0..3).fold(0, |id, a| id * counts[a] + pieces[a][place[a]])] += load;
            }
            sums.into_iter().max()
        };
        let mut counts = [1; 3];
        for (wanted, occupied) in [(wanted.max(least), true), (least, false)] {
            let most = |a: usize| if occupied { marginals[a].layers.len() } else { columns[a] };
            while counts.iter().product::<usize>() < wanted.min(MOST_PATCHES / 2) {
                let halved = |axis: usize| {
                    let mut counts = counts;
                    counts[axis] *= 2;
                    // of two that are as good, the one that cuts the longer side
                    (heaviest(counts), Reverse(most(axis) / counts[axis]), axis)
                };
                let possible = (0..3).filter(|&axis| 2 * counts[axis] <= most(axis));
                let Some((.., axis)) = possible.map(halved).min() else { break };
                counts[axis] *= 2;
            }
        }
        Self::with(level, cuts(counts))
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

/// The layers of blocks along an axis that hold something.
struct Marginal {
    /// They, ascending, with what each costs.
    layers: Vec<(i32, u64)>,
    /// The last layer of the level.
    last: i32,
}

impl Marginal {
    /// Those of some blocks along each axis; what lies beyond a face belongs to the last layer before it.
    fn all(level: &Level, loads: &[(BlockIndex, u64)]) -> [Self; 3] {
        let columns = level.block_columns();
        std::array::from_fn(|a| {
            let (last, mut layers) = (columns[a] as i32 - 1, BTreeMap::new());
            for (block, load) in loads {
                *layers.entry(block[a].clamp(0, last)).or_default() += load;
            }
            Self { layers: layers.into_iter().collect(), last }
        })
    }

    /// Which of them a layer of blocks is, if it holds something.
    fn place(&self, layer: i32) -> usize {
        self.layers.partition_point(|(other, _)| *other < layer.clamp(0, self.last))
    }

    /// The piece to which each of them belongs.
    fn pieces(&self, cuts: &[i32]) -> Vec<usize> {
        self.layers.iter().map(|(layer, _)| cuts.partition_point(|cut| cut <= layer) - 1).collect()
    }

    /// Cuts into so many pieces that cost about the same, none of them empty: in the middle between the layers that they part. Cuts
    /// all layers evenly if there are not so many that hold something.
    fn cuts(&self, pieces: usize, columns: usize) -> Vec<i32> {
        let layers = &self.layers;
        if pieces > layers.len() {
            return (0..=pieces).map(|i| (i * columns / pieces) as i32).collect();
        }
        let total: u64 = layers.iter().map(|(_, load)| load).sum();
        let (mut cuts, mut at, mut before) = (vec![0], 0, 0);
        for piece in 1..pieces {
            let wanted = (u128::from(total) * piece as u128 / pieces as u128) as u64;
            let most = layers.len() - (pieces - piece);
            let first = at;
            // one layer at least, and then while that comes nearer to what is wanted
            while at == first || at < most && before + layers[at].1 / 2 <= wanted {
                before += layers[at].1;
                at += 1;
            }
            cuts.push((layers[at - 1].0 + layers[at].0 + 1).div_euclid(2));
        }
        cuts.push(columns as i32);
        cuts
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
        let error = refused([1 << 18, 1 << 18, 1 << 18]);
        assert!(error.contains("262144x262144x262144 patches") && error.contains("16777216"), "{error}");
        // so many, but not more
        let thin = Level { cells: [1 << 20, 1 << 20, 4], ..level };
        assert!(
            Decomposition::new(&thin, [1 << 12, 1 << 13, 1]).expect_err("2^25 of them").contains("16777216")
        );
        assert_eq!(Decomposition::new(&level, [1; 3]).expect("one").patches.len(), 1);
    }

    /// The blocks of a box, each of which costs the same.
    fn filled(lower: BlockIndex, size: [i32; 3]) -> Vec<(BlockIndex, u64)> {
        let upper = std::array::from_fn(|a| lower[a] + size[a]);
        IndexBox { lower, upper }.iter().map(|index| (index, 512)).collect()
    }

    #[test]
    fn automatic_patches_are_cut_where_the_load_is() {
        let level = Level { lower: [0.0; 3], cell: 1.0, cells: [4096; 3] };
        // one small body, wherever it lies
        for lower in [[0; 3], [511; 3], [700, 3, 1016]] {
            let loads = filled(lower, [8, 4, 4]);
            let patches = Decomposition::automatic(&level, 16, 1, &loads);
            assert!(patches.loads(&loads).iter().all(|load| *load == 8 * 512), "{:?}", patches.cuts);
            assert_eq!(patches.patches.len(), 16);
            let reach = level.blocks();
            assert_eq!(patches.patches[0].blocks.lower, reach.lower);
            assert_eq!(patches.patches[15].blocks.upper, reach.upper);
        }
        // two that are far apart have room around them
        let loads = [filled([10; 3], [4, 4, 4]), filled([900, 10, 10], [4, 4, 4])].concat();
        let patches = Decomposition::automatic(&level, 2, 1, &loads);
        assert_eq!((patches.counts, patches.cuts[0][1]), ([2, 1, 1], 457));
        // a body of few blocks has few patches, unless there are more ranks
        let loads = filled([100; 3], [2, 2, 1]);
        assert_eq!(Decomposition::automatic(&level, 64, 3, &loads).counts, [2, 2, 1]);
        let forced = Decomposition::automatic(&level, 64, 7, &loads);
        assert!(forced.patches.len() >= 7);
        assert_eq!(forced.loads(&loads).iter().sum::<u64>(), 4 * 512);
    }

    #[test]
    fn automatic_patches_of_a_full_level_are_even() {
        let level = Level { lower: [0.0; 3], cell: 1.0, cells: [64, 32, 16] };
        let loads = filled([0; 3], [16, 8, 4]);
        let automatic = Decomposition::automatic(&level, 64, 1, &loads);
        assert_eq!(automatic, Decomposition::new(&level, [8, 4, 2]).expect("they fit"));
        assert_eq!(Decomposition::automatic(&level, 7, 1, &[]).counts, [1; 3]);
        assert_eq!(Decomposition::automatic(&level, 1 << 40, 1, &loads).counts, [16, 8, 4]);
    }
}
