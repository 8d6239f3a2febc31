//! A LAMMPS dump: `particles.dump`, all frames in one file of text (<https://docs.lammps.org/dump.html>).
use super::{Frames, component_names, values};
use crate::output::create::write_aside;
use crate::output::error::{Result, io};
use crate::output::frame::Field;
use crate::output::snapshot::Snapshot;
use scene::{Scene, sampling};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes the file.
pub fn write(frames: &Frames, folder: &Path, told: &mut dyn FnMut()) -> Result<PathBuf> {
    let path = folder.join("particles.dump");
    let names: Vec<String> = frames.fields.iter().flat_map(column_names).collect();
    write_aside(&path, |file| {
        let mut out = BufWriter::new(file);
        // said once: OVITO takes what follows a second time for the end
        writeln!(out, "ITEM: UNITS\nsi").map_err(io("write", &path))?;
        for &number in &frames.numbers {
            let frame = frames.frame(number)?;
            put(&mut out, frames.scene, &frame, &names).map_err(io("write", &path))?;
            told();
        }
        out.flush().map_err(io("write", &path))
    })?;
    Ok(path)
}

/// What LAMMPS calls a velocity, so that who reads the file knows it for one.
fn column_names(field: &Field) -> Vec<String> {
    match field.name.as_str() {
        "velocity" => ["vx", "vy", "vz"].map(String::from).into(),
        _ => component_names(field),
    }
}

fn put(file: &mut impl Write, scene: &Scene, frame: &Snapshot, names: &[String]) -> std::io::Result<()> {
    let (lower, upper) = sampling::inside(&scene.domain);
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
        values(frame, row).try_for_each(|value| write!(file, " {value:?}"))?;
        writeln!(file)?;
    }
    Ok(())
}
