//! The state of a warehouse out of a checkpoint.
use super::state::{carried, fields, labels};
use super::{BlockRow, Reader, Table};
use crate::output;
use engine::data::extent;
use engine::data::fields::FieldId;
use engine::data::layout::ParticleLayout;
use engine::data::nodes::NodeBlock;
use engine::data::particles::ParticleBlock;
use engine::data::warehouse::Warehouse;
use engine::schema::LabelId;
use grid::BlockIndex;
use simd::{LANES, Wide};
use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

/// Rows that are read at once, about.
const ROWS: usize = 32_768;
/// Rows of other ranks that are read along, rather than to begin anew behind them.
const GAP: usize = 4_096;

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

/// Fills an empty warehouse with the particles and nodes of this rank's patches.
///
/// # Errors
/// A checkpoint that cannot be read, or of something else.
pub fn fill(warehouse: &mut Warehouse, from: &Reader) -> output::Result<()> {
    if from.head.materials.len() != warehouse.materials.len() {
        return Err(from.wrong("it has other materials than the scene".into()));
    }
    for material in 0..warehouse.materials.len() {
        let (stored, table) = (&from.head.materials[material], from.blocks(material)?);
        let layout = warehouse.materials[material].layout.clone();
        fits(warehouse, from, (stored, &table), labels(&layout))?;
        for window in windows(warehouse, &table) {
            let columns = from.columns(material, &window.rows)?;
            for (position, row) in window.blocks {
                let stored = (&table[position], row - window.rows.start);
                let block = block(warehouse, &layout, stored, &columns);
                if !is_home(warehouse, material, &block) {
                    let index = table[position].index;
                    return Err(from.wrong(format!("block {index:?} has particles that are not near it")));
                }
                let outside = |_| from.wrong(format!("block {:?} is outside", table[position].index));
                warehouse.adopt(material, block).map_err(outside)?;
            }
        }
    }
    fill_nodes(warehouse, from)?;
    fill_shared(warehouse, from)
}

/// Whether a table has the labels and the rows that it should.
fn fits(
    warehouse: &Warehouse,
    from: &Reader,
    (stored, table): (&Table, &[BlockRow]),
    labels: Vec<(String, usize)>,
) -> output::Result<()> {
    if labels != stored.labels {
        return Err(from.wrong(format!("{} has other labels than here", stored.name)));
    }
    let rows = table.iter().map(|block| block.count as usize).sum::<usize>();
    let outside = table.iter().any(|b| warehouse.decomposition.owner(b.index).is_none());
    let mut known = HashSet::new();
    let once = table.len() == stored.blocks && table.iter().all(|block| known.insert(block.index));
    if rows != stored.rows || outside || !once {
        return Err(from.wrong(format!("its blocks of {} do not fit", stored.name)));
    }
    Ok(())
}

/// A field, and the numbers of each of its labels in one block.
type FieldColumns = (FieldId, Vec<Vec<f64>>);

/// What nodes carry, field by field; several fields may touch a block.
fn fill_nodes(warehouse: &mut Warehouse, from: &Reader) -> output::Result<()> {
    let all = fields(warehouse);
    if from.head.nodes.len() != all.len() {
        return Err(from.wrong("its nodes have other labels than here".into()));
    }
    let labels: Vec<LabelId> = carried(warehouse).collect();
    let names = || labels.iter().map(|label| (label.name().to_owned(), LANES * label.width())).collect();
    let mut blocks: BTreeMap<BlockIndex, Vec<FieldColumns>> = BTreeMap::new();
    for field in all {
        let number = warehouse.materials.len() + field;
        let (stored, table) = (&from.head.nodes[field], from.blocks(number)?);
        fits(warehouse, from, (stored, &table), names())?;
        if table.iter().any(|block| block.count as usize != warehouse.node_layout.nodes) {
            return Err(from.wrong(format!("its blocks of {} do not fit", stored.name)));
        }
        for window in windows(warehouse, &table) {
            let columns = from.columns(number, &window.rows)?;
            for (position, row) in window.blocks {
                let (first, count) = (row - window.rows.start, table[position].count as usize);
                let of = |(column, label): (&Vec<f64>, &LabelId)| {
                    let width = LANES * label.width();
                    column[first * width..(first + count) * width].to_vec()
                };
                let values = columns.iter().zip(&labels).map(of).collect();
                blocks.entry(table[position].index).or_default().push((FieldId::new(field), values));
            }
        }
    }
    for (index, values) in blocks {
        let block = node_block(warehouse, index, &labels, &values);
        let patch = warehouse.decomposition.owner(index).unwrap_or_default();
        warehouse.nodes[patch].blocks.push(block);
    }
    Ok(())
}

/// A block of nodes with what some fields have there.
fn node_block(
    warehouse: &Warehouse,
    index: BlockIndex,
    labels: &[LabelId],
    values: &[FieldColumns],
) -> NodeBlock {
    let layout = &warehouse.node_layout;
    let mut block = NodeBlock::new(index, values.iter().map(|(field, _)| *field).collect(), layout);
    for (field, columns) in values {
        for (&label, numbers) in labels.iter().zip(columns) {
            let lines = block.lines_mut(layout, label, *field).unwrap_or_default();
            for (line, numbers) in lines.iter_mut().zip(numbers.as_chunks::<LANES>().0) {
                *line = Wide(*numbers);
            }
        }
    }
    block
}

/// A block from rows of columns.
fn block(
    warehouse: &Warehouse,
    layout: &ParticleLayout,
    (stored, first): (&BlockRow, usize),
    columns: &[Vec<f64>],
) -> ParticleBlock {
    let mut block = ParticleBlock::new(stored.index, &warehouse.node_layout);
    let (count, rest) = (stored.count as usize, warehouse.level.middle(stored.index));
    block.reserve(layout, rest, count.div_ceil(LANES));
    let mut record = Vec::with_capacity(layout.total);
    for row in first..first + count {
        record.clear();
        let mut columns = columns.iter().peekable();
        for label in layout.labels() {
            let width = layout.width(label);
            match columns.next_if(|_| !label.is_known()) {
                Some(column) => record.extend_from_slice(&column[row * width..][..width]),
                // whoever knows it puts it there
                None => record.resize(record.len() + width, 0.0),
            }
        }
        block.push(layout, rest, [0.0; 3], &record);
    }
    block.extent = extent::from_largest(stored.extent);
    block
}

/// Whether all particles of a block are in its reach, and within its extent: tasks rely on both.
fn is_home(warehouse: &Warehouse, material: usize, block: &ParticleBlock) -> bool {
    let (level, data) = (&warehouse.level, &warehouse.materials[material]);
    let (position, largest) = (warehouse.schema.roles.position, extent::largest(&block.extent));
    let axes = (0..3).filter(|&axis| !level.shape().is_collapsed(axis));
    (0..block.count).all(|particle| {
        let x = std::array::from_fn(|axis| block.get(&data.layout, position, particle, axis));
        let y = level.base(x, data.half_size);
        level.contains(x)
            && axes.clone().all(|axis| {
                let mut within = [y[axis], -y[axis]].into_iter().zip([axis, axis + 3]);
                !extent::out_of_reach(level, block.index, axis, y[axis])
                    && within.all(|(y, bound)| y <= largest[bound] + 2.0 * extent::MARGIN)
            })
    })
}

fn fill_shared(warehouse: &mut Warehouse, from: &Reader) -> output::Result<()> {
    for label in warehouse.shared.carried().collect::<Vec<_>>() {
        let words = from.head.shared.iter().find(|(name, _)| name == label.name()).map(|(_, words)| words);
        let lines: &mut [u64] = bytemuck::cast_slice_mut::<Wide, u64>(warehouse.shared.column_mut(label));
        match words {
            Some(words) if words.len() == lines.len() => lines.copy_from_slice(words),
            _ => return Err(from.wrong(format!("label {} is missing or of another size", label.name()))),
        }
    }
    Ok(())
}
