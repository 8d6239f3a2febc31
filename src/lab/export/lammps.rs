//! A LAMMPS dump: `particles.dump`, all frames in one file of text (<https://docs.lammps.org/dump.html>).
use super::{Frames, Table, component_names};
use crate::output::create::write_by;
use crate::output::error::Result;
use crate::output::frame::Field;
use std::io::{Error, Write};
use std::path::{Path, PathBuf};

/// Writes the file.
pub fn write(frames: &Frames, folder: &Path, told: &mut dyn FnMut(usize)) -> Result<Vec<PathBuf>> {
    let path = folder.join("particles.dump");
    let names: Vec<String> = frames.fields.iter().flat_map(column_names).collect();
    let mut failed = None;
    let written = write_by(&path, |file| {
        // said once: OVITO takes what follows a second time for the end
        writeln!(file, "ITEM: UNITS\nsi")?;
        for &number in &frames.numbers {
            match frames.table(number) {
                Ok(table) => put(file, frames, &table, &names)?,
                Err(error) => {
                    failed = Some(error);
                    return Err(Error::other("a frame cannot be read"));
                }
            }
            told(number);
        }
        Ok(())
    });
    failed.map_or(written, Err)?;
    Ok(vec![path])
}

/// What LAMMPS calls a velocity, so that who reads the file knows it for one.
fn column_names(field: &Field) -> Vec<String> {
    match field.name.as_str() {
        "velocity" => ["vx", "vy", "vz"].map(String::from).into(),
        _ => component_names(field),
    }
}

fn put(file: &mut impl Write, frames: &Frames, table: &Table, names: &[String]) -> std::io::Result<()> {
    let (frame, [lower, upper]) = (&table.frame, frames.corners());
    writeln!(file, "ITEM: TIME\n{}\nITEM: TIMESTEP\n{}", frame.time, frame.step)?;
    writeln!(file, "ITEM: NUMBER OF ATOMS\n{}\nITEM: BOX BOUNDS ff ff ff", frame.positions.len())?;
    (0..3).try_for_each(|a| writeln!(file, "{} {}", lower[a], upper[a]))?;
    writeln!(
        file,
        "ITEM: ATOMS id type x y z{}",
        names.iter().map(|name| format!(" {name}")).collect::<String>()
    )?;
    for (row, [x, y, z]) in frame.positions.iter().enumerate() {
        write!(file, "{} {} {x:?} {y:?} {z:?}", frame.identities[row], frame.materials[row])?;
        table.row(row).try_for_each(|value| write!(file, " {value:?}"))?;
        writeln!(file)?;
    }
    Ok(())
}
