//! The index: what VTK reads, composed of the files of the frames.
use super::about::{columns, describe_field, name_materials, unit};
use super::{Entry, Part, name, relative};
use crate::output::draft::Draft;
use crate::output::error::{Error, Result};
use crate::output::frame::Columns;
use crate::output::run_id::RunId;
use crate::output::seal;
use crate::output::stored::{self, Virtual, table};
use hdf5::types::{FixedAscii, OwnedDynValue};
use hdf5::{Dataset, File, Group, H5Type, Selection};
use std::path::Path;

/// The cell kinds that VTK demands; only the first is filled.
const TOPOLOGIES: [&str; 4] = ["Vertices", "Lines", "Polygons", "Strips"];
/// Bytes for what HDF5 keeps about all of it, and about a part of a virtual dataset.
const SLACK: usize = 1 << 15;
const PART: usize = 512;
/// The file of the vertices 0, 1, 2…, which all frames share.
pub const CELLS: &str = "cells.h5";
const CONNECTIVITY: &str = "Connectivity";
const CELL_OFFSETS: &str = "Offsets";

/// What an index says.
#[derive(Clone, Debug, PartialEq)]
pub struct Index {
    /// Whose frames.
    pub run: RunId,
    pub columns: Columns,
    pub entries: Vec<Entry>,
}

/// Writes the index of some frames, in place of the one that was there.
///
/// # Errors
/// If it cannot be written; then the old one stays.
pub fn write(path: &Path, run: RunId, columns: &Columns, entries: &[Entry]) -> Result<()> {
    let draft = Draft::create(path, SLACK)?;
    draft.reserve(room(columns, entries))?;
    draft.write(|file| lay_out(file, run, columns, entries))?;
    draft.finish().map(drop)
}

/// Reads an index.
///
/// # Errors
/// If the file is missing, damaged, or of another kind.
pub fn read(path: &Path) -> Result<Index> {
    seal::verify(path)?;
    let file = stored::open(path, Virtual::Passed)?;
    let read = || -> hdf5::Result<Index> {
        let root = file.group(name::ROOT)?;
        let n = root.group(name::STEPS)?.attr(name::FRAMES)?.read_scalar::<i64>()?;
        let n = usize::try_from(n).map_err(|_| hdf5::Error::Internal(format!("{n} frames")))?;
        let whole = |name: &str| table::<u64>(&root, name, n, 1);
        let (steps, numbers, mut parts) = (whole(name::TAKEN)?, whole(name::NUMBERS)?, parts(&root, n)?);
        let times: Vec<f64> = table(&root, name::TIMES, n, 1)?;
        let entry = |k: usize| Entry {
            number: numbers[k],
            time: times[k],
            step: steps[k],
            parts: std::mem::take(&mut parts[k]),
        };
        let columns = columns(&root.group(name::DATA)?)?;
        Ok(Index { run: RunId::read(&root)?, columns, entries: (0..n).map(entry).collect() })
    };
    read().map_err(|source| Error::Content {
        path: path.into(),
        problem: format!("not a particle file of Sinew ({source})"),
    })
}

/// The files of `n` frames. Where it is not said how many they are, it is one each.
fn parts(root: &Group, n: usize) -> hdf5::Result<Vec<Vec<Part>>> {
    let several = root.link_exists(name::FILES);
    let files = if several { table::<u64>(root, name::FILES, n, 1)? } else { vec![1; n] };
    let all = root.dataset(name::DIGESTS)?.shape().first().copied().unwrap_or(0);
    let rows: Vec<u64> = table(root, if several { name::ROWS } else { name::COUNTS }, all, 1)?;
    let digests: Vec<u64> = table(root, name::DIGESTS, all, 2)?;
    let mut rest = rows.iter().zip(digests.as_chunks::<2>().0).map(|(&rows, &[high, low])| Part {
        particles: rows as usize,
        digest: u128::from(high) << 64 | u128::from(low),
    });
    let frames: Vec<Vec<Part>> =
        files.iter().map(|&count| rest.by_ref().take(count as usize).collect()).collect();
    let fit = frames.iter().zip(&files).all(|(parts, &count)| count > 0 && parts.len() as u64 == count);
    if fit && rest.next().is_none() { Ok(frames) } else { Err("frames and their files do not fit".into()) }
}

/// Writes the vertices 0 … n − 1, of which every frame shows as many as it has particles.
///
/// # Errors
/// If they cannot be written.
pub fn write_cells(index: &Path, n: usize) -> Result<()> {
    let path = super::folder(index).join(CELLS);
    let lay_out = |file: &File| -> hdf5::Result<()> {
        let numbers: Vec<i64> = (0..=n as i64).collect();
        for (name, values) in [(CONNECTIVITY, &numbers[..n]), (CELL_OFFSETS, &numbers)] {
            let dataset = file.new_dataset::<i64>().shuffle().deflate(1);
            dataset
                .chunk(values.len().clamp(1, super::CHUNK))
                .shape(values.len())
                .create(name)?
                .write(values)?;
        }
        Ok(())
    };
    let rows = (n + 1).next_multiple_of(super::CHUNK.min(n + 1));
    let draft = Draft::create(&path, SLACK)?;
    draft.reserve(2 * size_of::<i64>() * rows + SLACK)?;
    draft.write(lay_out)?;
    draft.finish().map(drop)
}

fn lay_out(file: &File, run: RunId, columns: &Columns, entries: &[Entry]) -> hdf5::Result<()> {
    let root = file.create_group(name::ROOT)?;
    root.new_attr::<i64>().shape(2).create("Version")?.write_raw(&[2i64, 0])?;
    // older readers know only fixed-length ASCII here
    let kind = FixedAscii::<8>::from_ascii("PolyData").map_err(|e| hdf5::Error::Internal(e.to_string()))?;
    root.new_attr::<FixedAscii<8>>().create("Type")?.write_scalar(&kind)?;
    run.write(&root)?;
    steps(&root, entries)?;
    cells(&root, entries)?;

    let composed = Composed(entries);
    let data = root.create_group(name::DATA)?;
    if !entries.is_empty() {
        unit(&composed.dataset::<f32>(&root, name::POINTS, name::POINTS, 3, f32::NAN)?, "m")?;
        let of = |name: &str| format!("{}/{name}", name::DATA);
        composed.dataset::<u64>(&data, name::IDENTITY, &of(name::IDENTITY), 1, u64::MAX)?;
        let made = composed.dataset::<u16>(&data, name::MATERIAL, &of(name::MATERIAL), 1, u16::MAX)?;
        name_materials(&made, &columns.materials)?;
        for field in &columns.fields {
            let (name, width) = (&field.name, field.components);
            let made = composed.dataset::<f32>(&data, name, &of(name), width, f32::NAN)?;
            describe_field(&made, field)?;
        }
    }
    root.create_group("Steps/PointDataOffsets")?;
    for column in data.member_names()? {
        root.link_hard(name::OFFSETS, &format!("Steps/PointDataOffsets/{column}"))?;
    }
    Ok(())
}

/// The tables with a row a frame. Rows of equal content are one dataset under several names.
fn steps(root: &Group, entries: &[Entry]) -> hdf5::Result<()> {
    let n = entries.len();
    let all = |value: &dyn Fn(usize, &Entry) -> i64| -> Vec<i64> {
        entries.iter().enumerate().map(|(k, entry)| value(k, entry)).collect()
    };
    let steps = root.create_group(name::STEPS)?;
    steps.new_attr::<i64>().create(name::FRAMES)?.write_scalar(&(n as i64))?;
    let times = root.new_dataset::<f64>().shape(n).create(name::TIMES)?;
    fill(&times, &entries.iter().map(|entry| entry.time).collect::<Vec<_>>())?;
    unit(&times, "s")?;
    let ends = entries.iter().scan(0, |row, entry| {
        *row += entry.particles() as i64;
        Some(*row)
    });
    let offsets: Vec<i64> = std::iter::once(0).chain(ends).take(n).collect();
    let tables = [
        (name::COUNTS, all(&|_, entry| entry.particles() as i64)),
        (name::TAKEN, all(&|_, entry| entry.step as i64)),
        (name::NUMBERS, all(&|_, entry| entry.number as i64)),
        (name::FILES, all(&|_, entry| entry.parts.len() as i64)),
        (name::OFFSETS, offsets),
        ("Steps/PartOffsets", all(&|k, _| k as i64)),
        ("Steps/NumberOfParts", all(&|_, _| 1)),
    ];
    for (name, values) in tables {
        fill(&root.new_dataset::<i64>().shape(n).create(name)?, &values)?;
    }
    let parts = || entries.iter().flat_map(|entry| &entry.parts);
    let rows: Vec<i64> = parts().map(|part| part.particles as i64).collect();
    fill(&root.new_dataset::<i64>().shape(rows.len()).create(name::ROWS)?, &rows)?;
    let digests: Vec<u64> = parts().flat_map(|p| [(p.digest >> 64) as u64, p.digest as u64]).collect();
    fill(&root.new_dataset::<u64>().shape((rows.len(), 2)).create(name::DIGESTS)?, &digests)?;
    // all frames share the vertices, so that their cells begin at the first one
    fill(&root.new_dataset::<i64>().shape((n, 4)).create("Steps/CellOffsets")?, &vec![0i64; 4 * n])?;
    root.link_hard("Steps/CellOffsets", "Steps/ConnectivityIdOffsets")
}

fn cells(root: &Group, entries: &[Entry]) -> hdf5::Result<()> {
    let most = entries.iter().map(Entry::particles).max().unwrap_or(0);
    let n = entries.len();
    for kind in TOPOLOGIES {
        let group = root.create_group(kind)?;
        let vertices = kind == "Vertices";
        if vertices {
            root.link_hard(name::COUNTS, "Vertices/NumberOfCells")?;
        } else {
            fill(&group.new_dataset::<i64>().shape(n).create("NumberOfCells")?, &vec![0i64; n])?;
        }
        group.link_hard("NumberOfCells", "NumberOfConnectivityIds")?;
        // n + 1 offsets for n cells, also where n = 0: without them VTK loses the point data silently
        for (name, rows) in [(CONNECTIVITY, most), (CELL_OFFSETS, most + 1)] {
            let dataset = group.new_dataset::<i64>();
            if vertices && most > 0 {
                let source = relative(CELLS);
                dataset
                    .virtual_map(source, name, rows, Selection::All, rows, Selection::All)
                    .shape(rows)
                    .create(name)?;
            } else {
                let rows = rows - most;
                fill(&dataset.shape(rows).create(name)?, &vec![0i64; rows])?;
            }
        }
    }
    Ok(())
}

/// Datasets that are made of those of the frames.
struct Composed<'a>(&'a [Entry]);

impl Composed<'_> {
    /// A dataset of all frames, and what is shown where a file is missing.
    fn dataset<T: H5Type + Into<OwnedDynValue>>(
        &self,
        group: &Group,
        name: &str,
        source: &str,
        width: usize,
        missing: T,
    ) -> hdf5::Result<Dataset> {
        let all: usize = self.0.iter().map(Entry::particles).sum();
        let shape = |rows: usize| if width == 1 { vec![rows] } else { vec![rows, width] };
        let mut builder = group.new_dataset_builder();
        let mut row = 0;
        for (id, part) in self.0.iter().flat_map(Entry::files).filter(|(_, part)| part.particles > 0) {
            let (rows, n) = (row..row + part.particles, part.particles);
            row = rows.end;
            let there = if width == 1 { Selection::try_new(rows)? } else { Selection::try_new((rows, ..))? };
            let file = relative(&id.name());
            builder = builder.virtual_map(file, source, shape(n), Selection::All, shape(all), there);
        }
        builder.fill_value(missing).empty::<T>().shape(shape(all)).create(name)
    }
}

/// Writes all of a dataset, also where that is nothing.
fn fill<T: H5Type>(dataset: &Dataset, values: &[T]) -> hdf5::Result<()> {
    if values.is_empty() { Ok(()) } else { dataset.write_raw(values) }
}

fn room(columns: &Columns, entries: &[Entry]) -> usize {
    SLACK + PART * (columns.fields.len() + 16) * entries.iter().map(|entry| entry.parts.len()).sum::<usize>()
}
