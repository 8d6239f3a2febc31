//! Writes a checkpoint part by part.
use super::{FORMAT, Head, Part, name};
use crate::output::draft::Draft;
use crate::output::error::Result;
use crate::output::seal;
use crate::output::stored::word;
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File, Group, H5Type};
use ndarray::ArrayView2;
use std::path::Path;

/// Bytes for what HDF5 keeps about the data.
const SLACK: usize = 1 << 20;

/// A checkpoint that is being written, aside.
#[derive(Debug)]
pub struct Writer {
    tables: Vec<Table>,
    draft: Draft,
}

/// The datasets of a table, and how many rows they hold.
#[derive(Debug)]
struct Table {
    /// Indices, counts and extents of blocks.
    blocks: [Dataset; 3],
    labels: Vec<(String, Dataset)>,
    written: usize,
    rows: usize,
}

impl Writer {
    /// Begins the checkpoint at `path`.
    ///
    /// # Errors
    /// If the disk is full or the folder cannot be written.
    pub fn create(path: &Path, head: &Head) -> Result<Self> {
        let draft = Draft::create(path, SLACK)?;
        let tables =
            draft.write(|file| lay_out(file, head).and_then(|tables| file.flush().map(|()| tables)))?;
        draft.reserve(room(head))?;
        Ok(Self { tables, draft })
    }

    /// Writes some blocks of a table behind those that came before.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn part(&mut self, part: &Part) -> Result<()> {
        let table = &mut self.tables[part.table];
        self.draft.write(|_| table.write(part))
    }

    /// Seals it and puts it in place, when the disk has all of it.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(self) -> Result<()> {
        let Self { tables, draft } = self;
        drop(tables);
        draft.finish_on_disk().map(drop)
    }
}

impl Table {
    fn write(&mut self, part: &Part) -> hdf5::Result<()> {
        let row = self.written;
        let end = row + part.blocks.len();
        let [indices, counts, extents] = &self.blocks;
        let flat = |values: Vec<[i32; 3]>| values.into_flattened();
        rows(indices, row, &flat(part.blocks.iter().map(|block| block.index).collect()))?;
        rows(counts, row, &part.blocks.iter().map(|block| block.count).collect::<Vec<_>>())?;
        let extent: Vec<[f64; 6]> = part.blocks.iter().map(|block| block.extent).collect();
        rows(extents, row, &extent.into_flattened())?;
        for ((name, dataset), values) in self.labels.iter().zip(&part.columns) {
            if name == name::IDENTITY {
                rows(dataset, self.rows, bytemuck::cast_slice::<_, u64>(values))?;
            } else {
                rows(dataset, self.rows, values)?;
            }
        }
        self.rows += part.blocks.iter().map(|block| block.count as usize).sum::<usize>();
        self.written = end;
        Ok(())
    }
}

/// Bytes of all datasets.
fn room(head: &Head) -> usize {
    let table = |m: &super::Table| {
        let numbers: usize = m.labels.iter().map(|(_, width)| width).sum();
        m.blocks * size_of::<super::BlockRow>() + m.rows * numbers * size_of::<f64>()
    };
    head.materials.iter().chain(&head.nodes).map(table).sum::<usize>() + SLACK + seal::LENGTH as usize
}

fn lay_out(file: &File, head: &Head) -> hdf5::Result<Vec<Table>> {
    number(file, name::FORMAT, &FORMAT)?;
    text(file, name::VERSION, &head.version)?;
    text(file, name::ISA, &head.isa)?;
    text(file, name::SCENE_NAME, &head.name)?;
    text(file, name::SCENE_IDENTITY, &crate::input::identity::fingerprint(&head.scene))?;
    number(file, name::TIME, &head.time)?;
    number(file, name::STEPS, &head.steps)?;
    number(file, name::UPDATES, &head.updates)?;
    head.recorded.run.write(file)?;
    number(file, name::FRAMES, &head.recorded.frames)?;
    number(file, name::DUE, &head.recorded.due)?;
    number(file, name::LAST_ROW, &head.recorded.last[0])?;
    number(file, name::LAST_FRAME, &head.recorded.last[1])?;
    number(file, name::WALL, &head.recorded.wall_s)?;
    number(file, name::OUTPUT, &head.recorded.output_s)?;
    number(file, name::HISTORY, &head.recorded.history)?;
    let warnings: String =
        head.recorded.warnings.iter().map(|(key, words)| format!("{key}\t{words}\n")).collect();
    file.new_dataset::<VarLenUnicode>().create(name::WARNINGS)?.write_scalar(&word(&warnings)?)?;
    file.new_dataset::<VarLenUnicode>().create(name::SCENE)?.write_scalar(&word(&head.scene)?)?;
    let shared = file.create_group(name::SHARED)?;
    for (label, words) in &head.shared {
        whole(&shared, label, words)?;
    }
    whole(file, name::LEDGER, &head.ledger)?;
    let mut all = Vec::new();
    for (name, tables) in [(name::MATERIALS, &head.materials), (name::NODES, &head.nodes)] {
        let group = file.create_group(name)?;
        for (index, table) in tables.iter().enumerate() {
            all.push(lay_out_table(&group.create_group(&index.to_string())?, table)?);
        }
    }
    Ok(all)
}

fn lay_out_table(group: &Group, table: &super::Table) -> hdf5::Result<Table> {
    text(group, name::MATERIAL_NAME, &table.name)?;
    let names: Vec<&str> = table.labels.iter().map(|(name, _)| name.as_str()).collect();
    text(group, name::LABELS, &names.join(" "))?;
    let (blocks, count) = (table.blocks, table.rows);
    let tables = [
        group.new_dataset::<i32>().shape((blocks, 3)).create(name::BLOCK_INDEX)?,
        group.new_dataset::<u32>().shape((blocks, 1)).create(name::BLOCK_COUNT)?,
        group.new_dataset::<f64>().shape((blocks, 6)).create(name::BLOCK_EXTENT)?,
    ];
    let columns = group.create_group(name::PARTICLES)?;
    let column = |(name, width): &(String, usize)| {
        let dataset = match name.as_str() {
            name::IDENTITY => columns.new_dataset::<u64>().shape((count, *width)).create(name.as_str())?,
            _ => columns.new_dataset::<f64>().shape((count, *width)).create(name.as_str())?,
        };
        Ok((name.clone(), dataset))
    };
    let labels = table.labels.iter().map(column).collect::<hdf5::Result<_>>()?;
    Ok(Table { blocks: tables, labels, written: 0, rows: 0 })
}

/// Writes rows of a dataset of two dimensions from row `begin` on.
fn rows<T: H5Type>(dataset: &Dataset, begin: usize, values: &[T]) -> hdf5::Result<()> {
    let width = dataset.shape().get(1).copied().unwrap_or(1).max(1);
    if values.is_empty() {
        return Ok(());
    }
    let count = values.len() / width;
    let view = ArrayView2::from_shape((count, width), values)
        .map_err(|error| hdf5::Error::Internal(error.to_string()))?;
    dataset.write_slice(view, (begin..begin + count, ..))
}

fn whole<T: H5Type>(group: &Group, name: &str, values: &[T]) -> hdf5::Result<()> {
    group.new_dataset::<T>().shape(values.len()).create(name)?.write_raw(values)
}

fn number<T: H5Type>(group: &Group, name: &str, value: &T) -> hdf5::Result<()> {
    group.new_attr::<T>().create(name)?.write_scalar(value)
}

fn text(group: &Group, name: &str, value: &str) -> hdf5::Result<()> {
    group.new_attr::<VarLenUnicode>().create(name)?.write_scalar(&word(value)?)
}
