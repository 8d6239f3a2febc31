//! A run's state into a checkpoint, and out of it.
use super::fault::RunError;
use super::{Ledger, Simulation, layout, parcel, together};
use crate::data::extent;
use crate::data::label::Home;
use crate::data::labels::LabelId;
use crate::data::particles::{Layout, ParticleBlock};
use crate::data::shared::Clock;
use crate::data::warehouse::Warehouse;
use crate::exec::ranks::words::{put, take};
use crate::exec::ranks::{Network, collective};
use crate::grid::Level;
use crate::input::scene::Scene;
use crate::output;
use crate::output::checkpoint::{self, BlockRow, Head, Material, Part, Reader, Recorded, VERSION, Writer};
use crate::simd::{Isa, LANES, Wide};
use std::ops::Range;
use std::path::Path;

/// Rows of a part, about: what a rank sends at once, and reads at once.
const ROWS: usize = 32_768;
/// Rows of other ranks that are read along, rather than to begin anew behind them.
const GAP: usize = 4_096;

impl Simulation {
    /// Writes `checkpoint-NNNNNNNN.h5` into a folder, from rank 0. All ranks call it, between two steps.
    ///
    /// # Errors
    /// If the file cannot be written: on all ranks.
    pub fn write_checkpoint(&mut self, folder: &Path, recorded: Recorded) -> output::Result<()> {
        let materials = self.warehouse.materials.len();
        let mut mine = vec![self.updates];
        for material in 0..materials {
            let blocks = blocks(&self.warehouse, material);
            let (count, particles) = blocks.fold((0, 0), |(n, p), block| (n + 1, p + block.count as u64));
            mine.extend([count, particles]);
        }
        let all = collective::share(self.network(), &mine)?;
        let total = |i: usize| all.iter().map(|numbers| numbers[i]).sum::<u64>();
        let mut head = self.head(recorded, total(0));
        for (i, material) in head.materials.iter_mut().enumerate() {
            (material.blocks, material.particles) = (total(1 + 2 * i) as usize, total(2 + 2 * i) as usize);
        }
        let path = checkpoint::path(folder, self.steps);
        let written = write(&mut *self.network, &self.warehouse, &path, &head);
        if written.is_err() && self.network.rank() == 0 {
            checkpoint::discard(&path);
        }
        together::agree(self.network(), written)
    }

    fn head(&self, recorded: Recorded, updates: u64) -> Head {
        let shared = |&label: &LabelId| {
            let words: &[u64] = bytemuck::cast_slice(self.warehouse.shared.column(label));
            (label.name().to_owned(), words.to_vec())
        };
        let material = |data: &crate::data::warehouse::MaterialData| Material {
            name: data.name.clone(),
            labels: labels(&data.layout),
            ..Material::default()
        };
        Head {
            version: VERSION.into(),
            isa: self.isa().name().into(),
            name: self.scene.name.clone(),
            scene: self.scene.resolved.clone(),
            time: self.clock().time,
            steps: self.steps,
            updates,
            recorded,
            shared: shared_labels().map(shared).collect(),
            ledger: self.ledger.numbers(),
            materials: self.warehouse.materials.iter().map(material).collect(),
        }
    }

    /// This rank's part of a simulation as a checkpoint of it says, on all ranks of `network`.
    ///
    /// # Errors
    /// Patches that do not fit, threads that do not start, or a checkpoint of something else.
    pub fn restore(
        network: Box<dyn Network>,
        scene: Scene,
        isa: Isa,
        from: &Reader,
    ) -> Result<Self, RunError> {
        let tables =
            (0..from.head.materials.len()).map(|m| from.blocks(m)).collect::<output::Result<Vec<_>>>()?;
        let census: Vec<_> = tables.iter().flatten().map(|b| (b.index, u64::from(b.count))).collect();
        let cut = |scene: &Scene, wanted| layout::cut(scene, wanted, &census);
        let fill = |scene: &Scene, warehouse: &mut Warehouse| {
            fill(warehouse, from, &tables)?;
            Ok(restore_shared(warehouse, from, scene.run.until)?)
        };
        let mut simulation = Self::assemble(network, scene, isa, cut, fill)?;
        simulation.ledger = Ledger::from_numbers(&from.head.ledger, simulation.scene.materials.len())
            .ok_or_else(|| from.wrong("its ledger is not one of this scene".into()))?;
        simulation.steps = from.head.steps;
        // counted by rank, added up for people
        simulation.updates = if simulation.network.rank() == 0 { from.head.updates } else { 0 };
        Ok(simulation)
    }
}

/// Particle blocks of a material that hold particles of this rank.
fn blocks(warehouse: &Warehouse, material: usize) -> impl Iterator<Item = &ParticleBlock> {
    let homes = warehouse.particles.iter().map(move |patch| &patch[material]);
    homes.flat_map(|home| &home.blocks).filter(|block| block.count > 0)
}

fn shared_labels() -> impl Iterator<Item = &'static LabelId> {
    LabelId::ALL.iter().filter(|label| matches!(label.home(), Home::Material | Home::Global))
}

/// Names of the labels of a material, and numbers a particle.
fn labels(layout: &Layout) -> Vec<(String, usize)> {
    layout.labels().map(|label| (label.name().to_owned(), layout.widths[label as usize])).collect()
}

fn write(network: &mut dyn Network, warehouse: &Warehouse, path: &Path, head: &Head) -> output::Result<()> {
    let mut writer = match network.rank() {
        0 => Writer::create(path, head).map(Some),
        _ => Ok(None),
    };
    // whatever fails here, the others send all they have
    let take = |part: Part| {
        if let Ok(Some(open)) = &mut writer
            && let Err(error) = open.part(&part)
        {
            writer = Err(error);
        }
    };
    parcel::collect(network, |give| parts(warehouse, give), take)?;
    writer?.map_or(Ok(()), Writer::finish)
}

/// This rank's particles, material by material, patch by patch.
fn parts(warehouse: &Warehouse, give: &mut dyn FnMut(Part)) {
    for (material, data) in warehouse.materials.iter().enumerate() {
        let layout = &data.layout;
        let empty =
            || Part { material, columns: vec![Vec::new(); layout.labels().count()], ..Part::default() };
        let (mut part, mut rows) = (empty(), 0);
        for block in blocks(warehouse, material) {
            let extent = extent::largest(&block.extent);
            part.blocks.push(BlockRow { index: block.index, count: block.count as u32, extent });
            for (column, label) in part.columns.iter_mut().zip(layout.labels()) {
                let (tiles, width) = (block.column(layout, label), layout.widths[label as usize]);
                let tile = |p: usize| &tiles[p / LANES * width..][..width];
                column
                    .extend((0..block.count).flat_map(|p| tile(p).iter().map(move |line| line.0[p % LANES])));
            }
            rows += block.count;
            if rows >= ROWS {
                give(std::mem::replace(&mut part, empty()));
                rows = 0;
            }
        }
        if rows > 0 {
            give(part);
        }
    }
}

impl parcel::Parcel for Part {
    fn words(&self) -> Vec<u64> {
        let mut words = vec![self.material as u64];
        put(&mut words, &self.blocks.iter().map(|block| block.index).collect::<Vec<_>>());
        put(&mut words, &self.blocks.iter().map(|block| block.count).collect::<Vec<_>>());
        put(&mut words, &self.blocks.iter().map(|block| block.extent).collect::<Vec<_>>());
        self.columns.iter().for_each(|column| put(&mut words, column));
        words
    }

    fn from_words(words: &[u64]) -> Self {
        let Some((&material, mut words)) = words.split_first() else { return Part::default() };
        let words = &mut words;
        let (indices, counts, extents): (Vec<_>, Vec<_>, Vec<_>) = (take(words), take(words), take(words));
        let blocks = indices.into_iter().zip(counts).zip(extents);
        let blocks = blocks.map(|((index, count), extent)| BlockRow { index, count, extent }).collect();
        let mut columns = Vec::new();
        while !words.is_empty() {
            columns.push(take(words));
        }
        Part { material: material as usize, blocks, columns }
    }
}

/// Blocks that are read at once, and the rows that they and those between them take.
#[derive(Default)]
struct Window {
    rows: Range<usize>,
    /// Position in the table, and first row.
    blocks: Vec<(usize, usize)>,
}

/// This rank's blocks, some at a time; rows between them are read along where that is less work.
fn windows(warehouse: &Warehouse, table: &[BlockRow]) -> Vec<Window> {
    let mut windows: Vec<Window> = Vec::new();
    let mut next = 0;
    for (position, block) in table.iter().enumerate() {
        let rows = next..next + block.count as usize;
        next = rows.end;
        if !warehouse.decomposition.owner(block.index).is_some_and(|p| warehouse.partition.is_mine(p)) {
            continue;
        }
        match windows.last_mut() {
            Some(last) if rows.start - last.rows.end <= GAP && rows.end - last.rows.start <= ROWS => {
                last.rows.end = rows.end;
                last.blocks.push((position, rows.start));
            }
            _ => windows.push(Window { blocks: vec![(position, rows.start)], rows }),
        }
    }
    windows
}

/// The particles of this rank's patches.
fn fill(warehouse: &mut Warehouse, from: &Reader, tables: &[Vec<BlockRow>]) -> output::Result<()> {
    if from.head.materials.len() != warehouse.materials.len() {
        return Err(from.wrong("it has other materials than the scene".into()));
    }
    for (material, table) in tables.iter().enumerate() {
        let stored = &from.head.materials[material];
        let layout = warehouse.materials[material].layout.clone();
        if labels(&layout) != stored.labels {
            return Err(from.wrong(format!("particles of {} have other labels than here", stored.name)));
        }
        let rows = table.iter().map(|block| block.count as usize).sum::<usize>();
        if rows != stored.particles || table.iter().any(|b| warehouse.decomposition.owner(b.index).is_none())
        {
            return Err(from.wrong(format!("its blocks of {} do not fit", stored.name)));
        }
        for window in windows(warehouse, table) {
            let columns = from.columns(material, &window.rows)?;
            for (position, row) in window.blocks {
                let block =
                    block(warehouse.level, &layout, &table[position], &columns, row - window.rows.start);
                let outside = |_| from.wrong(format!("block {:?} is outside", table[position].index));
                warehouse.adopt(material, block).map_err(outside)?;
            }
        }
    }
    Ok(())
}

/// A block from rows of columns.
fn block(
    level: Level,
    layout: &Layout,
    stored: &BlockRow,
    columns: &[Vec<f64>],
    first: usize,
) -> ParticleBlock {
    let mut block = ParticleBlock::new(stored.index);
    let (count, rest) = (stored.count as usize, level.middle(stored.index));
    block.reserve(layout, rest, count.div_ceil(LANES));
    let mut record = Vec::with_capacity(layout.total);
    for row in first..first + count {
        record.clear();
        for (column, label) in columns.iter().zip(layout.labels()) {
            let width = layout.widths[label as usize];
            record.extend_from_slice(&column[row * width..][..width]);
        }
        block.push(layout, rest, [0.0; 3], &record);
    }
    block.extent = extent::from_largest(stored.extent);
    block
}

fn restore_shared(warehouse: &mut Warehouse, from: &Reader, until: f64) -> output::Result<()> {
    for label in shared_labels() {
        let words = from.head.shared.iter().find(|(name, _)| name == label.name()).map(|(_, words)| words);
        let lines: &mut [u64] = bytemuck::cast_slice_mut::<Wide, u64>(warehouse.shared.column_mut(*label));
        match words {
            Some(words) if words.len() == lines.len() => lines.copy_from_slice(words),
            _ => return Err(from.wrong(format!("label {} is missing or of another size", label.name()))),
        }
    }
    // the end of the run may be another one
    let clock: Clock = warehouse.shared.get(LabelId::Time, 0);
    warehouse.shared.set(LabelId::Time, 0, Clock { until, ..clock });
    Ok(())
}
