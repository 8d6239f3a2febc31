//! What the fixed order of summation costs: the sweep that feeds the nodes, followed by node sums in the order that no
//! decomposition changes, against the same sweep with each block's buffer added to the nodes as soon as it is full.
use super::report::Order;
use crate::data::nodes::{NODES, NOWHERE};
use crate::data::particles::ParticleBlock;
use crate::data::schedule::Schedule;
use crate::data::warehouse::{NodePatch, ParticlePatch, Warehouse};
use crate::exec::buffers::Buffers;
use crate::exec::halo::{Around, SumPartials, back, pencils};
use crate::exec::scratch::Scratch;
use crate::exec::stage::{Context, SCATTERED, sweep};
use crate::exec::wave;
use crate::graph::fuse::{Stage, When};
use crate::simd::{Job, Simd, Wide};
use crate::simulation::Simulation;
use std::ops::Range;
use std::time::Instant;

/// Repetitions of both ways in turn; the best of each counts.
const REPEAT: usize = 7;

/// Measures both ways on one thread, on the present state, which stays as it is.
pub fn order(simulation: &mut Simulation) -> Order {
    let (count, isa) = (simulation.warehouse.particle_count() as f64, simulation.isa());
    let (graph, warehouse) = (&simulation.graph, &mut simulation.warehouse);
    if warehouse.stale {
        warehouse.activate();
    }
    let (slabs, materials) = (wave::slabs(warehouse, 1), warehouse.materials.len());
    let (schedule, buffers) = (Schedule::everyone(materials), Buffers::default());
    let sums = |present: usize| SCATTERED.map(|_| vec![Wide::default(); NODES * present]);
    let of_patch = |patch: &NodePatch| patch.blocks.iter().map(|block| sums(block.present.len())).collect();
    let Warehouse { level, decomposition, materials, particles, nodes, shared, .. } = warehouse;
    let mut trial = Trial {
        context: Context {
            isa,
            recipe: &graph.recipe,
            level,
            materials,
            schedule: &schedule,
            buffers: &buffers,
        },
        stages: graph.phases.iter().flat_map(|p| &p.stages).filter(|s| s.when == When::Begin).collect(),
        first: decomposition.patches.iter().map(|patch| patch.blocks.lower[0]).collect(),
        sums: nodes.iter().map(of_patch).collect(),
        nodes,
        scratch: Scratch::new(materials.len(), shared),
    };
    let (mut fixed, mut free) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..REPEAT {
        fixed = fixed.min(seconds(|| trial.fixed(particles, &slabs)));
        free = free.min(seconds(|| trial.free(particles, &slabs)));
    }
    Order { fixed_ns: 1e9 * fixed / count, free_ns: 1e9 * free / count }
}

fn seconds(work: impl FnOnce()) -> f64 {
    let began = Instant::now();
    work();
    began.elapsed().as_secs_f64()
}

/// Node sums of a block, for each scattered label.
type Sums = [Vec<Wide>; SCATTERED.len()];

struct Trial<'a> {
    context: Context<'a>,
    /// Those that feed the nodes.
    stages: Vec<&'a Stage>,
    nodes: &'a [NodePatch],
    /// First layer of each patch.
    first: Vec<i32>,
    sums: Vec<Vec<Sums>>,
    scratch: Scratch,
}

impl Trial<'_> {
    /// As a run does it: node sums follow the sweep slab by slab.
    fn fixed(&mut self, particles: &mut [Vec<ParticlePatch>], slabs: &[Range<i32>]) {
        for front in 0..slabs.len() + 2 {
            if let Some(slab) = slabs.get(front) {
                self.each(particles, slab, |trial, stage, block| trial.sweep(stage, block));
            }
            if let Some(slab) = front.checked_sub(1).and_then(|n| slabs.get(n)) {
                self.sum(particles, slab);
            }
            if let Some(slab) = front.checked_sub(2).and_then(|n| slabs.get(n)) {
                self.each(particles, slab, |trial, _, block| trial.put_back(block));
            }
        }
    }

    /// Each block's buffer goes to the nodes as soon as it is full, and is free for the next.
    fn free(&mut self, particles: &mut [Vec<ParticlePatch>], slabs: &[Range<i32>]) {
        self.sums.iter_mut().flatten().flatten().for_each(|lines| lines.fill(Wide::default()));
        for slab in slabs {
            self.each(particles, slab, |trial, stage, block| {
                trial.sweep(stage, block);
                trial.add(stage, block);
                trial.put_back(block);
            });
        }
    }

    fn each(
        &mut self,
        particles: &mut [Vec<ParticlePatch>],
        slab: &Range<i32>,
        mut work: impl FnMut(&mut Self, &Stage, &mut ParticleBlock),
    ) {
        for (patch, homes) in particles.iter_mut().enumerate() {
            for (material, home) in homes.iter_mut().enumerate() {
                let Some(&stage) = self.stages.iter().find(|s| s.material == Some(material)) else {
                    continue;
                };
                for block in home.slab_mut(self.first[patch], slab) {
                    work(self, stage, block);
                }
            }
        }
    }

    fn sweep(&mut self, stage: &Stage, block: &mut ParticleBlock) {
        sweep::<false>(&self.context, stage, self.nodes, &mut self.scratch, block);
    }

    fn put_back(&self, block: &mut ParticleBlock) {
        block.partials.iter_mut().for_each(|buffer| self.context.buffers.put_back(std::mem::take(buffer)));
    }

    fn sum(&mut self, particles: &[Vec<ParticlePatch>], slab: &Range<i32>) {
        for (patch, nodes) in self.nodes.iter().enumerate() {
            for at in nodes.slab(self.first[patch], slab) {
                let block = &nodes.blocks[at];
                let pairs = block.present.iter().zip(&block.around).enumerate();
                for (slot, (&material, around)) in pairs {
                    for (_, which) in SCATTERED.iter().filter(|(_, w)| *w == 0 || block.present.len() > 1) {
                        let (which, material) = (*which, material as usize);
                        let sums = &mut self.sums[patch][at][which][slot * NODES..(slot + 1) * NODES];
                        let from = Around { which, material, particles, around };
                        self.context.isa.dispatch(SumPartials { from, sums });
                    }
                }
            }
        }
    }

    fn add(&mut self, stage: &Stage, block: &ParticleBlock) {
        let Some(material) = stage.material else { return };
        for (_, which) in SCATTERED.iter().filter(|(_, which)| !block.partials[*which].is_empty()) {
            for (q, &(patch, at)) in block.around.iter().enumerate().filter(|(_, n)| **n != NOWHERE) {
                let present = &self.nodes[patch as usize].blocks[at as usize].present;
                let Some(slot) = present.iter().position(|&m| m as usize == material) else { continue };
                let sums = &mut self.sums[patch as usize][at as usize][*which];
                let sums = &mut sums[slot * NODES..(slot + 1) * NODES];
                self.context.isa.dispatch(Add { block, which: *which, q, sums });
            }
        }
    }
}

/// Adds what a block gives to the nodes of the `q`-th block around.
struct Add<'a> {
    block: &'a ParticleBlock,
    which: usize,
    q: usize,
    sums: &'a mut [Wide],
}

impl Job for Add<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let partial = &self.block.partials[self.which];
        pencils(back(self.q), &self.block.touched, |own, here| {
            for (sum, part) in self.sums[own].iter_mut().zip(&partial[here]) {
                (S::load(sum) + S::load(part)).store(sum);
            }
        });
    }
}
