//! What the fixed order of summation costs: the sweep that feeds the nodes, followed by node sums in the order that no
//! decomposition changes, against the same sweep with each block's buffer added to the nodes as soon as it is full.
use super::report::Order;
use crate::simulation::Simulation;
use engine::data::brief::Brief;
use engine::data::fields::FieldId;
use engine::data::nodes::{NOWHERE, is_there};
use engine::data::particles::ParticleBlock;
use engine::data::schedule::Schedule;
use engine::data::warehouse::{NodePatch, ParticlePatch};
use engine::exec::Serial;
use engine::exec::buffers::Buffers;
use engine::exec::halo::{Pencils, back, lines, pencils};
use engine::exec::scratch::Scratch;
use engine::exec::stage::{Context, sweep};
use engine::exec::step::context;
use engine::exec::sums::{Around, SumPartials};
use engine::exec::wave;
use engine::graph::phase::{Stage, When};
use engine::schema::LabelId;
use simd::{Job, Simd, Wide};
use std::ops::Range;
use std::time::Instant;

/// Repetitions of both ways in turn; the best of each counts.
const REPEAT: usize = 7;

/// Measures both ways on one thread, on the present state, which stays as it is.
pub fn order(simulation: &mut Simulation) -> Order {
    let (count, isa) = (simulation.warehouse.particle_count() as f64, simulation.isa());
    let (graph, warehouse) = (simulation.program.main_graph(), &mut simulation.warehouse);
    if warehouse.reactivate {
        warehouse.activate(&Serial);
    }
    let (slabs, materials) = (wave::slabs(warehouse, 1), warehouse.materials.len());
    let (schedule, buffers) = (Schedule::everyone(materials), Buffers::default());
    let scratch = Scratch::new(warehouse);
    let (context, _, blocks) = context(graph, warehouse, (isa, &schedule, &buffers));
    let layout = context.node_layout;
    let sums = |present: usize| {
        let lines = |label: &LabelId| vec![Wide::default(); layout.nodes * label.width() * present];
        layout.partial().iter().map(lines).collect()
    };
    let of_patch = |patch: &NodePatch| patch.blocks.iter().map(|block| sums(block.present.len())).collect();
    let particles = blocks.particles;
    let mut trial = Trial {
        context,
        stages: graph.phases.iter().flat_map(|p| &p.stages).filter(|s| s.when == When::Begin).collect(),
        sums: blocks.nodes.iter().map(of_patch).collect(),
        nodes: blocks.nodes,
        scratch,
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

/// Node sums of a block, for each label to which particles add.
type Sums = Vec<Vec<Wide>>;

struct Trial<'a> {
    context: Context<'a>,
    /// Those that feed the nodes.
    stages: Vec<&'a Stage>,
    nodes: &'a [NodePatch],
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
        for homes in particles.iter_mut() {
            for (material, home) in homes.iter_mut().enumerate() {
                let Some(&stage) = self.stages.iter().find(|s| s.material == Some(material)) else {
                    continue;
                };
                for (block, brief) in home.slab_mut(slab) {
                    work(self, stage, block);
                    *brief = Brief::of(block, self.context.shape);
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
            for at in nodes.slab(slab) {
                let block = &nodes.blocks[at];
                let pairs = block.present.iter().zip(&block.around).enumerate();
                for (slot, (&id, around)) in pairs {
                    let Context { isa, shape, fields, node_layout, .. } = &self.context;
                    let material = fields.material(id);
                    let field = id.index() - fields.of(material).start;
                    let labels = node_layout.partial().iter().enumerate();
                    for (place, &label) in labels.filter(|(_, l)| is_there(**l, block.present.len())) {
                        let (width, combine) = (label.width(), label.combine());
                        let length = node_layout.nodes * width;
                        let sums = &mut self.sums[patch][at][place][slot * length..(slot + 1) * length];
                        let from = Around { place, material, field, width, shape, particles, around };
                        isa.dispatch(SumPartials { from, touching: from.touching(), combine, sums });
                    }
                }
            }
        }
    }

    fn add(&mut self, stage: &Stage, block: &ParticleBlock) {
        let Some(material) = stage.material else { return };
        let Context { isa, shape, fields, node_layout, .. } = &self.context;
        for (number, field) in fields.of(material).map(FieldId::new).enumerate() {
            let partials = block.partials.iter().zip(node_layout.partial()).enumerate();
            for (place, (partial, label)) in partials.filter(|(_, (partial, _))| !partial.is_empty()) {
                let (width, length) = (label.width(), node_layout.nodes * label.width());
                let buffer = node_layout.buffer * width;
                let partial = &partial[number * buffer..(number + 1) * buffer];
                for (q, &(patch, at)) in block.around.iter().enumerate().filter(|(_, n)| **n != NOWHERE) {
                    let nodes = &self.nodes[patch as usize].blocks[at as usize];
                    let Some(slot) = nodes.slot(field) else { continue };
                    let sums = &mut self.sums[patch as usize][at as usize][place];
                    let sums = &mut sums[slot * length..(slot + 1) * length];
                    let pencils = pencils(shape, back(q), &block.touched);
                    isa.dispatch(Add { pencils, partial, width, sums });
                }
            }
        }
    }
}

/// Adds what a block adds to the nodes of one around.
struct Add<'a> {
    pencils: Pencils,
    partial: &'a [Wide],
    width: usize,
    sums: &'a mut [Wide],
}

impl Job for Add<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        for (own, here) in self.pencils {
            let (own, here) = (lines(own, self.width), lines(here, self.width));
            for (sum, part) in self.sums[own].iter_mut().zip(&self.partial[here]) {
                (S::load(sum) + S::load(part)).store(sum);
            }
        }
    }
}
