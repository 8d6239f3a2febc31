//! Weak scaling: ranks that all look the same, in a torus.
use super::load::{Counts, Load, Message, Ranks, TRAVELERS};
use super::model::Setup;
use super::step::Tick;
use engine::graph::exchange::Exchange;
use engine::graph::traffic::{Passing, Traffic};
use grid::curve;

/// A typical rank: a brick of full blocks.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Brick {
    /// Particles by material.
    pub particles: Vec<f64>,
    /// Blocks of particles by material.
    pub blocks: Vec<f64>,
    /// Blocks of nodes, by the materials of the fields that they hold.
    pub nodes: Vec<(Vec<usize>, f64)>,
    /// How many layers of nodes below and above a block its particles reach.
    pub reach: [f64; 2],
    /// Fields of each material.
    pub fields: Vec<usize>,
    /// The part of each material in all particles, away from other materials and near them.
    pub parts: Vec<[f64; 2]>,
    /// Patches.
    pub patches: f64,
}

impl Brick {
    /// The same, `workers` times as large.
    pub fn times(&self, workers: usize) -> Self {
        let factor = workers as f64;
        let scaled = |counts: &[f64]| counts.iter().map(|count| factor * count).collect();
        Self {
            particles: scaled(&self.particles),
            blocks: scaled(&self.blocks),
            nodes: self.nodes.iter().map(|(fields, count)| (fields.clone(), factor * count)).collect(),
            patches: factor * self.patches,
            ..self.clone()
        }
    }

    /// Blocks of particles, of all materials.
    pub fn all_blocks(&self) -> f64 {
        self.blocks.iter().sum()
    }

    /// Blocks along a side.
    fn side(&self) -> f64 {
        self.all_blocks().cbrt()
    }

    /// Nodes of the neighbor in direction `d` that blocks add to, and how many blocks do.
    fn added(&self, d: [i32; 3]) -> [f64; 2] {
        let (n, [below, above]) = (self.side(), self.reach);
        // nodes along an axis from all blocks to their neighbors that lie beyond the face, or not
        let along = |d: i32| match d {
            -1 => below,
            1 => above,
            // to the block itself, and to those beside it that are in the brick
            _ => 4.0 * n + (n - 1.0).max(0.0) * (below + above),
        };
        let givers = d.iter().map(|&d| if d == 0 { n } else { 1.0 }).product();
        [d.iter().map(|&d| along(d)).product(), givers]
    }

    /// Nodes that particles of the neighbor in direction `d` read: what they reach here.
    fn read(&self, d: [i32; 3]) -> f64 {
        let (n, [below, above]) = (self.side(), self.reach);
        // who sits above reaches down
        let along = |d: i32| match d {
            -1 => above,
            1 => below,
            _ => 4.0 * n,
        };
        d.iter().map(|&d| along(d)).product()
    }

    /// What passes to the neighbor in direction `d`, by material.
    fn passing(&self, d: [i32; 3]) -> Vec<Passing> {
        let ([added, adders], read) = (self.added(d), self.read(d));
        let materials = self.parts.iter().zip(&self.blocks);
        let passing = materials.map(|(part, blocks)| {
            // where others are near, several fields are
            let read = part.map(|part| (part * read) as u64);
            let adders = (adders * blocks / self.all_blocks()).ceil() as u64;
            Passing { adders, added: part.map(|part| (part * added) as u64), read, whole: read }
        });
        passing.collect()
    }

    /// What passes between it, which is rank 0, and its neighbors in some directions.
    fn traffic(&self, ways: &[[i32; 3]]) -> Traffic {
        let there = ways.iter().enumerate().map(|(way, &d)| ((0, way + 1), self.passing(d)));
        // who has added to nodes here reads them
        let back = ways.iter().enumerate().map(|(way, &d)| ((way + 1, 0), self.passing(d.map(|i| -i))));
        Traffic {
            ranks: ways.len() + 1,
            rank_of: (0..=ways.len()).collect(),
            fields: self.fields.iter().map(|&fields| fields as u64).collect(),
            to_rank: there.chain(back).collect(),
            ..Traffic::default()
        }
    }

    /// Its counts, if it has neighbors along some axes: blocks of two layers at each face are on the rim, for they give to
    /// nodes of the neighbor or to nodes that it gives to.
    fn counts(&self, open: [bool; 3]) -> Counts {
        let n = self.side();
        let inside = |layers: f64| -> f64 {
            open.iter().map(|&open| if open { (n - 2.0 * layers).max(0.0) / n } else { 1.0 }).product()
        };
        let (two, one) = (inside(2.0), inside(1.0));
        let parts = |counts: &[f64]| counts.iter().map(|count| [count * (1.0 - two), count * two]).collect();
        let nodes = self.nodes.iter();
        Counts {
            particles: parts(&self.particles),
            blocks: parts(&self.blocks),
            nodes: nodes
                .map(|(fields, count)| (fields.clone(), [count * (1.0 - one), count * one]))
                .collect(),
            patches: self.patches,
        }
    }
}

/// Ranks in a torus that is as close to a cube as their number allows, numbered along a Hilbert curve, as patches are.
pub struct Torus {
    sides: [usize; 3],
    /// By kind of tick.
    loads: Vec<Load>,
    ways: Vec<[i32; 3]>,
    /// Bytes by kind of tick, exchange and way.
    bytes: Vec<Vec<Vec<Option<f32>>>>,
    /// Where a rank is, and who is there.
    cells: Vec<u32>,
    ranks: Vec<u32>,
}

impl Torus {
    /// `count` ranks.
    pub fn new(brick: &Brick, setup: &Setup<'_>, count: usize) -> Self {
        let sides = cube(count);
        let place = |cell: usize| [cell / (sides[1] * sides[2]), cell / sides[2] % sides[1], cell % sides[2]];
        let mut cells: Vec<u32> = (0..count as u32).collect();
        cells.sort_by_key(|&cell| curve(place(cell as usize).map(|i| i as u32)));
        let mut ranks = vec![0; count];
        cells.iter().enumerate().for_each(|(rank, &cell)| ranks[cell as usize] = rank as u32);
        let directions = (0..27).map(|q| [q / 9 - 1, q / 3 % 3 - 1, q % 3 - 1]);
        let ways: Vec<[i32; 3]> = directions.filter(|d| *d != [0; 3]).collect();
        let (kinds, counts) = (&setup.step.kinds, brick.counts(sides.map(|side| side > 1)));
        let loads = kinds.iter().map(|tick| counts.load(setup, tick)).collect();
        let traffic = brick.traffic(&ways);
        let of = |exchange: &Exchange, tick: &Tick| {
            let pairs = traffic.exchange(exchange, |material| tick.sends(exchange, material));
            (1..=ways.len()).map(|way| pairs.get(&(0, way)).map(|it| it.bytes as f32)).collect()
        };
        let exchanges = &setup.step.graph.exchanges;
        let bytes = kinds.iter().map(|tick| exchanges.iter().map(|exchange| of(exchange, tick)).collect());
        let bytes = bytes.collect();
        Self { sides, loads, ways, bytes, cells, ranks }
    }

    /// The rank in a direction.
    fn neighbor(&self, rank: usize, d: [i32; 3]) -> u32 {
        let [_, ny, nz] = self.sides;
        let cell = self.cells[rank] as usize;
        let here = [cell / (ny * nz), cell / nz % ny, cell % nz];
        let there: [usize; 3] = std::array::from_fn(|a| {
            (here[a] + self.sides[a]).wrapping_add_signed(d[a] as isize) % self.sides[a]
        });
        self.ranks[(there[0] * ny + there[1]) * nz + there[2]]
    }
}

impl Ranks for Torus {
    fn count(&self) -> usize {
        self.cells.len()
    }

    fn load(&self, _rank: usize, kind: usize) -> &Load {
        &self.loads[kind]
    }

    fn sends(&self, rank: usize, kind: usize, exchange: Option<usize>, messages: &mut Vec<Message>) {
        messages.clear();
        for (way, &d) in self.ways.iter().enumerate() {
            let to = self.neighbor(rank, d);
            if to as usize == rank {
                continue;
            }
            let bytes = exchange.map_or(Some(0.0), |exchange| self.bytes[kind][exchange][way]);
            let Some(bytes) = bytes else { continue };
            // what goes to the same rank in several directions is one message
            match messages.iter_mut().find(|message| message.to == to) {
                Some(message) => message.bytes += bytes,
                None => messages.push(Message { to, bytes }),
            }
        }
        if exchange.is_none() {
            messages.iter_mut().for_each(|message| message.bytes = TRAVELERS);
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
            blocks: vec![64.0],
            nodes: vec![(vec![0], 96.0)],
            reach: [0.0, 2.0],
            fields: vec![1],
            parts: vec![[1.0, 0.0]],
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
    fn a_face_sends_the_two_layers_above_it_of_every_block() {
        // 4 x 4 blocks; each gives 2 lines above it times 4 + 2 of its own and of its neighbors on both other axes
        let n = 4.0;
        let lines = 2.0 * (4.0 * n + 2.0 * (n - 1.0_f64)).powi(2);
        assert_eq!(brick().added([1, 0, 0]), [lines, n * n]);
        assert_eq!(brick().read([-1, 0, 0]), 2.0 * 256.0);
        assert_eq!(brick().read([1, 0, 0]), 0.0);
    }
}
