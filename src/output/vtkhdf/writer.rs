//! Appends frames.
use super::name;
use super::rows::{column, connect, link, put, table, unit};
use crate::output::error::{self, Error, Result};
use crate::output::frame::{Field, Frame, Head, Piece};
use crate::output::space;
use hdf5::file::{CacheDecreaseMode, CacheIncreaseMode, FlashIncreaseMode, MetadataCacheConfig};
use hdf5::types::FixedAscii;
use hdf5::{Dataset, File, FileBuilder, Group};
use std::path::{Path, PathBuf};

/// Rows of a chunk; fewer if the first frame has fewer particles. Pieces that end at a multiple of it are written once.
pub const CHUNK: usize = 65_536;
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
    /// The frame that is being written.
    open: Option<Open>,
}

/// A frame of which some pieces are written.
#[derive(Debug)]
struct Open {
    head: Head,
    /// Positions, identities, materials: open over the frame, so that a chunk of several pieces stays in memory.
    always: [Dataset; 3],
    /// The last material that its dataset can name: files of an older Sinew have bytes there.
    last_material: u16,
    /// A dataset for each field of the head.
    columns: Vec<Dataset>,
    /// Row at which the next piece starts.
    row: usize,
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
        let fields = Vec::new();
        let writer = Self { path: path.into(), file, fields, frames: 0, chunk: 0, next: 0, open: None };
        writer.lay_out().and_then(|()| writer.file.flush()).map_err(error::hdf5("create", path))?;
        Ok(writer)
    }

    /// Goes on with a file after a restart: keeps its first `frames` frames.
    ///
    /// # Errors
    /// If the file cannot be opened for writing, was not written by a [`Writer`], has fewer frames, or its writer was
    /// stopped while it wrote down what the file holds.
    pub fn resume(path: &Path, frames: usize) -> Result<Self> {
        let content = |problem: String| Error::Content { path: path.into(), problem };
        if mark(path).exists() {
            return Err(content("its writer was stopped in the middle of a frame".into()));
        }
        let reader = super::Reader::open(path)?;
        if reader.frames() < frames {
            return Err(content(format!("it has {} frames, not {frames}", reader.frames())));
        }
        let (fields, chunk, more) = (reader.fields().to_vec(), reader.chunk(), reader.frames() > frames);
        drop(reader);
        let file = unlocked().open_rw(path).map_err(error::hdf5("open", path))?;
        let mut writer = Self { path: path.into(), file, fields, frames, chunk, next: 0, open: None };
        writer.next = writer.end_of(frames).map_err(error::hdf5("resume", path))?;
        if more {
            writer.marked(|writer| writer.forget_after(frames), "resume")?;
        }
        Ok(writer)
    }

    /// Writes one more frame that is in memory. Its fields must be those of the first frame.
    ///
    /// # Errors
    /// If the disk is full, or fields differ from the first frame's; frames written before stay readable.
    pub fn append(&mut self, frame: &dyn Frame) -> Result<()> {
        let fields = frame.fields();
        let piece = Piece {
            identities: frame.identities(),
            materials: frame.materials(),
            positions: frame.positions(),
            columns: fields.iter().map(|field| frame.column(field)).collect(),
        };
        let (time, step, particles) = (frame.time(), frame.step(), frame.particles());
        self.begin(Head { time, step, particles, fields })?;
        self.piece(&piece)?;
        self.end()
    }

    /// Begins one more frame. Its fields must be those of the first frame.
    ///
    /// # Errors
    /// If there is no room for it on the disk, or fields differ from the first frame's.
    pub fn begin(&mut self, head: Head) -> Result<()> {
        self.open = None;
        let mut fields = head.fields.clone();
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
        space::reserve(&self.path, room(head.particles, &fields))?;
        self.open = Some(self.columns(head, fields).map_err(error::hdf5("append a frame to", &self.path))?);
        Ok(())
    }

    /// Writes the next particles of the frame that was begun.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn piece(&mut self, piece: &Piece) -> Result<()> {
        let Some(open) = &mut self.open else { return Ok(()) };
        if let Some(material) = piece.materials.iter().find(|&&m| m > open.last_material) {
            let problem = format!(
                "an older Sinew began it, with room for materials 0 to {}, not for {material}: move it away and restart the \
                 run, then frames begin anew",
                open.last_material
            );
            return Err(Error::Content { path: self.path.clone(), problem });
        }
        let rows = piece.positions.len();
        let write = || -> hdf5::Result<()> {
            put(&open.always[0], open.row, 3, bytemuck::cast_slice::<_, f32>(&piece.positions))?;
            put(&open.always[1], open.row, 1, &piece.identities)?;
            put(&open.always[2], open.row, 1, &piece.materials)?;
            for ((field, column), values) in open.head.fields.iter().zip(&open.columns).zip(&piece.columns) {
                put(column, open.row, field.components, values)?;
            }
            Ok(())
        };
        write().map_err(error::hdf5("append a frame to", &self.path))?;
        open.row += rows;
        Ok(())
    }

    /// Ends the frame: from now on it counts.
    ///
    /// # Errors
    /// If it cannot be written, or pieces are missing; frames written before stay readable.
    pub fn end(&mut self) -> Result<()> {
        let Some(Open { head, row, .. }) = self.open.take() else { return Ok(()) };
        if row != self.next + head.particles {
            let problem = format!("a frame of {} particles got {}", head.particles, row - self.next);
            return Err(Error::Content { path: self.path.clone(), problem });
        }
        self.enter(&head).map_err(error::hdf5("append a frame to", &self.path))?;
        self.marked(|writer| writer.count(writer.frames + 1), "append a frame to")?;
        self.next = row.next_multiple_of(self.chunk);
        space::trim(&self.path, self.file.size())
    }

    /// Number of frames so far.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Waits until the disk has all frames.
    ///
    /// # Errors
    /// If it does not take them.
    pub fn sync(&self) -> Result<()> {
        let file = std::fs::File::open(&self.path);
        file.and_then(|file| file.sync_data()).map_err(error::io("write", &self.path))
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
        column::<u16>(&data, name::MATERIAL, 1, chunk)?;
        for field in &fields {
            unit(&column::<f32>(&data, &field.name, field.components, chunk)?, &field.unit)?;
        }
        for column in data.member_names()? {
            link(&root, name::OFFSETS, &format!("Steps/PointDataOffsets/{column}"))?;
        }
        (self.chunk, self.fields) = (chunk, fields);
        Ok(())
    }

    /// The datasets of a frame that begins, with the columns laid out if it is the first.
    fn columns(&mut self, head: Head, fields: Vec<Field>) -> hdf5::Result<Open> {
        if self.chunk == 0 {
            self.lay_out_columns(head.particles, fields)?;
        }
        let root = self.root()?;
        let data = root.group(name::DATA)?;
        let always =
            [root.dataset(name::POINTS)?, data.dataset(name::IDENTITY)?, data.dataset(name::MATERIAL)?];
        let last_material = if always[2].dtype()?.size() == 1 { u8::MAX.into() } else { u16::MAX };
        let columns =
            head.fields.iter().map(|field| data.dataset(&field.name)).collect::<hdf5::Result<_>>()?;
        Ok(Open { head, always, last_material, columns, row: self.next })
    }

    /// What the tables say about a frame whose particles are written.
    fn enter(&mut self, head: &Head) -> hdf5::Result<()> {
        let root = self.root()?;
        connect(&root, head.particles)?;
        let k = self.frames;
        put(&root.dataset(name::COUNTS)?, k, 1, &[head.particles as i64])?;
        put(&root.dataset(name::TIMES)?, k, 1, &[head.time])?;
        put(&root.dataset(name::TAKEN)?, k, 1, &[head.step as i64])?;
        put(&root.dataset(name::OFFSETS)?, k, 1, &[self.next as i64])?;
        put(&root.dataset("Steps/PartOffsets")?, k, 1, &[k as i64])?;
        put(&root.dataset("Steps/NumberOfParts")?, k, 1, &[1i64])?;
        put(&root.dataset("Steps/CellOffsets")?, k, 4, &[0i64; 4])?;
        put(&root.dataset("Lines/NumberOfCells")?, k, 1, &[0i64])
    }

    /// Changes what the file says that it holds. A mark beside it tells whoever resumes a run that was killed in
    /// the middle of this. At other times HDF5 keeps such changes in memory: see [`unlocked`].
    fn marked(
        &mut self,
        change: impl FnOnce(&mut Self) -> hdf5::Result<()>,
        action: &'static str,
    ) -> Result<()> {
        let mark = mark(&self.path);
        std::fs::write(&mark, b"").map_err(error::io("write", &mark))?;
        // what the change counts must be on the disk before it counts
        self.file.flush().and_then(|()| change(self)).map_err(error::hdf5(action, &self.path))?;
        std::fs::remove_file(&mark).map_err(error::io("remove", &mark))
    }

    fn count(&mut self, frames: usize) -> hdf5::Result<()> {
        self.root()?.group(name::STEPS)?.attr(name::FRAMES)?.write_scalar(&(frames as i64))?;
        self.file.flush()?;
        self.frames = frames;
        Ok(())
    }

    /// Row behind the first `frames` frames.
    fn end_of(&self, frames: usize) -> hdf5::Result<usize> {
        let Some(last) = frames.checked_sub(1) else { return Ok(0) };
        let root = self.root()?;
        let row = |table: &str| -> hdf5::Result<usize> {
            Ok(root.dataset(table)?.read_slice_1d::<i64, _>(last..=last)?[0] as usize)
        };
        Ok((row(name::OFFSETS)? + row(name::COUNTS)?).next_multiple_of(self.chunk.max(1)))
    }

    fn forget_after(&mut self, frames: usize) -> hdf5::Result<()> {
        let root = self.root()?;
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

/// The file beside a particle file that says that its tables are being written.
fn mark(path: &Path) -> PathBuf {
    path.with_added_extension("unfinished")
}

/// Without a lock of the file, ParaView may look at it while the run goes on, and cannot stop the run. Tables are written
/// when they are flushed and at no other time, so that a run that is killed leaves the frames before.
fn unlocked() -> FileBuilder {
    let cache = MetadataCacheConfig {
        evictions_enabled: false,
        incr_mode: CacheIncreaseMode::Off,
        flash_incr_mode: FlashIncreaseMode::Off,
        decr_mode: CacheDecreaseMode::Off,
        ..MetadataCacheConfig::default()
    };
    let mut builder = File::with_options();
    builder.with_fapl(|access| access.file_locking(false).mdc_config(&cache));
    builder
}

/// Bytes that a frame takes if nothing of it can be compressed.
fn room(particles: usize, fields: &[Field]) -> usize {
    let fixed = size_of::<[f32; 3]>() + size_of::<u64>() + size_of::<u16>();
    let connectivity = 2 * size_of::<i64>();
    let numbers: usize = fields.iter().map(|f| f.components).sum();
    (particles + CHUNK.min(particles)) * (fixed + connectivity + numbers * size_of::<f32>()) + SLACK
}
