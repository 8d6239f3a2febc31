//! The toy once more, without the engine: plain loops over particles and nodes. Sums are taken block by block, in each block
//! from its first particle to its last.
use crate::state::{Start, State, wide};
use crate::toy::ROUNDS;
use std::collections::{BTreeMap, BTreeSet};

type Block = [i32; 3];
/// A node of a field.
type Node = ([i32; 3], usize);

/// How far from the rim of what a block reaches its particles leave it [cells].
const MARGIN: f64 = 1e-6;

#[derive(Clone)]
struct Particle {
    identity: u64,
    x: [f64; 3],
    velocity: [f64; 3],
    charge: f64,
    whole: f64,
    seen: [f64; 4],
    memory: Vec<f64>,
}

#[derive(Clone, Default)]
struct Kept {
    total: [f64; 3],
    sum: f64,
    own: f64,
    meet: f64,
}

struct Sums {
    stage: f64,
    tick: f64,
    weight: f64,
    step: [f64; 3],
    kept: f64,
    exact: i128,
    most: [f64; 2],
    first: [f64; 2],
}

const NOTHING: Sums = Sums {
    stage: 0.0,
    tick: 0.0,
    weight: 0.0,
    step: [0.0; 3],
    kept: 0.0,
    exact: 0,
    most: [f64::NEG_INFINITY; 2],
    first: [f64::INFINITY; 2],
};

pub struct Reference {
    cells: [usize; 3],
    fields: Vec<usize>,
    interacts: Vec<Vec<bool>>,
    /// Particles by material and block.
    blocks: BTreeMap<(usize, Block), Vec<Particle>>,
    nodes: BTreeMap<Node, Kept>,
    steps: f64,
    changed: f64,
}

fn smaller(into: &mut [f64; 2], key: [f64; 2]) {
    if (key[0], key[1]) < (into[0], into[1]) {
        *into = key;
    }
}

impl Sums {
    fn add(&mut self, it: &Self) {
        self.stage += it.stage;
        self.tick += it.tick;
        self.weight += it.weight;
        (0..3).for_each(|a| self.step[a] += it.step[a]);
        self.kept += it.kept;
        self.exact += it.exact;
        (0..2).for_each(|i| self.most[i] = self.most[i].max(it.most[i]));
        smaller(&mut self.first, it.first);
    }
}

impl Reference {
    pub fn new(start: &Start) -> Self {
        let (cells, fields, interacts) = (start.cells, start.fields.clone(), start.interacts.clone());
        let (blocks, nodes) = (BTreeMap::new(), BTreeMap::new());
        let mut it = Self { cells, fields, interacts, blocks, nodes, steps: 0.0, changed: 0.0 };
        for (identity, p) in (0..).zip(&start.particles) {
            let memory = vec![0.0; start.memory[p.material]];
            let seen = [0.0; 4];
            let (x, velocity, charge, whole) = (p.x, p.velocity, p.charge, p.whole);
            let block = it.block(x);
            let particle = Particle { identity, x, velocity, charge, whole, seen, memory };
            it.blocks.entry((p.material, block)).or_default().push(particle);
        }
        it
    }

    fn base(&self, x: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|a| if self.cells[a] == 0 { 0.0 } else { x[a].floor() })
    }

    fn block(&self, x: [f64; 3]) -> Block {
        self.owner(self.base(x).map(|n| n as i32))
    }

    fn owner(&self, node: [i32; 3]) -> Block {
        [0, 1, 2].map(|a| if self.cells[a] == 0 { 0 } else { node[a].div_euclid(4) })
    }

    /// The nodes of a particle's field that it touches, and its weights there.
    fn corners(&self, material: usize, p: &Particle) -> Vec<(Node, f64)> {
        let base = self.base(p.x);
        let field =
            self.fields[..material].iter().sum::<usize>() + p.identity as usize % self.fields[material];
        let count = self.cells.map(|n| if n == 0 { 1 } else { 2 });
        let mut corners = Vec::new();
        for (i, j, k) in (0..8).map(|n| (n / 4, n / 2 % 2, n % 2)) {
            let at = [i, j, k];
            if (0..3).any(|a| at[a] >= count[a]) {
                continue;
            }
            let node = [0, 1, 2].map(|a| base[a] as i32 + at[a]);
            let s = [0, 1, 2].map(|a| {
                let t = if self.cells[a] == 0 { 0.0 } else { p.x[a] - base[a] };
                if at[a] == 1 { t } else { 1.0 - t }
            });
            corners.push(((node, field), s[0] * s[1] * s[2]));
        }
        corners
    }

    /// What `each` adds to nodes, block by block of those that are `wanted`.
    fn sum<T>(
        &self,
        nothing: impl Fn() -> T,
        wanted: impl Fn(&(usize, Block)) -> bool,
        each: impl Fn(&mut T, &Particle, f64),
        add: impl Fn(&mut T, &T),
    ) -> BTreeMap<Node, T> {
        let mut sums = BTreeMap::new();
        for (key, particles) in self.blocks.iter().filter(|(key, _)| wanted(key)) {
            let mut partial: BTreeMap<Node, T> = BTreeMap::new();
            for p in particles {
                for (node, s) in self.corners(key.0, p) {
                    each(partial.entry(node).or_insert_with(&nothing), p, s);
                }
            }
            partial.iter().for_each(|(node, part)| add(sums.entry(*node).or_insert_with(&nothing), part));
        }
        sums
    }

    /// Runs `each(particle, corners)` on all particles of the blocks that are `wanted`.
    fn read(
        &mut self,
        wanted: impl Fn(&(usize, Block)) -> bool,
        each: impl Fn(&mut Particle, &[(Node, f64)]),
    ) {
        let mut blocks = std::mem::take(&mut self.blocks);
        for ((material, _), particles) in blocks.iter_mut().filter(|(key, _)| wanted(key)) {
            particles.iter_mut().for_each(|p| each(p, &self.corners(*material, p)));
        }
        self.blocks = blocks;
    }

    /// Whether a block of a material with which this one interacts is at most two blocks away: itself, if its fields do.
    fn near(&self) -> BTreeSet<(usize, Block)> {
        let close = |a: &Block, b: &Block| (0..3).all(|i| (a[i] - b[i]).abs() <= 2);
        let meets = |(m, block): &(usize, Block)| {
            self.blocks.keys().any(|(other, b)| self.interacts[*m][*other] && close(block, b))
        };
        self.blocks.keys().copied().filter(meets).collect()
    }

    /// The fields of the blocks of nodes that are there.
    fn present(&self) -> BTreeMap<Block, BTreeSet<usize>> {
        let mut present: BTreeMap<Block, BTreeSet<usize>> = BTreeMap::new();
        for (material, block) in self.blocks.keys() {
            let first = self.fields[..*material].iter().sum::<usize>();
            for n in 0..27 {
                let around = [block[0] + n / 9 - 1, block[1] + n / 3 % 3 - 1, block[2] + n % 3 - 1];
                present.entry(around).or_default().extend(first..first + self.fields[*material]);
            }
        }
        present
    }

    pub fn step(&mut self) {
        self.forget();
        let nodes = std::mem::take(&mut self.nodes);
        let total = |node: &Node| nodes.get(node).map_or([0.0; 3], |kept| kept.total);
        self.read(
            |_| true,
            |p, corners| corners.iter().for_each(|(node, s)| p.seen[0] += s * total(node)[2]),
        );
        self.nodes = nodes;
        for kept in self.nodes.values_mut() {
            kept.total.iter_mut().for_each(|x| *x *= 0.5);
            (kept.own, kept.sum) = (kept.own * 0.75, 0.0);
        }
        let mut values = self.give();
        self.meet();
        self.steps += 1.0;
        (0..ROUNDS as usize).for_each(|_| self.round(&mut values));
        self.shift(&values);
    }

    /// Sums, what nodes keep of them, and what particles read; returns what rounds change, and the whole numbers.
    fn give(&mut self) -> BTreeMap<Node, [f64; 2]> {
        let each = |sums: &mut Sums, p: &Particle, s: f64| {
            let q = p.charge;
            sums.stage += s * q;
            sums.tick += s * q;
            sums.weight += s;
            (0..3).for_each(|a| sums.step[a] += s * q * p.x[a]);
            sums.kept += s * s * q;
            sums.exact += p.whole as i128;
            sums.most = [sums.most[0].max(q), sums.most[1].max(-q)];
            smaller(&mut sums.first, [q, p.identity as f64]);
        };
        let sums = self.sum(|| NOTHING, |_| true, each, Sums::add);
        let (mut read, mut values) = (BTreeMap::new(), BTreeMap::new());
        for (node, it) in sums {
            let kept = self.nodes.entry(node).or_default();
            kept.sum = it.kept;
            if it.weight > 0.0 {
                read.insert(node, [it.stage / it.weight, it.most[0] + 4.0 * it.most[1]]);
                values.insert(node, [it.first[0] + it.first[1] - it.first[0], it.exact as f64]);
                (0..3).for_each(|a| kept.total[a] += it.step[a]);
                kept.own += (it.tick - 2.0 * it.kept + 1.0) * it.weight;
            }
        }
        let value = |node: &Node| read.get(node).copied().unwrap_or_default();
        self.read(
            |_| true,
            |p, corners| {
                for (node, s) in corners {
                    p.seen[1] += s * value(node)[0];
                    p.seen[1] += s * value(node)[1];
                }
            },
        );
        values
    }

    /// The same where fields meet.
    fn meet(&mut self) {
        let (near, present) = (self.near(), self.present());
        let mut sums = self.sum(
            || 0.0,
            |key| near.contains(key),
            |sum, p, s| *sum += s * p.charge,
            |a: &mut f64, b| *a += b,
        );
        sums.retain(|(node, _), _| present[&self.owner(*node)].len() > 1);
        sums.iter().for_each(|(node, sum)| self.nodes.entry(*node).or_default().meet += sum);
        let value = |node: &Node| sums.get(node).copied().unwrap_or_default();
        self.read(
            |key| near.contains(key),
            |p, corners| corners.iter().for_each(|(node, s)| p.seen[2] += s * value(node)),
        );
    }

    fn round(&mut self, values: &mut BTreeMap<Node, [f64; 2]>) {
        let value = |node: &Node| values.get(node).map_or(0.0, |v| v[0]);
        // what each particle reads comes first, and stands in for its charge
        let mut sums: BTreeMap<Node, f64> = BTreeMap::new();
        for (key, particles) in &self.blocks {
            let mut partial: BTreeMap<Node, f64> = BTreeMap::new();
            for p in particles {
                let corners = self.corners(key.0, p);
                let here: f64 = corners.iter().map(|(node, s)| s * value(node)).sum();
                corners.iter().for_each(|(node, s)| *partial.entry(*node).or_default() += s * here);
            }
            partial.iter().for_each(|(node, part)| *sums.entry(*node).or_default() += part);
        }
        self.changed = sums.values().filter(|sum| **sum != 0.0).count() as f64;
        for (node, sum) in sums {
            let value = values.entry(node).or_default();
            value[0] = 0.5 * value[0] + 0.125 * sum;
        }
    }

    /// Particles read and move, and come to other blocks.
    fn shift(&mut self, values: &BTreeMap<Node, [f64; 2]>) {
        let way = if self.steps % 4.0 < 2.0 { -1.0 } else { 1.0 };
        let (cells, nodes) = (self.cells, std::mem::take(&mut self.nodes));
        self.read(
            |_| true,
            |p, corners| {
                for (node, s) in corners {
                    let [value, whole] = values.get(node).copied().unwrap_or_default();
                    p.seen[3] += s * value;
                    p.seen[3] += s * (whole + nodes.get(node).map_or(0.0, |kept| kept.total[0]));
                }
                (0..p.memory.len()).for_each(|n| p.memory[n] = 0.5 * p.memory[n] + n as f64);
                (0..3).for_each(|a| p.x[a] = (p.x[a] + way * p.velocity[a]).clamp(0.0, cells[a] as f64));
            },
        );
        self.nodes = nodes;
        let mut arriving = Vec::new();
        for ((material, block), particles) in std::mem::take(&mut self.blocks) {
            let out = |a: usize, x: f64| {
                let first = f64::from(4 * block[a] - 1);
                cells[a] > 0 && !(x >= first + MARGIN && x < first + 6.0 - MARGIN)
            };
            let leaves = |p: &Particle| (0..3).any(|a| out(a, p.x[a]));
            arriving.extend(particles.iter().filter(|p| leaves(p)).map(|p| (material, p.clone())));
            // the last ones take the places of those that leave
            let mut stay: Vec<Particle> = particles;
            let kept = stay.iter().filter(|p| !leaves(p)).count();
            let mut last = stay.split_off(kept).into_iter().filter(|p| !leaves(p));
            for p in stay.iter_mut().filter(|p| leaves(p)) {
                *p = last.next().expect("as many as have left before them");
            }
            self.blocks.insert((material, block), stay);
        }
        for (material, p) in arriving {
            let block = self.block(p.x);
            self.blocks.entry((material, block)).or_default().push(p);
        }
        self.blocks.retain(|_, particles| !particles.is_empty());
    }

    /// Nodes are there only where particles are around.
    fn forget(&mut self) {
        let present = self.present();
        let mut nodes = std::mem::take(&mut self.nodes);
        nodes.retain(|(node, field), _| present.get(&self.owner(*node)).is_some_and(|f| f.contains(field)));
        let meet = |node: &Node| present[&self.owner(node.0)].len() > 1;
        nodes.iter_mut().filter(|(node, _)| !meet(node)).for_each(|(_, kept)| kept.meet = 0.0);
        self.nodes = nodes;
    }

    /// All that passes from step to step, and what the run has reduced.
    pub fn state(&self) -> State {
        let mut state = State::default();
        for p in self.blocks.values().flatten() {
            let all = p.x.iter().chain(&p.seen).chain(&p.memory);
            state.particles.insert(p.identity, all.map(|x| x.to_bits()).collect());
        }
        for ((node, field), kept) in &self.nodes {
            let lane = |at: usize, x: f64| wide(|i| if i == at { x } else { 0.0 });
            state.node("Total", *field, *node, &kept.total.map(|x| lane(7, x)));
            state.node("KeptSum", *field, *node, &[lane(5, kept.sum)]);
            state.node("KeptOwn", *field, *node, &[lane(0, 0.0), lane(1, kept.own), lane(0, 0.0)]);
            state.node("MeetKept", *field, *node, &[lane(0, 0.0), lane(0, kept.meet)]);
        }
        self.reduced(&mut state);
        state
    }

    fn reduced(&self, state: &mut State) {
        let of = |wanted: Option<usize>| {
            let mine = self.blocks.iter().filter(move |((m, _), _)| wanted.is_none_or(|w| w == *m));
            mine.flat_map(|(_, particles)| particles)
        };
        let exact = |m, factor: i128| (factor * of(m).map(|p| p.whole as i128).sum::<i128>()) as f64;
        let most = |m, sign: f64| of(m).map(|p| sign * p.charge).fold(f64::NEG_INFINITY, f64::max);
        let first = |m, sign: f64| {
            let mut first = [f64::INFINITY; 2];
            of(m).for_each(|p| smaller(&mut first, [sign * p.charge, p.identity as f64]));
            let line = [first[0], first[1], -first[0]];
            if first[1].is_finite() {
                wide(|i| line.get(i).copied().unwrap_or(0.0))
            } else {
                wide(|_| f64::INFINITY)
            }
        };
        let lowest = f64::NEG_INFINITY;
        state.value("RunExact", &[exact(None, 1)]);
        state.line(
            "RunMost",
            &[wide(|i| {
                [(0, 1.0), (5, -1.0)].iter().find(|(at, _)| *at == i).map_or(lowest, |(_, s)| most(None, *s))
            })],
        );
        state.line("RunFirst", &[first(None, 1.0)]);
        state.line("Steps", &[wide(|i| if i == 0 { self.steps } else { 0.0 })]);
        state.line("Rounds", &[wide(|i| [ROUNDS, self.changed].get(i).copied().unwrap_or(0.0))]);
        let all = || 0..self.fields.len();
        let exacts: Vec<f64> = all().flat_map(|m| [exact(Some(m), 1), exact(Some(m), -2)]).collect();
        state.value("OwnExact", &exacts);
        let mosts = all()
            .flat_map(|m| [wide(|_| lowest), wide(|i| if i == 4 { most(Some(m), 1.0) } else { lowest })]);
        state.line("OwnMost", &mosts.collect::<Vec<_>>());
        state.line("OwnFirst", &all().map(|m| first(Some(m), -1.0)).collect::<Vec<_>>());
        let own = all().map(|m| wide(|i| if i == 3 { self.steps * (m + 1) as f64 } else { 0.0 }));
        state.line("OwnSteps", &own.collect::<Vec<_>>());
    }
}
