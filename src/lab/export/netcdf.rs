//! NetCDF-3 by the conventions of AMBER: `particles.nc`, all frames in one file
//! (<https://ambermd.org/netcdf/nctraj.xhtml>), in SI and with a column for every field. A cell would mean that it repeats:
//! there is none.
use super::Frames;
use crate::output::create::{create, remove};
use crate::output::draft;
use crate::output::error::{Error, Result, io};
use crate::output::frame::Field;
use netcdf3::{DataSet, FileWriter, InvalidDataSet, Version, WriteError};
use std::path::{Path, PathBuf};

/// Writes the file.
pub fn write(frames: &Frames, folder: &Path, told: &mut dyn FnMut(usize)) -> Result<Vec<PathBuf>> {
    let path = folder.join("particles.nc");
    let aside = draft::aside(&path);
    let written = put(frames, &path, &aside, told)
        .and_then(|()| std::fs::rename(&aside, &path).map_err(io("write", &path)));
    if written.is_err() {
        // best effort: the error that matters is the one returned
        let _ = remove(&aside);
    }
    written.map(|()| vec![path])
}

fn put(frames: &Frames, path: &Path, aside: &Path, told: &mut dyn FnMut(usize)) -> Result<()> {
    let wrong = |problem: String| Error::Content { path: path.into(), problem };
    let mut tables = frames.numbers.iter().map(|&number| frames.table(number)).peekable();
    let first = match tables.next() {
        Some(first) => first?,
        None => return Err(wrong("there are no frames to write".into())),
    };
    let n = first.frame.positions.len();
    let counts = frames.numbers.iter().map(|&number| (number, frames.reader.particles(number)));
    if let Some((number, count)) = counts.into_iter().find(|&(_, count)| count != n || count == 0) {
        return Err(wrong(format!(
            "frame {number} has {count} particles, the first one {n}: this format has as many in all frames, and some. Choose \
             others with --frames, or --format vtp or lammps"
        )));
    }
    let described = |error: InvalidDataSet| wrong(format!("NetCDF cannot hold this: {error}"));
    let data = describe(frames, n).map_err(described)?;
    let failed = |error: WriteError| match error {
        WriteError::IOErrorKind(kind) => io("write", path)(kind.into()),
        other => wrong(format!("NetCDF cannot hold this: {other:?}")),
    };
    let mut file = FileWriter::open_seek_write("particles.nc", Box::new(create(aside)?)).map_err(failed)?;
    file.set_def(&data, Version::Offset64Bit, 0).map_err(failed)?;
    file.write_var_u8("spatial", b"xyz").map_err(failed)?;
    for (k, table) in std::iter::once(Ok(first)).chain(tables).enumerate() {
        let table = table?;
        let frame = &table.frame;
        let numbers: Vec<i32> = frame.identities.iter().map(|id| *id as i32).collect();
        let kinds: Vec<i32> = frame.materials.iter().map(|&m| m.into()).collect();
        let mut all = || {
            file.write_record_f64("time", k, &[frame.time])?;
            file.write_record_i32("id", k, &numbers)?;
            file.write_record_i32("type", k, &kinds)?;
            file.write_record_f32("coordinates", k, frame.positions.as_flattened())?;
            frame.columns.iter().try_for_each(|(field, values)| file.write_record_f32(name(field), k, values))
        };
        all().map_err(failed)?;
        told(table.number);
    }
    file.close().map_err(failed)
}

/// What AMBER calls a velocity, so that who reads the file knows it for one.
fn name(field: &Field) -> &str {
    if field.name == "velocity" { "velocities" } else { &field.name }
}

/// Dimensions, variables and their units.
fn describe(frames: &Frames, particles: usize) -> std::result::Result<DataSet, InvalidDataSet> {
    let mut data = DataSet::new();
    data.set_unlimited_dim("frame", frames.numbers.len())?;
    for (name, size) in [("atom", particles), ("spatial", 3), ("Voigt", 6), ("tensor", 9)] {
        data.add_fixed_dim(name, size)?;
    }
    data.add_global_attr_string("Conventions", "AMBER")?;
    data.add_global_attr_string("ConventionVersion", "1.0")?;
    data.add_global_attr_string("program", "Sinew")?;
    data.add_global_attr_string("programVersion", env!("CARGO_PKG_VERSION"))?;
    data.add_global_attr_string("title", &frames.scene.title)?;
    data.add_global_attr_string("materials", frames.materials().collect::<Vec<_>>().join(", "))?;
    data.add_var_u8("spatial", &["spatial"])?;
    data.add_var_f64("time", &["frame"])?;
    data.add_var_attr_string("time", "units", "second")?;
    data.add_var_i32("id", &["frame", "atom"])?;
    data.add_var_i32("type", &["frame", "atom"])?;
    data.add_var_f32("coordinates", &["frame", "atom", "spatial"])?;
    data.add_var_attr_string("coordinates", "units", "meter")?;
    for field in &frames.fields {
        let shape: &[&str] = match field.components {
            1 => &["frame", "atom"],
            3 => &["frame", "atom", "spatial"],
            6 => &["frame", "atom", "Voigt"],
            _ => &["frame", "atom", "tensor"],
        };
        data.add_var_f32(name(field), shape)?;
        data.add_var_attr_string(name(field), "units", &field.unit)?;
        data.add_var_attr_string(name(field), "long_name", &field.meaning)?;
    }
    Ok(data)
}
