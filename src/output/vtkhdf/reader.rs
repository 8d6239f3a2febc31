//! Reads frames back.
use super::name;
use crate::output::error::{self, Error, Result};
use crate::output::frame::Field;
use crate::output::snapshot::Snapshot;
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File, FileBuilder, Group, H5Type};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// An open `particles.vtkhdf`.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    root: Group,
    times: Vec<f64>,
    steps: Vec<u64>,
    rows: Vec<Range<usize>>,
    fields: Vec<Field>,
}

impl Reader {
    /// Opens a file that a [`super::Writer`] wrote, or is still writing.
    ///
    /// # Errors
    /// If the file is missing, damaged, or of another kind.
    pub fn open(path: &Path) -> Result<Self> {
        std::fs::File::open(path).map_err(error::io("open", path))?;
        let mut file = FileBuilder::new();
        file.with_fapl(|access| access.file_locking(false));
        let file = file.open(path).map_err(error::hdf5("open", path))?;
        Self::index(path, &file).map_err(|source| Error::Content {
            path: path.into(),
            problem: format!("not a particle file of Sinew ({source})"),
        })
    }

    fn index(path: &Path, file: &File) -> hdf5::Result<Self> {
        let root = file.group(name::ROOT)?;
        let frames = root.group(name::STEPS)?.attr(name::FRAMES)?.read_scalar::<i64>()? as usize;
        let table = |path: &str| rows::<i64>(&root.dataset(path)?, 0..frames);
        let rows_of = |(start, count): (&i64, &i64)| *start as usize..(start + count) as usize;
        Ok(Self {
            path: path.into(),
            times: rows(&root.dataset(name::TIMES)?, 0..frames)?,
            steps: table(name::TAKEN)?.into_iter().map(|n| n as u64).collect(),
            rows: table(name::OFFSETS)?.iter().zip(&table(name::COUNTS)?).map(rows_of).collect(),
            fields: fields(&root.group(name::DATA)?)?,
            root,
        })
    }

    /// Number of whole frames.
    pub fn frames(&self) -> usize {
        self.times.len()
    }

    /// Time of each frame [s].
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Fields of every frame.
    pub fn fields(&self) -> &[Field] {
        &self.fields
    }

    /// Frame `k` with all fields.
    ///
    /// # Errors
    /// If there is no such frame, or the file is damaged.
    pub fn frame(&self, k: usize) -> Result<Snapshot> {
        let names: Vec<&str> = self.fields.iter().map(|f| f.name.as_str()).collect();
        self.frame_with(k, &names)
    }

    /// Frame `k` with those of the named fields that the file has.
    ///
    /// # Errors
    /// If there is no such frame, or the file is damaged.
    pub fn frame_with(&self, k: usize, names: &[&str]) -> Result<Snapshot> {
        if k >= self.frames() {
            let problem = format!("there is no frame {k}: the file has {} (counted from 0)", self.frames());
            return Err(Error::Content { path: self.path.clone(), problem });
        }
        self.read(k, names).map_err(error::hdf5("read", &self.path))
    }

    fn read(&self, k: usize, names: &[&str]) -> hdf5::Result<Snapshot> {
        let range = || self.rows[k].clone();
        let data = self.root.group(name::DATA)?;
        let wanted = self.fields.iter().filter(|f| names.contains(&f.name.as_str()));
        let positions: Vec<f32> = rows(&self.root.dataset(name::POINTS)?, range())?;
        Ok(Snapshot {
            time: self.times[k],
            step: self.steps[k],
            identities: rows(&data.dataset(name::IDENTITY)?, range())?,
            // bytes in files of an older Sinew: HDF5 widens them
            materials: rows(&data.dataset(name::MATERIAL)?, range())?,
            positions: positions.as_chunks().0.to_vec(),
            columns: wanted
                .map(|f| Ok((f.clone(), rows(&data.dataset(&f.name)?, range())?)))
                .collect::<hdf5::Result<_>>()?,
        })
    }

    /// Rows a chunk of the columns; 0 if there are none yet.
    pub(super) fn chunk(&self) -> usize {
        self.root.dataset(name::POINTS).ok().and_then(|points| points.chunk()).map_or(0, |shape| shape[0])
    }
}

fn fields(data: &Group) -> hdf5::Result<Vec<Field>> {
    let ours = |n: &String| n != name::IDENTITY && n != name::MATERIAL;
    let read = |name: String| {
        let column = data.dataset(&name)?;
        let unit = column.attr(name::UNIT)?.read_scalar::<VarLenUnicode>()?.to_string();
        Ok(Field { name, unit, components: column.shape().get(1).copied().unwrap_or(1) })
    };
    data.member_names()?.into_iter().filter(ours).map(read).collect()
}

/// Rows of a dataset of one or two dimensions, flat.
fn rows<T: H5Type>(dataset: &Dataset, range: Range<usize>) -> hdf5::Result<Vec<T>> {
    if range.is_empty() {
        return Ok(Vec::new());
    }
    Ok(match dataset.ndim() {
        1 => dataset.read_slice_1d(range)?.into_raw_vec_and_offset().0,
        _ => dataset.read_slice_2d((range, ..))?.into_raw_vec_and_offset().0,
    })
}
