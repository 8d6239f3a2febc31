//! Datasets of particle files that grow row by row.
use super::name;
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, Group, H5Type};
use ndarray::ArrayView2;

/// Rows of a chunk of the tables with one row a frame.
const TABLE_CHUNK: usize = 64;

/// A compressed dataset of any number of rows.
pub fn column<T: H5Type>(
    group: &Group,
    path: &str,
    components: usize,
    chunk: usize,
) -> hdf5::Result<Dataset> {
    let dataset = group.new_dataset::<T>().shuffle().deflate(1);
    if components == 1 {
        dataset.chunk(chunk).shape(0..).create(path)
    } else {
        dataset.chunk((chunk, components)).shape((0.., components)).create(path)
    }
}

/// A dataset with a row a frame. It is not compressed: a chunk that is written again stays as long as it was, so that a
/// run that is killed between this and the change of its size does not spoil earlier rows.
pub fn table<T: H5Type>(group: &Group, path: &str, components: usize) -> hdf5::Result<Dataset> {
    let dataset = group.new_dataset::<T>();
    if components == 1 {
        dataset.chunk(TABLE_CHUNK).shape(0..).create(path)
    } else {
        dataset.chunk((TABLE_CHUNK, components)).shape((0.., components)).create(path)
    }
}

/// Lengthens the dataset where needed and writes rows from `start` on.
pub fn put<T: H5Type>(dataset: &Dataset, start: usize, components: usize, values: &[T]) -> hdf5::Result<()> {
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
pub fn connect(root: &Group, particles: usize) -> hdf5::Result<()> {
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
pub fn link(root: &Group, dataset: &str, alias: &str) -> hdf5::Result<()> {
    if root.link_exists(alias) { Ok(()) } else { root.link_hard(dataset, alias) }
}

pub fn unit(dataset: &Dataset, symbol: &str) -> hdf5::Result<()> {
    let symbol: VarLenUnicode =
        symbol.parse().map_err(|_| hdf5::Error::Internal("a unit holds a NUL".into()))?;
    dataset.new_attr::<VarLenUnicode>().create(name::UNIT)?.write_scalar(&symbol)
}
