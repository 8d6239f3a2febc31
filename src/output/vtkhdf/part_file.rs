//! The file of a frame, or of a rank's part of one.
use super::about::{columns, describe_field, name_materials, unit};
use super::{CHUNK, Entry, FileId, Part, name};
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

/// Such a file that is being written, aside.
#[derive(Debug)]
pub struct PartFile {
    path: PathBuf,
    head: Head,
    /// Positions, identities, materials, and then the fields of the head: open over the frame, so that a chunk of several
    /// pieces stays in memory.
    columns: Vec<Dataset>,
    draft: Draft,
    /// Row at which the next piece starts.
    row: usize,
}

impl PartFile {
    /// Begins a file of `head.particles` particles. `writing` is the same for all files of a frame that belong together.
    ///
    /// # Errors
    /// If there is no room for it on the disk.
    pub fn create(index: &Path, id: FileId, [run, writing]: [RunId; 2], head: Head) -> Result<Self> {
        let path = id.path(index);
        let draft = Draft::create(&path, SLACK)?;
        draft.reserve(room(&head))?;
        let columns = draft.write(|file| {
            run.write(file)?;
            place(file, id, writing)?;
            lay_out(file, &head)
        })?;
        Ok(Self { path, head, columns, draft, row: 0 })
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

    /// Seals the file and puts it in place.
    ///
    /// # Errors
    /// If it cannot be written, or pieces are missing.
    pub fn finish(self) -> Result<Part> {
        let Self { path, head: Head { particles, .. }, columns, draft, row } = self;
        if row != particles {
            let problem = format!("a frame of {particles} particles got {row}");
            return Err(Error::Content { path, problem });
        }
        drop(columns);
        Ok(Part { particles, digest: draft.finish()? })
    }
}

/// What a file says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    pub part: Part,
    /// What all files of a frame have.
    pub of_frame: OfFrame,
}

/// What all files of a frame say.
#[derive(Clone, Debug, PartialEq)]
pub struct OfFrame {
    pub time: f64,
    pub step: u64,
    pub columns: Columns,
    /// Of several: who wrote them together.
    writing: Option<RunId>,
}

/// What a file says of itself.
///
/// # Errors
/// If it is damaged, no frame, or one of another run.
pub fn describe(index: &Path, id: FileId, run: RunId) -> Result<Description> {
    let path = &id.path(index);
    let digest = seal::verify(path)?;
    let file = stored::open(path, Virtual::Refused)?;
    let wrong = |problem: &str| Err(Error::Content { path: path.into(), problem: problem.into() });
    if RunId::read(&file).is_ok_and(|its| its != run) {
        return wrong("it is a frame of another run");
    }
    let read = || -> hdf5::Result<(Description, [u64; 2])> {
        let number = |name| attribute::<u64>(&file, name);
        let several = file.attr_names()?.iter().any(|name| name == name::PARTS);
        let writing = several.then(|| RunId::read_as(&file, name::WRITING)).transpose()?;
        let place = if several { [number(name::PART)?, number(name::PARTS)?] } else { [0, 1] };
        let part = Part { particles: number(name::PARTICLES)? as usize, digest };
        let columns = columns(&file.group(name::DATA)?)?;
        let of_frame =
            OfFrame { time: attribute(&file, name::TIME)?, step: number(name::STEP)?, columns, writing };
        Ok((Description { part, of_frame }, place))
    };
    let (description, place) = read().map_err(|source| not_ours(path, &source))?;
    if place != [id.part, id.parts].map(|n| n as u64) {
        return wrong("it is another part of a frame than its name says");
    }
    Ok(description)
}

/// Reads a frame that the index knows, with those of its fields that are named.
///
/// # Errors
/// If it is damaged, or another one.
pub fn read(index: &Path, entry: &Entry, fields: &[Field], names: &[&str]) -> Result<Snapshot> {
    let wanted = fields.iter().filter(|field| names.contains(&field.name.as_str()));
    let mut all = Snapshot { time: entry.time, step: entry.step, ..Snapshot::default() };
    all.columns = wanted.map(|field| (field.clone(), Vec::new())).collect();
    for (id, part) in entry.files() {
        add(&mut all, &id.path(index), part)?;
    }
    Ok(all)
}

/// Adds the particles of a file to a frame.
fn add(all: &mut Snapshot, path: &Path, part: &Part) -> Result<()> {
    if seal::verify(path)? != part.digest {
        let problem = "it is not the frame that the index names: another run wrote it".into();
        return Err(Error::Content { path: path.into(), problem });
    }
    let file = stored::open(path, Virtual::Refused)?;
    let n = part.particles;
    let mut read = || -> hdf5::Result<()> {
        let data = file.group(name::DATA)?;
        all.positions.extend(table(&file, name::POINTS, n, 3)?.as_chunks::<3>().0);
        all.identities.extend(table::<u64>(&data, name::IDENTITY, n, 1)?);
        all.materials.extend(table::<u16>(&data, name::MATERIAL, n, 1)?);
        for (field, values) in &mut all.columns {
            values.extend(table::<f32>(&data, &field.name, n, field.components)?);
        }
        Ok(())
    };
    read().map_err(|source| not_ours(path, &source))
}

/// States which part of a frame a file is, if it is not all of it.
fn place(file: &File, id: FileId, writing: RunId) -> hdf5::Result<()> {
    if id.parts == 1 {
        return Ok(());
    }
    for (name, number) in [(name::PART, id.part), (name::PARTS, id.parts)] {
        file.new_attr::<u64>().create(name)?.write_scalar(&(number as u64))?;
    }
    writing.write_as(file, name::WRITING)
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

/// Bytes that a file takes if nothing of it can be compressed.
fn room(head: &Head) -> usize {
    let fixed = size_of::<[f32; 3]>() + size_of::<u64>() + size_of::<u16>();
    let numbers: usize = head.columns.fields.iter().map(|f| f.components).sum();
    let rows = head.particles.next_multiple_of(CHUNK.min(head.particles.max(1)));
    let chunks = (3 + head.columns.fields.len()) * rows.div_ceil(CHUNK);
    rows * (fixed + numbers * size_of::<f32>()) + chunks * CHUNK_ENTRY + SLACK
}
