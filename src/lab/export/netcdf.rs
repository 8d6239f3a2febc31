//! NetCDF-3 by the conventions of AMBER: `particles.nc`, all frames in one file
//! (<https://ambermd.org/netcdf/nctraj.xhtml>), in SI and with a column for every field. A cell would mean that it repeats:
//! there is none.
use super::Frames;
use crate::output::create::write_aside;
use crate::output::error::{Error, Result, io};
use crate::output::frame::Field;
use crate::output::snapshot::Snapshot;
use netcdf3::{DataSet, FileWriter, InvalidDataSet, Version, WriteError};
use std::fmt::Display;
use std::path::{Path, PathBuf};

/// Writes the file.
pub fn write(frames: &Frames, folder: &Path, told: &mut dyn FnMut()) -> Result<PathBuf> {
    let path = folder.join("particles.nc");
    let data = describe(frames, particles(frames, &path)?).map_err(|error| foreign(&path, error))?;
    write_aside(&path, |file| {
        let failed = |error: WriteError| match error {
            WriteError::IOErrorKind(kind) => io("write", &path)(kind.into()),
            other => foreign(&path, format!("{other:?}")),
        };
        let file = file.try_clone().map_err(io("write", &path))?;
        let mut file = FileWriter::open_seek_write("particles.nc", Box::new(file)).map_err(failed)?;
        file.set_def(&data, Version::Offset64Bit, 0).map_err(failed)?;
        file.write_var_u8("spatial", b"xyz").map_err(failed)?;
        for (k, &number) in frames.numbers.iter().enumerate() {
            record(&mut file, k, &frames.frame(number)?).map_err(failed)?;
            told();
        }
        file.close().map_err(failed)
    })?;
    Ok(path)
}

fn foreign(path: &Path, what: impl Display) -> Error {
    Error::Content { path: path.into(), problem: format!("NetCDF cannot hold this: {what}") }
}

/// The number of particles, which all frames must have.
fn particles(frames: &Frames, path: &Path) -> Result<usize> {
    let wrong = |problem: String| Err(Error::Content { path: path.into(), problem });
    let mut counts = frames.numbers.iter().map(|&number| (number, frames.reader.particles(number)));
    let Some((_, n)) = counts.clone().next() else { return wrong("there are no frames to write".into()) };
    match counts.find(|&(_, count)| count != n || count == 0) {
        None => Ok(n),
        Some((number, count)) => wrong(format!(
            "frame {number} has {count} particles, the first one {n}: this format has as many in all frames, and some. Choose \
             others with --frames, or --format vtp or lammps"
        )),
    }
}

fn record(file: &mut FileWriter, k: usize, frame: &Snapshot) -> std::result::Result<(), WriteError> {
    let numbers: Vec<i32> = frame.identities.iter().map(|id| *id as i32).collect();
    let kinds: Vec<i32> = frame.materials.iter().map(|&m| m.into()).collect();
    file.write_record_f64("time", k, &[frame.time])?;
    file.write_record_i32("id", k, &numbers)?;
    file.write_record_i32("type", k, &kinds)?;
    file.write_record_f32("coordinates", k, frame.positions.as_flattened())?;
    frame.columns.iter().try_for_each(|(field, values)| file.write_record_f32(name(field), k, values))
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
