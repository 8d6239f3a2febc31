//! The state of a warehouse into a checkpoint, and out of it: what passes from step to step, label by label.
use super::{BlockRow, Head, Part, Table, Writer};
use crate::output::{self, parcel, together};
use engine::data::extent;
use engine::data::fields::FieldId;
use engine::data::layout::ParticleLayout;
use engine::data::nodes::NodeBlock;
use engine::data::particles::ParticleBlock;
use engine::data::warehouse::Warehouse;
use engine::exec::ranks::words::{put, take};
use engine::exec::ranks::{Network, collective};
use engine::schema::LabelId;
use simd::LANES;
use std::ops::Range;
use std::path::Path;

/// Rows of a part, about: what a rank sends at once.
const ROWS: usize = 32_768;

impl Head {
    /// Fills in the tables and values of a warehouse, over all ranks.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn describe(&mut self, network: &mut dyn Network, warehouse: &Warehouse) -> output::Result<()> {
        let material = |data: &engine::data::warehouse::MaterialData| Table {
            name: data.name.clone(),
            labels: labels(&data.layout),
            ..Table::default()
        };
        let field = |field: usize| Table {
            name: format!("field {field}"),
            labels: carried(warehouse)
                .map(|label| (label.name().to_owned(), LANES * label.width()))
                .collect(),
            ..Table::default()
        };
        self.materials = warehouse.materials.iter().map(material).collect();
        self.nodes = fields(warehouse).map(field).collect();
        self.shared = warehouse.shared.carried().map(|label| shared(warehouse, label)).collect();
        let mut counts = Vec::new();
        for m in 0..warehouse.materials.len() {
            let all = blocks(warehouse, m).fold([0, 0], |[n, p], block| [n + 1, p + block.count as u64]);
            counts.extend(all);
        }
        for f in fields(warehouse) {
            let all = nodes(warehouse, FieldId::new(f)).count() as u64;
            counts.extend([all, all * warehouse.node_layout.nodes as u64]);
        }
        collective::sum(network, &mut counts)?;
        for (table, count) in self.materials.iter_mut().chain(&mut self.nodes).zip(counts.as_chunks::<2>().0)
        {
            [table.blocks, table.rows] = count.map(|n| n as usize);
        }
        Ok(())
    }
}

/// Writes the checkpoint at `path` from rank 0, with the parts that each rank gives: those of a warehouse ([`parts`]), or kept
/// ones. All ranks call it.
///
/// # Errors
/// If the file cannot be written: on all ranks.
pub fn write(
    network: &mut dyn Network,
    give: impl FnOnce(&mut dyn FnMut(Part)),
    path: &Path,
    head: &Head,
) -> output::Result<()> {
    let written = write_parts(network, give, path, head);
    together::agree(network, written)
}

fn shared(warehouse: &Warehouse, label: LabelId) -> (String, Vec<u64>) {
    let words: &[u64] = bytemuck::cast_slice(warehouse.shared.column(label));
    (label.name().to_owned(), words.to_vec())
}

/// Labels of nodes that pass from step to step.
pub(super) fn carried(warehouse: &Warehouse) -> impl Iterator<Item = LabelId> + '_ {
    warehouse.node_layout.carried()
}

/// The fields whose nodes have labels that pass from step to step.
pub(super) fn fields(warehouse: &Warehouse) -> Range<usize> {
    0..if carried(warehouse).next().is_some() { warehouse.fields.len() } else { 0 }
}

/// Blocks of nodes of this rank that a field touches.
fn nodes(warehouse: &Warehouse, field: FieldId) -> impl Iterator<Item = &NodeBlock> {
    let mine = warehouse.partition.mine().flat_map(|patch| &warehouse.nodes[patch].blocks);
    mine.filter(move |block| block.slot(field).is_some())
}

/// Particle blocks of a material that hold particles of this rank.
fn blocks(warehouse: &Warehouse, material: usize) -> impl Iterator<Item = &ParticleBlock> {
    let homes = warehouse.particles.iter().map(move |patch| &patch[material]);
    homes.flat_map(|home| &home.blocks).filter(|block| block.count > 0)
}

/// Names of the labels of a material, and numbers a particle.
pub(super) fn labels(layout: &ParticleLayout) -> Vec<(String, usize)> {
    layout.state_labels().map(|label| (label.name().to_owned(), layout.width(label))).collect()
}

fn write_parts(
    network: &mut dyn Network,
    give: impl FnOnce(&mut dyn FnMut(Part)),
    path: &Path,
    head: &Head,
) -> output::Result<()> {
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
    parcel::collect(network, give, take)?;
    writer?.map_or(Ok(()), Writer::finish)
}

/// This rank's particles, material by material, patch by patch; then its nodes, field by field.
pub fn parts(warehouse: &Warehouse, give: &mut dyn FnMut(Part)) {
    for (material, data) in warehouse.materials.iter().enumerate() {
        let layout = &data.layout;
        let mut parts = Parts::new(material, layout.state_labels().count(), &mut *give);
        for block in blocks(warehouse, material) {
            let extent = extent::largest(&block.extent);
            let row = BlockRow { index: block.index, count: block.count as u32, extent };
            parts.add(row, |at, column| {
                let Some(label) = layout.state_labels().nth(at) else { return };
                let (tiles, width) = (block.column(layout, label), layout.width(label));
                let tile = |p: usize| &tiles[p / LANES * width..][..width];
                let numbers = |p: usize| tile(p).iter().map(move |line| line.0[p % LANES]);
                column.extend((0..block.count).flat_map(numbers));
            });
        }
        parts.end();
    }
    let layout = &warehouse.node_layout;
    for field in fields(warehouse) {
        let table = warehouse.materials.len() + field;
        let mut parts = Parts::new(table, carried(warehouse).count(), &mut *give);
        for block in nodes(warehouse, FieldId::new(field)) {
            let row = BlockRow { index: block.index, count: layout.nodes as u32, extent: [0.0; 6] };
            parts.add(row, |at, column| {
                let Some(label) = carried(warehouse).nth(at) else { return };
                let end = column.len() + LANES * label.width() * layout.nodes;
                let lines = block.lines(layout, label, FieldId::new(field)).unwrap_or_default();
                column.extend(lines.iter().flat_map(|line| line.0));
                // each node has a row, also where the label is not there
                column.resize(end, 0.0);
            });
        }
        parts.end();
    }
}

/// Collects blocks until they are enough for a part.
struct Parts<'a> {
    part: Part,
    rows: usize,
    give: &'a mut dyn FnMut(Part),
}

impl<'a> Parts<'a> {
    fn new(table: usize, columns: usize, give: &'a mut dyn FnMut(Part)) -> Self {
        let part = Part { table, columns: vec![Vec::new(); columns], ..Part::default() };
        Self { part, rows: 0, give }
    }

    /// Adds a block; `fill` appends its numbers to the column with a number.
    fn add(&mut self, row: BlockRow, fill: impl Fn(usize, &mut Vec<f64>)) {
        self.part.blocks.push(row);
        self.part.columns.iter_mut().enumerate().for_each(|(at, column)| fill(at, column));
        self.rows += row.count as usize;
        if self.rows >= ROWS {
            self.end();
        }
    }

    fn end(&mut self) {
        if std::mem::take(&mut self.rows) > 0 {
            let columns = vec![Vec::new(); self.part.columns.len()];
            let empty = Part { table: self.part.table, columns, ..Part::default() };
            (self.give)(std::mem::replace(&mut self.part, empty));
        }
    }
}

impl parcel::Parcel for Part {
    fn words(&self) -> Vec<u64> {
        let mut words = vec![self.table as u64];
        put(&mut words, &self.blocks.iter().map(|block| block.index).collect::<Vec<_>>());
        put(&mut words, &self.blocks.iter().map(|block| block.count).collect::<Vec<_>>());
        put(&mut words, &self.blocks.iter().map(|block| block.extent).collect::<Vec<_>>());
        self.columns.iter().for_each(|column| put(&mut words, column));
        words
    }

    fn from_words(words: &[u64]) -> Self {
        let Some((&table, mut words)) = words.split_first() else { return Part::default() };
        let words = &mut words;
        let (indices, counts, extents): (Vec<_>, Vec<_>, Vec<_>) = (take(words), take(words), take(words));
        let blocks = indices.into_iter().zip(counts).zip(extents);
        let blocks = blocks.map(|((index, count), extent)| BlockRow { index, count, extent }).collect();
        let mut columns = Vec::new();
        while !words.is_empty() {
            columns.push(take(words));
        }
        Part { table: table as usize, blocks, columns }
    }
}
