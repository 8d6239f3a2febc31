//! The file of one frame.
use super::about::{columns, describe_field, name_materials, unit};
use super::{CHUNK, Entry, name};
use crate::output::draft::Draft;
use crate::output::error::{Error, Result};
use crate::output::frame::{Columns, Field, Head, Piece};
use crate::output::run_id::RunId;
use crate::output::seal;
use crate::output::snapshot::Snapshot;
use crate::output::stored::{self, Virtual, table};
use hdf5::{Dataset, File, Group, H5Type};
use ndarray::ArrayView2;
use std::path::{Path, PathBuf};

/// Bytes for what HDF5 keeps about all of it, and about a chunk of a column.
const SLACK: usize = 1 << 17;
const CHUNK_ENTRY: usize = 128;

/// A frame that is being written, aside.
#[derive(Debug)]
pub struct FrameFile {
    path: PathBuf,
    head: Head,
    /// Positions, identities, materials, and then the fields of the head: open over the frame, so that a chunk of several
    /// pieces stays in memory.
    columns: Vec<Dataset>,
    draft: Draft,
    /// Row at which the next piece starts.
    row: usize,
}

impl FrameFile {
    /// Begins a frame of a run.
    ///
    /// # Errors
    /// If there is no room for it on the disk.
    pub fn create(path: &Path, run: RunId, head: Head) -> Result<Self> {
        let draft = Draft::create(path, SLACK)?;
        draft.reserve(room(&head))?;
        let columns = draft.write(|file| run.write(file).and_then(|()| lay_out(file, &head)))?;
        Ok(Self { path: path.into(), head, columns, draft, row: 0 })
    }

    /// Writes the next particles.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn piece(&mut self, piece: &Piece) -> Result<()> {
        let write = |_: &File| -> hdf5::Result<()> {
            put(&self.columns[0], self.row, 3, piece.positions.as_flattened())?;
            put(&self.columns[1], self.row, 1, &piece.identities)?;
            put(&self.columns[2], self.row, 1, &piece.materials)?;
            let fields = self.head.columns.fields.iter().zip(&self.columns[3..]).zip(&piece.columns);
            for ((field, column), values) in fields {
                put(column, self.row, field.components, values)?;
            }
            Ok(())
        };
        self.draft.write(write)?;
        self.row += piece.positions.len();
        Ok(())
    }

    /// Seals the frame and puts it in place, as file `number`.
    ///
    /// # Errors
    /// If it cannot be written, or pieces are missing.
    pub fn finish(self, number: u64) -> Result<Entry> {
        let Self { path, head: Head { time, step, particles, .. }, columns, draft, row } = self;
        if row != particles {
            let problem = format!("a frame of {particles} particles got {row}");
            return Err(Error::Content { path, problem });
        }
        drop(columns);
        let digest = draft.finish()?;
        Ok(Entry { number, time, step, particles, digest })
    }
}

/// What a frame's file says of itself.
///
/// # Errors
/// If it is damaged, no frame, or one of another run.
pub fn describe(path: &Path, run: RunId, number: u64) -> Result<(Entry, Columns)> {
    let digest = seal::verify(path)?;
    let file = stored::open(path, Virtual::Refused)?;
    let read = || -> hdf5::Result<(Entry, Columns)> {
        let [step, particles] = [name::STEP, name::PARTICLES].map(|name| attribute::<u64>(&file, name));
        let (time, particles) = (attribute(&file, name::TIME)?, particles? as usize);
        let columns = columns(&file.group(name::DATA)?)?;
        Ok((Entry { number, time, step: step?, particles, digest }, columns))
    };
    if RunId::read(&file).is_ok_and(|its| its != run) {
        return Err(Error::Content { path: path.into(), problem: "it is a frame of another run".into() });
    }
    read().map_err(|source| not_ours(path, &source))
}

/// Reads a frame that the index knows, with those of its fields that are named.
///
/// # Errors
/// If it is damaged, or another one.
pub fn read(path: &Path, entry: &Entry, fields: &[Field], names: &[&str]) -> Result<Snapshot> {
    if seal::verify(path)? != entry.digest {
        let problem = "it is not the frame that the index names: another run wrote it".into();
        return Err(Error::Content { path: path.into(), problem });
    }
    let file = stored::open(path, Virtual::Refused)?;
    let n = entry.particles;
    let read = || -> hdf5::Result<Snapshot> {
        let data = file.group(name::DATA)?;
        let wanted = fields.iter().filter(|field| names.contains(&field.name.as_str()));
        let positions: Vec<f32> = table(&file, name::POINTS, n, 3)?;
        let column = |field: &Field| Ok((field.clone(), table(&data, &field.name, n, field.components)?));
        Ok(Snapshot {
            time: entry.time,
            step: entry.step,
            identities: table(&data, name::IDENTITY, n, 1)?,
            materials: table(&data, name::MATERIAL, n, 1)?,
            positions: positions.as_chunks().0.to_vec(),
            columns: wanted.map(column).collect::<hdf5::Result<_>>()?,
        })
    };
    read().map_err(|source| not_ours(path, &source))
}

fn not_ours(path: &Path, source: &hdf5::Error) -> Error {
    Error::Content { path: path.into(), problem: format!("not a frame of Sinew ({source})") }
}

fn lay_out(file: &File, head: &Head) -> hdf5::Result<Vec<Dataset>> {
    let n = head.particles;
    file.new_attr::<f64>().create(name::TIME)?.write_scalar(&head.time)?;
    file.new_attr::<u64>().create(name::STEP)?.write_scalar(&head.step)?;
    file.new_attr::<u64>().create(name::PARTICLES)?.write_scalar(&(n as u64))?;
    let data = file.create_group(name::DATA)?;
    let mut columns = vec![
        column::<f32>(file, name::POINTS, n, 3)?,
        column::<u64>(&data, name::IDENTITY, n, 1)?,
        column::<u16>(&data, name::MATERIAL, n, 1)?,
    ];
    unit(&columns[0], "m")?;
    name_materials(&columns[2], &head.columns.materials)?;
    for field in &head.columns.fields {
        let made = column::<f32>(&data, &field.name, n, field.components)?;
        describe_field(&made, field)?;
        columns.push(made);
    }
    Ok(columns)
}

/// A compressed dataset.
fn column<T: H5Type>(group: &Group, path: &str, rows: usize, components: usize) -> hdf5::Result<Dataset> {
    let dataset = group.new_dataset::<T>();
    let chunk = rows.min(CHUNK);
    match (rows, components) {
        (0, 1) => dataset.shape(0).create(path),
        (0, _) => dataset.shape((0, components)).create(path),
        (_, 1) => dataset.shuffle().deflate(1).chunk(chunk).shape(rows).create(path),
        _ => dataset.shuffle().deflate(1).chunk((chunk, components)).shape((rows, components)).create(path),
    }
}

/// Writes rows from `start` on.
fn put<T: H5Type>(dataset: &Dataset, start: usize, components: usize, values: &[T]) -> hdf5::Result<()> {
    if values.is_empty() {
        return Ok(());
    }
    let end = start + values.len() / components;
    if components == 1 {
        return dataset.write_slice(values, start..end);
    }
    let rows = ArrayView2::from_shape((end - start, components), values)
        .map_err(|e| hdf5::Error::Internal(e.to_string()))?;
    dataset.write_slice(rows, (start..end, ..))
}

fn attribute<T: H5Type>(group: &Group, name: &str) -> hdf5::Result<T> {
    group.attr(name)?.read_scalar()
}

/// Bytes that a frame takes if nothing of it can be compressed.
fn room(head: &Head) -> usize {
    let fixed = size_of::<[f32; 3]>() + size_of::<u64>() + size_of::<u16>();
    let numbers: usize = head.columns.fields.iter().map(|f| f.components).sum();
    let rows = head.particles.next_multiple_of(CHUNK.min(head.particles.max(1)));
    let chunks = (3 + head.columns.fields.len()) * rows.div_ceil(CHUNK);
    rows * (fixed + numbers * size_of::<f32>()) + chunks * CHUNK_ENTRY + SLACK
}
