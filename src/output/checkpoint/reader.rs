//! Reads a checkpoint back.
use super::{BlockRow, FORMAT, Head, Recorded, Table, name};
use crate::output::error::{self, Error, Result};
use crate::output::run_id::RunId;
use crate::output::seal;
use crate::output::stored::{self, Virtual};
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File, Group, H5Type};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Counts are below this: with more, a run that goes on would come to the end of 64 bits.
const MOST: u64 = 1 << 60;

/// An open checkpoint.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    file: File,
    /// All but the particles.
    pub head: Head,
}

impl Reader {
    /// Opens a checkpoint whose seal is unbroken.
    ///
    /// # Errors
    /// If the file is missing, cut off, damaged, or of another format.
    pub fn open(path: &Path) -> Result<Self> {
        seal::verify(path)?;
        Self::open_verified(path)
    }

    /// Opens a checkpoint whose seal another rank has checked.
    ///
    /// # Errors
    /// If the file is missing, or of another format.
    pub fn open_verified(path: &Path) -> Result<Self> {
        let file = stored::open(path, Virtual::Refused)?;
        let content = |problem: String| Error::Content { path: path.into(), problem };
        let format: u32 = number(&file, name::FORMAT)
            .map_err(|source| content(format!("not a checkpoint of Sinew ({source})")))?;
        if format != FORMAT {
            return Err(content(format!(
                "it has format {format}, this Sinew ({}) reads format {FORMAT}: go on with the version that wrote it",
                super::VERSION
            )));
        }
        let head = head(&file).map_err(error::hdf5("read", path))?;
        if let Some(name) = implausible(&head) {
            return Err(content(format!("`{name}` in it is a number that no run has")));
        }
        Ok(Self { path: path.into(), file, head })
    }

    /// Whose a checkpoint is, whose seal was checked.
    pub fn run_of(path: &Path) -> Option<RunId> {
        let file = stored::open(path, Virtual::Refused).ok()?;
        RunId::read(&file).ok()
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// An error about what the file holds.
    pub fn wrong(&self, problem: String) -> Error {
        Error::Content { path: self.path.clone(), problem }
    }

    /// The blocks of a table: of a material, or behind them of a field.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn blocks(&self, table: usize) -> Result<Vec<BlockRow>> {
        let read = || -> hdf5::Result<Vec<BlockRow>> {
            let group = self.table(table)?.1;
            let indices: Vec<i32> = all(&group, name::BLOCK_INDEX)?;
            let counts: Vec<u32> = all(&group, name::BLOCK_COUNT)?;
            let extents: Vec<f64> = all(&group, name::BLOCK_EXTENT)?;
            let rows = indices.as_chunks().0.iter().zip(counts).zip(extents.as_chunks().0);
            Ok(rows.map(|((&index, count), &extent)| BlockRow { index, count, extent }).collect())
        };
        read().map_err(error::hdf5("read", &self.path))
    }

    /// Some rows of all labels of a table, in the order of its head.
    ///
    /// # Errors
    /// If they cannot be read.
    pub fn columns(&self, table: usize, range: &Range<usize>) -> Result<Vec<Vec<f64>>> {
        let read = || -> hdf5::Result<Vec<Vec<f64>>> {
            let (head, group) = self.table(table)?;
            let group = group.group(name::PARTICLES)?;
            let column =
                |(label, _): &(String, usize)| column(&dataset(&group, label)?, label, range.clone());
            head.labels.iter().map(column).collect()
        };
        read().map_err(error::hdf5("read", &self.path))
    }

    fn table(&self, number: usize) -> hdf5::Result<(&Table, Group)> {
        let Head { materials, nodes, .. } = &self.head;
        let (name, tables, index) = match number.checked_sub(materials.len()) {
            None => (name::MATERIALS, materials, number),
            Some(index) => (name::NODES, nodes, index),
        };
        Ok((&tables[index], self.file.group(name)?.group(&index.to_string())?))
    }
}

fn column(dataset: &Dataset, label: &str, range: Range<usize>) -> hdf5::Result<Vec<f64>> {
    match label {
        name::IDENTITY => Ok(rows::<u64>(dataset, range)?.into_iter().map(f64::from_bits).collect()),
        _ => rows(dataset, range),
    }
}

fn head(file: &File) -> hdf5::Result<Head> {
    let shared = file.group(name::SHARED)?;
    let words = |label: String| Ok((label.clone(), all::<u64>(&shared, &label)?));
    let tables = |name: &str| -> hdf5::Result<Vec<Table>> {
        let group = file.group(name)?;
        (0..group.len() as usize).map(|index| table(&group.group(&index.to_string())?)).collect()
    };
    Ok(Head {
        version: text(file, name::VERSION)?,
        isa: text(file, name::ISA)?,
        name: text(file, name::SCENE_NAME)?,
        scene: file.dataset(name::SCENE)?.read_scalar::<VarLenUnicode>()?.to_string(),
        time: number(file, name::TIME)?,
        steps: number(file, name::STEPS)?,
        updates: number(file, name::UPDATES)?,
        recorded: Recorded {
            run: RunId::read(file)?,
            frames: number(file, name::FRAMES)?,
            due: number(file, name::DUE)?,
            last: [flag(file, name::LAST_ROW)?, flag(file, name::LAST_FRAME)?],
            wall_s: number(file, name::WALL)?,
            output_s: number(file, name::OUTPUT)?,
            history: number(file, name::HISTORY)?,
            warnings: warnings(&file.dataset(name::WARNINGS)?.read_scalar::<VarLenUnicode>()?),
        },
        shared: shared.member_names()?.into_iter().map(words).collect::<hdf5::Result<_>>()?,
        ledger: all(file, name::LEDGER)?,
        materials: tables(name::MATERIALS)?,
        nodes: tables(name::NODES)?,
    })
}

/// A line each: a key, a tab, and the words.
fn warnings(text: &str) -> Vec<(String, String)> {
    let lines = text.lines().filter_map(|line| line.split_once('\t'));
    lines.map(|(key, words)| (key.to_owned(), words.to_owned())).collect()
}

/// The name of a number that no run has.
fn implausible(head: &Head) -> Option<&'static str> {
    let Head { time, steps, updates, recorded: Recorded { frames, due, wall_s, output_s, .. }, .. } = *head;
    let counts = [(name::STEPS, steps), (name::UPDATES, updates), (name::FRAMES, frames), (name::DUE, due)];
    let times = [(name::TIME, time), (name::WALL, wall_s), (name::OUTPUT, output_s)];
    let endless = counts.into_iter().filter(|(_, count)| *count >= MOST).map(|(name, _)| name);
    let odd = times.into_iter().filter(|(_, time)| !(time.is_finite() && *time >= 0.0)).map(|(name, _)| name);
    endless.chain(odd).next()
}

fn table(group: &Group) -> hdf5::Result<Table> {
    let columns = group.group(name::PARTICLES)?;
    let label = |label: &str| {
        let shape = columns.dataset(label)?.shape();
        Ok((label.to_owned(), shape.get(1).copied().unwrap_or(1)))
    };
    let names = text(group, name::LABELS)?;
    let labels: Vec<(String, usize)> = names.split_whitespace().map(label).collect::<hdf5::Result<_>>()?;
    let count = |dataset: Dataset| dataset.shape().first().copied().unwrap_or(0);
    let rows = match labels.first() {
        Some((label, _)) => count(columns.dataset(label)?),
        None => 0,
    };
    let blocks = count(group.dataset(name::BLOCK_COUNT)?);
    Ok(Table { name: text(group, name::MATERIAL_NAME)?, labels, blocks, rows })
}

/// A dataset that is not larger than the file.
fn dataset(group: &Group, name: &str) -> hdf5::Result<Dataset> {
    let dataset = group.dataset(name)?;
    stored::refuse_bomb(&dataset, name)?;
    Ok(dataset)
}

fn all<T: H5Type>(group: &Group, name: &str) -> hdf5::Result<Vec<T>> {
    let dataset = dataset(group, name)?;
    if dataset.size() == 0 { Ok(Vec::new()) } else { dataset.read_raw() }
}

fn rows<T: H5Type>(dataset: &Dataset, range: Range<usize>) -> hdf5::Result<Vec<T>> {
    if range.is_empty() {
        return Ok(Vec::new());
    }
    Ok(dataset.read_slice_2d((range, ..))?.into_raw_vec_and_offset().0)
}

fn number<T: H5Type>(group: &Group, name: &str) -> hdf5::Result<T> {
    group.attr(name)?.read_scalar()
}

/// As a number: one that is neither 0 nor 1 is no `bool`.
fn flag(group: &Group, name: &str) -> hdf5::Result<bool> {
    number::<i8>(group, name).map(|flag| flag != 0)
}

fn text(group: &Group, name: &str) -> hdf5::Result<String> {
    Ok(group.attr(name)?.read_scalar::<VarLenUnicode>()?.to_string())
}
