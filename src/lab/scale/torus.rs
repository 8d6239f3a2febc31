//! Weak scaling: ranks that all look the same, in a torus.
use super::load::{Counts, Edge, Load, Ranks};
use super::model::Costs;
use grid::curve;

/// A typical rank: a brick of full blocks.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Brick {
    /// Particles by material.
    pub particles: Vec<f64>,
    /// Blocks of particles, of all materials.
    pub blocks: f64,
    /// Blocks of nodes of one material for each block of particles.
    pub nodes: f64,
    /// How many layers of nodes below and above a block its particles reach.
    pub reach: [f64; 2],
    /// Buffers that a block sends: one, and one more near another material.
    pub buffers: f64,
    /// Patches.
    pub patches: f64,
}

impl Brick {
    /// The same, `workers` times as large.
    pub fn times(&self, workers: usize) -> Self {
        let factor = workers as f64;
        Self {
            particles: self.particles.iter().map(|count| factor * count).collect(),
            blocks: factor * self.blocks,
            patches: factor * self.patches,
            ..self.clone()
        }
    }

    /// Blocks along a side.
    fn side(&self) -> f64 {
        self.blocks.cbrt()
    }

    /// Bytes of sums that go to the neighbor in direction `d`.
    fn sums(&self, d: [i32; 3]) -> f64 {
        let (n, [below, above]) = (self.side(), self.reach);
        // lines along an axis from all blocks to their neighbors that lie beyond the face, or not
        let along = |d: i32| match d {
            -1 => below,
            1 => above,
            // to the block itself, and to those beside it that are in the brick
            _ => 4.0 * n + (n - 1.0).max(0.0) * (below + above),
        };
        let lines: f64 = d.iter().map(|&d| along(d)).product();
        let givers: f64 = d.iter().map(|&d| if d == 0 { n } else { 1.0 }).product();
        LINE * (self.buffers * lines + givers)
    }

    /// Bytes of motion of nodes that the neighbor in direction `d` reads: what its particles reach here.
    fn motion(&self, d: [i32; 3]) -> f64 {
        let (n, [below, above]) = (self.side(), self.reach);
        // who sits above reaches down
        let along = |d: i32| match d {
            -1 => above,
            1 => below,
            _ => 4.0 * n,
        };
        LINE * d.iter().map(|&d| along(d)).product::<f64>()
    }

    /// Its counts, if it has neighbors along some axes: blocks of two layers at each face are on the rim, for they give to
    /// nodes of the neighbor or to nodes that it gives to.
    fn counts(&self, open: [bool; 3]) -> Counts {
        let n = self.side();
        let inside = |layers: f64| -> f64 {
            open.iter().map(|&open| if open { (n - 2.0 * layers).max(0.0) / n } else { 1.0 }).product()
        };
        let (blocks, nodes) = (self.blocks * inside(2.0), self.blocks * self.nodes);
        Counts {
            particles: self
                .particles
                .iter()
                .map(|count| [count * (1.0 - inside(2.0)), count * inside(2.0)])
                .collect(),
            nodes: [nodes * (1.0 - inside(1.0)), nodes * inside(1.0)],
            blocks: [self.blocks - blocks, blocks],
            patches: self.patches,
        }
    }
}

/// Bytes of a line of nodes.
const LINE: f64 = 64.0;

/// Ranks in a torus that is as close to a cube as their number allows, numbered along a Hilbert curve, as patches are.
pub struct Torus {
    sides: [usize; 3],
    load: Load,
    /// Direction, sums and motion.
    ways: Vec<([i32; 3], f64, f64)>,
    /// Where a rank is, and who is there.
    cells: Vec<u32>,
    ranks: Vec<u32>,
}

impl Torus {
    /// `count` ranks of `threads` workers.
    pub fn new(brick: &Brick, costs: &Costs, count: usize, threads: usize) -> Self {
        let sides = cube(count);
        let place = |cell: usize| [cell / (sides[1] * sides[2]), cell / sides[2] % sides[1], cell % sides[2]];
        let mut cells: Vec<u32> = (0..count as u32).collect();
        cells.sort_by_key(|&cell| curve(place(cell as usize).map(|i| i as u32)));
        let mut ranks = vec![0; count];
        cells.iter().enumerate().for_each(|(rank, &cell)| ranks[cell as usize] = rank as u32);
        let directions = (0..27).map(|q| [q / 9 - 1, q / 3 % 3 - 1, q % 3 - 1]).filter(|d| *d != [0; 3]);
        let ways = directions.map(|d| (d, brick.sums(d), brick.motion(d))).collect();
        let load = brick.counts(sides.map(|side| side > 1)).load(costs, threads);
        Self { sides, load, ways, cells, ranks }
    }
}

impl Ranks for Torus {
    fn count(&self) -> usize {
        self.cells.len()
    }

    fn load(&self, _rank: usize) -> Load {
        self.load
    }

    fn edges(&self, rank: usize, edges: &mut Vec<Edge>) {
        edges.clear();
        let [_, ny, nz] = self.sides;
        let cell = self.cells[rank] as usize;
        let here = [cell / (ny * nz), cell / nz % ny, cell % nz];
        for &(d, sums, motion) in &self.ways {
            let there: [usize; 3] = std::array::from_fn(|a| {
                (here[a] + self.sides[a]).wrapping_add_signed(d[a] as isize) % self.sides[a]
            });
            let to = self.ranks[(there[0] * ny + there[1]) * nz + there[2]];
            if to as usize == rank {
                continue;
            }
            // what goes to the same rank in several directions is one message
            let more = Edge { to, sums: sums as f32, motion: motion as f32 };
            match edges.iter_mut().find(|edge| edge.to == to) {
                Some(edge) => (edge.sums, edge.motion) = (edge.sums + more.sums, edge.motion + more.motion),
                None => edges.push(more),
            }
        }
    }
}

/// Three factors of a number that are as close together as they can be, in falling order.
fn cube(count: usize) -> [usize; 3] {
    let mut best = [count, 1, 1];
    let divisors = |n: usize| (1..=n.isqrt()).filter(move |d| n.is_multiple_of(*d));
    for a in divisors(count) {
        for b in divisors(count / a).filter(|&b| b >= a) {
            let sides = [count / a / b, b, a];
            if sides[0] >= b && sides.iter().sum::<usize>() < best.iter().sum() {
                best = sides;
            }
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brick() -> Brick {
        Brick {
            particles: vec![1e4],
            blocks: 64.0,
            nodes: 1.5,
            reach: [0.0, 2.0],
            buffers: 1.0,
            patches: 1.0,
        }
    }

    #[test]
    fn sides_are_as_close_as_can_be() {
        assert_eq!(cube(1), [1, 1, 1]);
        assert_eq!(cube(12), [3, 2, 2]);
        assert_eq!(cube(7), [7, 1, 1]);
        assert_eq!(cube(100_000), [50, 50, 40]);
    }

    #[test]
    fn what_is_sent_is_received_and_neighbors_are_different_ranks() {
        for count in [1, 2, 3, 8, 27, 60] {
            let torus = Torus::new(&brick(), &Costs::default(), count, 1);
            let (mut sent, mut came, mut edges) = (vec![0.0; count], vec![0.0; count], Vec::new());
            for rank in 0..count {
                torus.edges(rank, &mut edges);
                assert!(edges.len() <= 26 && edges.iter().all(|edge| edge.to as usize != rank));
                for edge in &edges {
                    sent[rank] += edge.sums;
                    came[edge.to as usize] += edge.sums;
                }
            }
            assert!(
                sent.iter().zip(&came).all(|(a, b)| (a - b).abs() <= 1e-3 * a),
                "{count}: {sent:?} {came:?}"
            );
        }
    }

    #[test]
    fn a_face_sends_the_two_layers_above_it_of_every_block() {
        // 4 x 4 blocks; each gives 2 lines above it times 4 + 2 of its own and of its neighbors on both other axes
        let n = 4.0;
        let lines = 2.0 * (4.0 * n + 2.0 * (n - 1.0_f64)).powi(2);
        assert_eq!(brick().sums([1, 0, 0]), LINE * (lines + n * n));
        assert_eq!(brick().motion([-1, 0, 0]), LINE * 2.0 * 256.0);
        assert_eq!(brick().motion([1, 0, 0]), 0.0);
    }
}
