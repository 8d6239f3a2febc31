//! Which rank has which patch: pieces of about equal cost of a curve through all patches.
use super::Decomposition;

/// The rank of each patch, seen from one rank.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Partition {
    /// This rank.
    pub rank: usize,
    /// Number of ranks.
    pub ranks: usize,
    /// The rank of each patch.
    of: Vec<u32>,
}

impl Partition {
    /// All `patches` patches on one rank.
    pub fn alone(patches: usize) -> Self {
        Self { rank: 0, ranks: 1, of: vec![0; patches] }
    }

    /// Patches as `of` says, seen from `rank` of `ranks`.
    pub fn new(of: Vec<u32>, rank: usize, ranks: usize) -> Self {
        debug_assert!(of.iter().all(|&r| (r as usize) < ranks));
        Self { rank, ranks, of }
    }

    /// Cuts the Hilbert curve through the patches into a piece a rank, such that the pieces cost about the same. Every
    /// rank gets a patch.
    ///
    /// # Errors
    /// Fewer patches than ranks.
    pub fn by_cost(
        decomposition: &Decomposition,
        costs: &[u64],
        rank: usize,
        ranks: usize,
    ) -> Result<Self, String> {
        let patches = decomposition.patches.len();
        if patches < ranks {
            return Err(format!(
                "{ranks} ranks cannot share {patches} patch{}: give --patches AxBxC with at least {ranks}, or start fewer ranks",
                if patches == 1 { "" } else { "es" }
            ));
        }
        let mut order: Vec<usize> = (0..patches).collect();
        order.sort_by_key(|&p| hilbert(decomposition.patches[p].index.map(|i| i as u32)));
        let ends = cut(&order.iter().map(|&p| costs[p]).collect::<Vec<_>>(), ranks);
        let mut of = vec![0; patches];
        for (position, &patch) in order.iter().enumerate() {
            of[patch] = ends.partition_point(|&end| end <= position) as u32;
        }
        Ok(Self { rank, ranks, of })
    }

    /// The rank of a patch.
    pub fn rank_of(&self, patch: usize) -> usize {
        self.of[patch] as usize
    }

    /// Whether the patch is on this rank.
    pub fn is_mine(&self, patch: usize) -> bool {
        self.rank_of(patch) == self.rank
    }

    /// The patches of this rank.
    pub fn mine(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.of.len()).filter(|&patch| self.is_mine(patch))
    }

    /// The largest cost of a rank over the mean.
    pub fn imbalance(&self, costs: &[u64]) -> f64 {
        let mut sums = vec![0.0; self.ranks];
        costs.iter().zip(&self.of).for_each(|(&cost, &rank)| sums[rank as usize] += cost as f64);
        let total: f64 = sums.iter().sum();
        let most = sums.into_iter().fold(0.0, f64::max);
        if total > 0.0 { most * self.ranks as f64 / total } else { 1.0 }
    }
}

/// Ends of `pieces` pieces of a chain, none empty, such that the dearest is as cheap as possible: by bisection over its
/// cost (A. Pınar, C. Aykanat, J. Parallel Distrib. Comput. 64, 2004, 974–996).
fn cut(costs: &[u64], pieces: usize) -> Vec<usize> {
    let total: u64 = costs.iter().sum();
    let (mut low, mut high) = (total / pieces as u64, total);
    while low < high {
        let middle = low + (high - low) / 2;
        match fits(costs, pieces, middle) {
            true => high = middle,
            false => low = middle + 1,
        }
    }
    greedy(costs, pieces, high)
}

fn fits(costs: &[u64], pieces: usize, most: u64) -> bool {
    let mut begin = 0;
    greedy(costs, pieces, most).into_iter().all(|end| {
        let piece = &costs[std::mem::replace(&mut begin, end)..end];
        piece.iter().sum::<u64>() <= most
    })
}

/// Ends of pieces that cost at most `most`, but for the last one; each leaves one element at least to those after it.
fn greedy(costs: &[u64], pieces: usize, most: u64) -> Vec<usize> {
    let mut ends = Vec::with_capacity(pieces + 1);
    let mut end = 0;
    for piece in 0..pieces - 1 {
        let last = costs.len() - (pieces - 1 - piece);
        let mut cost = costs[end];
        end += 1;
        while end < last && cost + costs[end] <= most {
            cost += costs[end];
            end += 1;
        }
        ends.push(end);
    }
    ends.push(costs.len());
    ends
}

/// Position on the Hilbert curve through a cube of 2²¹ points a side. J. Skilling, AIP Conf. Proc. 707, 2004, 381–387.
pub(super) fn hilbert(mut x: [u32; 3]) -> u64 {
    const BITS: u32 = 21;
    for bit in (1..BITS).rev() {
        let (q, below) = (1 << bit, (1 << bit) - 1);
        for axis in 0..3 {
            if x[axis] & q != 0 {
                x[0] ^= below;
            } else {
                let swapped = (x[0] ^ x[axis]) & below;
                x[0] ^= swapped;
                x[axis] ^= swapped;
            }
        }
    }
    // Gray code
    x[1] ^= x[0];
    x[2] ^= x[1];
    let flips = (1..BITS).filter(|bit| x[2] >> bit & 1 == 1).fold(0, |flips, bit| flips ^ ((1 << bit) - 1));
    let x = x.map(|x| x ^ flips);
    (0..BITS).rev().flat_map(|bit| x.map(|x| u64::from(x >> bit & 1))).fold(0, |key, bit| key << 1 | bit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Level;

    #[test]
    fn the_curve_visits_every_point_once_and_goes_to_neighbors() {
        let mut points: Vec<[u32; 3]> = (0..512).map(|i| [i / 64, i / 8 % 8, i % 8]).collect();
        points.sort_by_key(|&x| hilbert(x));
        for (i, (a, b)) in points.iter().zip(&points[1..]).enumerate() {
            assert_eq!(hilbert(*a), i as u64);
            assert_eq!((0..3).map(|k| a[k].abs_diff(b[k])).sum::<u32>(), 1, "{a:?} {b:?}");
        }
    }

    #[test]
    fn pieces_are_never_empty_and_the_dearest_is_as_cheap_as_can_be() {
        assert_eq!(cut(&[1; 8], 4), [2, 4, 6, 8]);
        assert_eq!(cut(&[9, 1, 1, 1], 2), [1, 4]);
        assert_eq!(cut(&[0, 0, 0], 3), [1, 2, 3]);
        assert_eq!(cut(&[5, 5, 5, 1, 1, 1], 3), [1, 2, 6]);
        assert_eq!(cut(&[0, 0, 7], 2), [2, 3]);
        assert_eq!(cut(&[7, 0, 0], 3), [1, 2, 3]);
    }

    #[test]
    fn every_rank_has_a_patch_or_the_error_names_both_numbers() {
        let level = Level { lower: [0.0; 3], cell: 1.0, cells: [16, 8, 8] };
        let patches = Decomposition::new(&level, [4, 2, 1]).expect("fits");
        for ranks in 1..=8 {
            let partition = Partition::by_cost(&patches, &[1; 8], 0, ranks).expect("enough patches");
            assert!((0..ranks).all(|rank| (0..8).any(|patch| partition.rank_of(patch) == rank)));
            assert!(partition.imbalance(&[1; 8]) <= 8.0_f64.div_euclid(ranks as f64).max(2.0));
        }
        let error = Partition::by_cost(&patches, &[1; 8], 0, 9).expect_err("too many ranks");
        assert!(error.contains("9 ranks") && error.contains("8 patches"), "{error}");
    }
}
