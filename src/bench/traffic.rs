//! Bytes that the tasks of a step move, by their declarations.
//!
//! In a sweep a column is read once, by the first task that touches it, and written back once, for the first task that
//! writes it; a column that is written without being read is fetched all the same (write-allocate). Node lines and
//! partial sums count as often as a sweep passes over them, in the blocks where they are. What lives in scratch (chunk
//! labels, regions, node sums) stays in cache and counts nothing. A column that a task needs for rare events alone
//! counts too: the numbers are upper bounds of what must move.
use crate::data::label::Home;
use crate::data::labels::{LABELS, LabelId};
use crate::data::nodes::NODES;
use crate::data::particles::{Layout, ParticleBlock};
use crate::data::warehouse::Warehouse;
use crate::exec::meter::{Part, What};
use crate::exec::stage::SCATTERED;
use crate::graph::build::TaskGraph;
use crate::graph::fuse::Stage;
use crate::graph::task::{Domain, Mode};
use crate::simd::Wide;

/// Lines moved, by what moves them.
#[derive(Debug, Default)]
pub struct Traffic(Vec<(What, usize)>);

/// Lines of a partial buffer that hold something.
fn used(block: &ParticleBlock, which: usize) -> usize {
    if SCATTERED[which].0 == LabelId::NodeSums || block.near { block.touched.len() } else { 0 }
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
                traffic.add_motion(warehouse, stage, material);
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

    fn add_columns(&mut self, graph: &TaskGraph, stage: &Stage, layout: &Layout, block: &ParticleBlock) {
        let (mut fetched, mut written) = ([false; LABELS], [false; LABELS]);
        for &entry in &stage.entries {
            let declaration = graph.recipe.entries[entry].task.declaration();
            if declaration.domain == Domain::NearParticles && !block.near {
                continue;
            }
            for access in declaration.access.iter().filter(|a| a.label.home() == Home::Particle) {
                let label = access.label as usize;
                let lines = block.tiles() * layout.widths[label];
                let first_touch = !std::mem::replace(&mut fetched[label], true);
                let first_write = access.mode.writes() && !std::mem::replace(&mut written[label], true);
                self.add(What::Entry(entry), lines * (usize::from(first_touch) + usize::from(first_write)));
            }
        }
    }

    /// Partial sums are set to zero before anything is added: fetched and written back.
    fn add_partials(&mut self, stage: &Stage, block: &ParticleBlock) {
        for (label, which) in SCATTERED {
            if stage.touches(label, Mode::writes) {
                self.add(What::Part(stage.entries[0], Part::Zeroing), 2 * used(block, which));
            }
        }
    }

    /// Regions overlap; a line that several blocks load is in cache but for the first time.
    fn add_motion(&mut self, warehouse: &Warehouse, stage: &Stage, material: usize) {
        if stage.touches(LabelId::NodeMotion, Mode::reads) {
            let blocks = warehouse.nodes.iter().flat_map(|patch| &patch.blocks);
            let lines = blocks.filter(|b| b.motion_of(material).is_some()).count() * NODES;
            self.add(What::Part(stage.entries[0], Part::LoadRegion), lines);
        }
    }

    /// All partial sums are read once, all motion is written.
    fn add_nodes(&mut self, graph: &TaskGraph, warehouse: &Warehouse, stage: &Stage) {
        for (label, which) in SCATTERED {
            if stage.touches(label, Mode::reads) {
                let lines = warehouse.blocks().map(|(_, block)| used(block, which)).sum();
                self.add(What::Part(stage.entries[0], Part::SumPartials), lines);
            }
        }
        let writes_motion = |entry: &&usize| {
            let access = graph.recipe.entries[**entry].task.declaration().access;
            access.iter().any(|a| a.label == LabelId::NodeMotion && a.mode.writes())
        };
        let lines: usize =
            warehouse.nodes.iter().flat_map(|patch| &patch.blocks).map(|block| block.motion.len()).sum();
        if let Some(&entry) = stage.entries.iter().find(writes_motion) {
            self.add(What::Entry(entry), 2 * lines);
        }
    }
}
