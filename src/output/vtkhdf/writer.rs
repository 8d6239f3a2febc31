//! Appends frames.
use super::name;
use crate::output::error::{self, Error, Result};
use crate::output::frame::{Field, Frame};
use crate::output::space;
use hdf5::types::{FixedAscii, VarLenUnicode};
use hdf5::{Dataset, File, FileBuilder, Group, H5Type};
use ndarray::ArrayView2;
use std::path::{Path, PathBuf};

/// Rows of a chunk; fewer if the first frame has fewer particles.
const CHUNK: usize = 65_536;
/// Rows of a chunk of the tables with one row a frame.
const TABLE_CHUNK: usize = 64;
/// Bytes for what HDF5 keeps about the data.
const SLACK: usize = 1 << 20;
/// The cell kinds that VTK demands; only the first is filled.
const TOPOLOGIES: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];

/// Writes `particles.vtkhdf` frame by frame. The file is whole and readable after every append.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    file: File,
    /// Of the first frame, by name; empty before it.
    fields: Vec<Field>,
    frames: usize,
    /// Rows a chunk: 0 before the first frame.
    chunk: usize,
    /// Row at which the next frame starts.
    next: usize,
}

impl Writer {
    /// A new file without frames; an old one of that name is overwritten.
    ///
    /// # Errors
    /// If the file cannot be created.
    pub fn create(path: &Path) -> Result<Self> {
        std::fs::File::create(path).map_err(error::io("create", path))?;
        space::reserve(path, SLACK)?;
        let file = unlocked().create(path).map_err(error::hdf5("create", path))?;
        let writer = Self { path: path.into(), file, fields: Vec::new(), frames: 0, chunk: 0, next: 0 };
        writer.lay_out().and_then(|()| writer.file.flush()).map_err(error::hdf5("create", path))?;
        Ok(writer)
    }

    /// Goes on with a file after a restart: frames later than `time` [s] are dropped.
    ///
    /// # Errors
    /// If the file cannot be opened for writing, or was not written by a [`Writer`].
    pub fn resume(path: &Path, time: f64) -> Result<Self> {
        let reader = super::Reader::open(path)?;
        let frames = reader.times().iter().take_while(|&&t| t <= time).count();
        let (fields, chunk) = (reader.fields().to_vec(), reader.chunk());
        drop(reader);
        let file = unlocked().open_rw(path).map_err(error::hdf5("open", path))?;
        let mut writer = Self { path: path.into(), file, fields, frames, chunk, next: 0 };
        writer.forget_after(frames).map_err(error::hdf5("resume", path))?;
        Ok(writer)
    }

    /// Writes one more frame. Its fields must be those of the first frame.
    ///
    /// # Errors
    /// If the disk is full, or fields differ from the first frame's; frames written before stay readable.
    pub fn append(&mut self, frame: &dyn Frame) -> Result<()> {
        let mut fields = frame.fields();
        fields.sort_by(|a, b| a.name.cmp(&b.name)); // as HDF5 lists them
        if self.chunk > 0 && fields != self.fields {
            let list = |f: &[Field]| f.iter().map(|f| f.name.clone()).collect::<Vec<_>>().join(", ");
            let problem = format!(
                "the fields of a frame changed from [{}] to [{}]; write other fields to another file",
                list(&self.fields),
                list(&fields)
            );
            return Err(Error::Content { path: self.path.clone(), problem });
        }
        space::reserve(&self.path, room(frame.particles(), &fields))?;
        self.add(frame, fields).map_err(error::hdf5("append a frame to", &self.path))?;
        space::trim(&self.path, self.file.size())
    }

    /// Number of frames so far.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Flushes and closes.
    ///
    /// # Errors
    /// If the last bytes cannot be written.
    pub fn close(self) -> Result<()> {
        self.file.flush().and_then(|()| self.file.close()).map_err(error::hdf5("close", &self.path))
    }

    fn root(&self) -> hdf5::Result<Group> {
        self.file.group(name::ROOT)
    }

    /// Everything whose shape does not depend on the particles.
    fn lay_out(&self) -> hdf5::Result<()> {
        let root = self.file.create_group(name::ROOT)?;
        root.new_attr::<i64>().shape(2).create("Version")?.write_raw(&[2i64, 0])?;
        // Older readers know only fixed-length ASCII here.
        let kind =
            FixedAscii::<8>::from_ascii("PolyData").map_err(|e| hdf5::Error::Internal(e.to_string()))?;
        root.new_attr::<FixedAscii<8>>().create("Type")?.write_scalar(&kind)?;

        table::<i64>(&root, name::COUNTS, 1)?;
        let steps = root.create_group(name::STEPS)?;
        steps.new_attr::<i64>().create(name::FRAMES)?.write_scalar(&0i64)?;
        table::<f64>(&root, name::TIMES, 1)?;
        unit(&root.dataset(name::TIMES)?, "s")?;
        for rows in [name::TAKEN, name::OFFSETS, "Steps/PartOffsets", "Steps/NumberOfParts"] {
            table::<i64>(&root, rows, 1)?;
        }
        table::<i64>(&root, "Steps/CellOffsets", 4)?;
        link(&root, "Steps/CellOffsets", "Steps/ConnectivityIdOffsets")?;
        steps.create_group("PointDataOffsets")?;
        root.create_group(name::DATA)?;

        table::<i64>(&root, "Lines/NumberOfCells", 1)?;
        for kind in TOPOLOGIES {
            if !root.link_exists(kind) {
                root.create_group(kind)?;
            }
            let source = if kind == "Vertices" { name::COUNTS } else { "Lines/NumberOfCells" };
            for rows in ["NumberOfCells", "NumberOfConnectivityIds"] {
                link(&root, source, &format!("{kind}/{rows}"))?;
            }
            // n + 1 offsets for n cells, also where n = 0: without them VTK loses the point data silently.
            let offsets = column::<i64>(&root, &format!("{kind}/Offsets"), 1, CHUNK)?;
            put(&offsets, 0, 1, &[0i64])?;
            column::<i64>(&root, &format!("{kind}/Connectivity"), 1, CHUNK)?;
        }
        Ok(())
    }

    /// The columns over particles, made when the first frame tells their number and names.
    fn lay_out_columns(&mut self, particles: usize, fields: Vec<Field>) -> hdf5::Result<()> {
        let root = self.root()?;
        let chunk = particles.clamp(1, CHUNK);
        unit(&column::<f32>(&root, name::POINTS, 3, chunk)?, "m")?;
        let data = root.group(name::DATA)?;
        column::<u64>(&data, name::IDENTITY, 1, chunk)?;
        column::<u8>(&data, name::MATERIAL, 1, chunk)?;
        for field in &fields {
            unit(&column::<f32>(&data, &field.name, field.components, chunk)?, &field.unit)?;
        }
        for column in data.member_names()? {
            link(&root, name::OFFSETS, &format!("Steps/PointDataOffsets/{column}"))?;
        }
        (self.chunk, self.fields) = (chunk, fields);
        Ok(())
    }

    fn add(&mut self, frame: &dyn Frame, fields: Vec<Field>) -> hdf5::Result<()> {
        let (start, rows) = (self.next, frame.particles());
        if self.chunk == 0 {
            self.lay_out_columns(rows, fields)?;
        }
        let root = self.root()?;
        let data = root.group(name::DATA)?;
        put(&root.dataset(name::POINTS)?, start, 3, bytemuck::cast_slice::<_, f32>(&frame.positions()))?;
        put(&data.dataset(name::IDENTITY)?, start, 1, &frame.identities())?;
        put(&data.dataset(name::MATERIAL)?, start, 1, &frame.materials())?;
        for field in &self.fields {
            put(&data.dataset(&field.name)?, start, field.components, &frame.column(field))?;
        }
        connect(&root, rows)?;

        let k = self.frames;
        put(&root.dataset(name::COUNTS)?, k, 1, &[rows as i64])?;
        put(&root.dataset(name::TIMES)?, k, 1, &[frame.time()])?;
        put(&root.dataset(name::TAKEN)?, k, 1, &[frame.step() as i64])?;
        put(&root.dataset(name::OFFSETS)?, k, 1, &[start as i64])?;
        put(&root.dataset("Steps/PartOffsets")?, k, 1, &[k as i64])?;
        put(&root.dataset("Steps/NumberOfParts")?, k, 1, &[1i64])?;
        put(&root.dataset("Steps/CellOffsets")?, k, 4, &[0i64; 4])?;
        put(&root.dataset("Lines/NumberOfCells")?, k, 1, &[0i64])?;
        // The frame must be on the disk before it counts.
        self.file.flush()?;
        self.count(k + 1)?;
        self.next = (start + rows).next_multiple_of(self.chunk);
        Ok(())
    }

    fn count(&mut self, frames: usize) -> hdf5::Result<()> {
        self.root()?.group(name::STEPS)?.attr(name::FRAMES)?.write_scalar(&(frames as i64))?;
        self.file.flush()?;
        self.frames = frames;
        Ok(())
    }

    fn forget_after(&mut self, frames: usize) -> hdf5::Result<()> {
        let root = self.root()?;
        if let Some(last) = frames.checked_sub(1) {
            let row = |table: &str| -> hdf5::Result<i64> {
                Ok(root.dataset(table)?.read_slice_1d::<i64, _>(last..=last)?[0])
            };
            self.next = (row(name::OFFSETS)? + row(name::COUNTS)?) as usize;
            self.next = self.next.next_multiple_of(self.chunk.max(1));
        }
        self.count(frames)?;
        for rows in [name::COUNTS, name::TIMES, name::TAKEN, name::OFFSETS, "Lines/NumberOfCells"] {
            root.dataset(rows)?.resize(frames)?;
        }
        for rows in ["Steps/PartOffsets", "Steps/NumberOfParts"] {
            root.dataset(rows)?.resize(frames)?;
        }
        root.dataset("Steps/CellOffsets")?.resize((frames, 4))?;
        self.file.flush()
    }
}

/// Without a lock of the file, ParaView may look at it while the run goes on, and cannot stop the run.
fn unlocked() -> FileBuilder {
    let mut builder = File::with_options();
    builder.with_fapl(|access| access.file_locking(false));
    builder
}

/// Bytes that a frame takes if nothing of it can be compressed.
fn room(particles: usize, fields: &[Field]) -> usize {
    let fixed = size_of::<[f32; 3]>() + size_of::<u64>() + size_of::<u8>();
    let connectivity = 2 * size_of::<i64>();
    let numbers: usize = fields.iter().map(|f| f.components).sum();
    (particles + CHUNK.min(particles)) * (fixed + connectivity + numbers * size_of::<f32>()) + SLACK
}

/// A compressed dataset of any number of rows.
fn column<T: H5Type>(group: &Group, path: &str, components: usize, chunk: usize) -> hdf5::Result<Dataset> {
    let dataset = group.new_dataset::<T>().shuffle().deflate(1);
    if components == 1 {
        dataset.chunk(chunk).shape(0..).create(path)
    } else {
        dataset.chunk((chunk, components)).shape((0.., components)).create(path)
    }
}

/// A dataset with a row a frame.
fn table<T: H5Type>(group: &Group, path: &str, components: usize) -> hdf5::Result<Dataset> {
    column::<T>(group, path, components, TABLE_CHUNK)
}

/// Lengthens the dataset where needed and writes rows from `start` on.
fn put<T: H5Type>(dataset: &Dataset, start: usize, components: usize, values: &[T]) -> hdf5::Result<()> {
    let end = start + values.len() / components;
    if components == 1 {
        dataset.resize(end)?;
        return if values.is_empty() { Ok(()) } else { dataset.write_slice(values, start..end) };
    }
    dataset.resize((end, components))?;
    if values.is_empty() {
        return Ok(());
    }
    let rows = ArrayView2::from_shape((end - start, components), values)
        .map_err(|e| hdf5::Error::Internal(e.to_string()))?;
    dataset.write_slice(rows, (start..end, ..))
}

/// Vertex cells 0, 1, 2…, as many as the largest frame needs.
fn connect(root: &Group, particles: usize) -> hdf5::Result<()> {
    let ids = root.dataset("Vertices/Connectivity")?;
    let known = ids.size();
    if known < particles {
        let more: Vec<i64> = (known as i64..=particles as i64).collect();
        put(&ids, known, 1, &more[..more.len() - 1])?;
        put(&root.dataset("Vertices/Offsets")?, known + 1, 1, &more[1..])?;
    }
    Ok(())
}

/// A second name for a dataset.
fn link(root: &Group, dataset: &str, alias: &str) -> hdf5::Result<()> {
    if root.link_exists(alias) { Ok(()) } else { root.link_hard(dataset, alias) }
}

fn unit(dataset: &Dataset, symbol: &str) -> hdf5::Result<()> {
    let symbol: VarLenUnicode =
        symbol.parse().map_err(|_| hdf5::Error::Internal("a unit holds a NUL".into()))?;
    dataset.new_attr::<VarLenUnicode>().create(name::UNIT)?.write_scalar(&symbol)
}
