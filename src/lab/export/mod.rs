//! Frames of a run in the formats of other programs.
mod csv;
mod lammps;
mod netcdf;
mod vtp;

use crate::output::error::{Error, Result, io};
use crate::output::frame::{Field, part_names};
use crate::output::snapshot::Snapshot;
use crate::output::vtkhdf::Reader;
use scene::Scene;
use std::path::{Path, PathBuf};

/// A format of another program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// VTK PolyData, a file a frame, and a collection with the times: ParaView of any age, PyVista.
    Vtp,
    /// NetCDF-3 by the conventions of AMBER, one file: OVITO, xarray.
    Netcdf,
    /// A LAMMPS dump, one file of text: OVITO, VMD.
    Lammps,
    /// Comma-separated values, a file a frame: everything else.
    Csv,
}

/// Which frames of a run, and what of them.
pub struct Frames<'a> {
    /// The run.
    pub scene: &'a Scene,
    /// Its frames.
    pub reader: &'a Reader,
    /// Those that are wanted, in ascending order.
    pub numbers: Vec<usize>,
    /// The fields that are wanted.
    pub fields: Vec<Field>,
}

impl Frames<'_> {
    /// Writes them into a folder. `told` hears of each frame that is done; the file to open is the answer.
    ///
    /// # Errors
    /// If a frame is damaged, the format cannot hold the frames, or a file cannot be written.
    pub fn export(&self, format: Format, folder: &Path, told: &mut dyn FnMut()) -> Result<PathBuf> {
        std::fs::create_dir_all(folder).map_err(io("create", folder))?;
        match format {
            Format::Vtp => vtp::write(self, folder, told),
            Format::Netcdf => netcdf::write(self, folder, told),
            Format::Lammps => lammps::write(self, folder, told),
            Format::Csv => csv::write(self, folder, told),
        }
    }

    /// One of the frames that are wanted, its particles in the order of their identities, and its columns in that of the fields.
    fn frame(&self, number: usize) -> Result<Snapshot> {
        let names: Vec<&str> = self.fields.iter().map(|field| field.name.as_str()).collect();
        let mut frame = self.reader.frame_with(number, &names).map_err(|error| match error {
            Error::Content { path, problem } => {
                Error::Content { path, problem: format!("{problem}. With --frames it can be left out") }
            }
            other => other,
        })?;
        frame.columns.sort_by_key(|(field, _)| names.iter().position(|name| *name == field.name));
        Ok(sorted(frame))
    }

    fn materials(&self) -> impl Iterator<Item = &str> {
        self.scene.materials.iter().map(|material| material.name.as_str())
    }
}

/// The same particles, by their identities.
fn sorted(frame: Snapshot) -> Snapshot {
    let mut order: Vec<usize> = (0..frame.identities.len()).collect();
    order.sort_unstable_by_key(|&row| frame.identities[row]);
    let columns = frame.columns.into_iter().map(|(field, values)| {
        let row = |&row: &usize| &values[row * field.components..(row + 1) * field.components];
        let values = order.iter().flat_map(row).copied().collect();
        (field, values)
    });
    Snapshot {
        identities: order.iter().map(|&row| frame.identities[row]).collect(),
        materials: order.iter().map(|&row| frame.materials[row]).collect(),
        positions: order.iter().map(|&row| frame.positions[row]).collect(),
        columns: columns.collect(),
        ..frame
    }
}

/// `velocity_x`, `stress_xx`, `mass`: a name for each number of a field.
fn component_names(field: &Field) -> Vec<String> {
    match field.components {
        1 => vec![field.name.clone()],
        many => part_names(many).iter().map(|part| format!("{}_{part}", field.name)).collect(),
    }
}

/// The values of a row, field by field.
fn values(frame: &Snapshot, row: usize) -> impl Iterator<Item = f32> {
    frame.columns.iter().flat_map(move |(field, values)| {
        values[row * field.components..(row + 1) * field.components].iter().copied()
    })
}
