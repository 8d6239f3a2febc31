//! Bytes that the tasks of a step move, by their declarations.
//!
//! In a sweep a column is read once, by the first task that touches it, and written back once, for the first task that
//! writes it; a column that is written without being read is fetched all the same (write-allocate). Node lines and
//! partial sums count as often as a sweep passes over them, in the blocks where they are. What lives in scratch (chunk
//! labels, regions, node sums) stays in cache and counts nothing. A column that a task needs for rare events alone
//! counts too: the numbers are upper bounds of what must move.
use engine::data::layout::ParticleLayout;
use engine::data::nodes::NodeBlock;
use engine::data::particles::ParticleBlock;
use engine::data::warehouse::Warehouse;
use engine::exec::meter::{StagePart, What};
use engine::graph::build::TaskGraph;
use engine::graph::phase::Stage;
use engine::graph::task::{Access, Domain};
use engine::schema::{Crossing, Home, LabelId};
use simd::Wide;

/// Lines moved, by what moves them.
#[derive(Debug, Default)]
pub struct Traffic(Vec<(What, usize)>);

/// Lines of a partial buffer that hold something.
fn used(block: &ParticleBlock, label: LabelId) -> usize {
    let there = block.near || !label.added_where_near();
    if there { label.width() * block.touched.len() } else { 0 }
}

impl Traffic {
    /// All traffic of one stage.
    pub fn of(graph: &TaskGraph, warehouse: &Warehouse, stage: &Stage) -> Self {
        let mut traffic = Self::default();
        match (stage.domain, stage.material) {
            (Domain::Nodes, _) => traffic.add_nodes(graph, warehouse, stage),
            (_, Some(material)) => {
                let layout = &warehouse.materials[material].layout;
                for (_, block) in warehouse.blocks().filter(|(m, _)| *m == material) {
                    traffic.add_columns(graph, stage, layout, block);
                    traffic.add_partials(stage, block);
                }
                traffic.add_regions(warehouse, stage, material);
            }
            _ => {}
        }
        traffic
    }

    /// Bytes that `what` moves.
    pub fn bytes(&self, what: What) -> usize {
        let lines = self.0.iter().filter(|(w, _)| *w == what).map(|(_, lines)| lines);
        size_of::<Wide>() * lines.sum::<usize>()
    }

    fn add(&mut self, what: What, lines: usize) {
        match self.0.iter_mut().find(|(w, _)| *w == what) {
            Some((_, sum)) => *sum += lines,
            None => self.0.push((what, lines)),
        }
    }

    fn add_columns(
        &mut self,
        graph: &TaskGraph,
        stage: &Stage,
        layout: &ParticleLayout,
        block: &ParticleBlock,
    ) {
        let labels = layout.widths.len();
        let (mut fetched, mut written) = (vec![false; labels], vec![false; labels]);
        for &entry in &stage.entries {
            let declaration = graph.recipe.entries[entry].task.declaration();
            if declaration.domain == Domain::NearParticles && !block.near {
                continue;
            }
            for access in declaration.access.iter().filter(|a| a.label.home() == Home::Particle) {
                let label = access.label.index();
                let lines = block.tiles() * layout.widths[label];
                let first_touch = !std::mem::replace(&mut fetched[label], true);
                let first_write = access.mode.writes() && !std::mem::replace(&mut written[label], true);
                self.add(What::Entry(entry), lines * (usize::from(first_touch) + usize::from(first_write)));
            }
        }
    }

    /// Partial sums are set to zero before anything is added: fetched and written back.
    fn add_partials(&mut self, stage: &Stage, block: &ParticleBlock) {
        for &label in &stage.adds {
            self.add(What::Part(stage.entries[0], StagePart::Zeroing), 2 * used(block, label));
        }
    }

    /// Regions overlap; a line that several blocks load is in cache but for the first time.
    fn add_regions(&mut self, warehouse: &Warehouse, stage: &Stage, material: usize) {
        for &label in &stage.reads {
            let blocks = warehouse.nodes.iter().flat_map(|patch| &patch.blocks);
            let fields = |block: &NodeBlock| {
                block.present.iter().filter(|f| warehouse.fields.material(**f) == material).count()
            };
            let lines = blocks.map(fields).sum::<usize>() * warehouse.node_layout.nodes * label.width();
            self.add(What::Part(stage.entries[0], StagePart::LoadRegion), lines);
        }
    }

    /// All partial sums are read once, what particles read is written.
    fn add_nodes(&mut self, graph: &TaskGraph, warehouse: &Warehouse, stage: &Stage) {
        for &label in &stage.sums {
            let lines = warehouse.blocks().map(|(_, block)| used(block, label)).sum();
            self.add(What::Part(stage.entries[0], StagePart::SumPartials), lines);
        }
        let values = |a: &&Access| matches!(a.label.crossing(), Crossing::Values(_)) && a.mode.writes();
        for label in stage.touched.iter().filter(values).map(|access| access.label) {
            let writes = |entry: &&usize| {
                let access = graph.recipe.entries[**entry].task.declaration().access;
                access.iter().any(|a| a.label == label && a.mode.writes())
            };
            let place = warehouse.node_layout.stored_place(label);
            let blocks = warehouse.nodes.iter().flat_map(|patch| &patch.blocks);
            let lines: usize = blocks.map(|block| place.map_or(0, |place| block.column(place).len())).sum();
            if let Some(&entry) = stage.entries.iter().find(writes) {
                self.add(What::Entry(entry), 2 * lines);
            }
        }
    }
}
