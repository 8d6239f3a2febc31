//! VTK PolyData in XML: `frame-000000.vtp` with all arrays appended as bytes, and `particles.pvd` with the times
//! (<https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>).
use super::Frames;
use crate::output::create::write_by;
use crate::output::error::Result;
use crate::output::frame::part_names;
use crate::output::snapshot::Snapshot;
use bytemuck::{Pod, cast_slice};
use std::fmt::Write as _;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes a file a frame, and the collection of them.
pub fn write(frames: &Frames, folder: &Path, told: &mut dyn FnMut()) -> Result<PathBuf> {
    let collection = folder.join("particles.pvd");
    let mut list = String::new();
    for &number in &frames.numbers {
        let (frame, name) = (frames.frame(number)?, format!("frame-{number:06}.vtp"));
        let file = poly_data(frames, &frame);
        write_by(&folder.join(&name), |out| file.write(out))?;
        list += &format!("<DataSet timestep=\"{}\" file=\"{name}\"/>\n", frame.time);
        told();
    }
    write_by(&collection, |out| {
        writeln!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">"
        )?;
        writeln!(out, "<Collection>\n{list}</Collection>\n</VTKFile>")
    })?;
    Ok(collection)
}

/// What is between `<PolyData>` and its end, and the bytes that it refers to.
#[derive(Default)]
struct File {
    xml: String,
    bytes: Vec<u8>,
}

fn poly_data(frames: &Frames, frame: &Snapshot) -> File {
    let (n, mut file) = (frame.positions.len(), File::default());
    file.xml += "<FieldData>\n";
    file.array("Float64", "TimeValue", 1, &[frame.time], " NumberOfTuples=\"1\"");
    file.names(frames.materials());
    file.xml += "</FieldData>\n";
    let _ = writeln!(
        file.xml,
        "<Piece NumberOfPoints=\"{n}\" NumberOfVerts=\"{n}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">"
    );
    file.xml += "<Points>\n";
    file.array("Float32", "Points", 3, frame.positions.as_flattened(), "");
    file.xml += "</Points>\n<Verts>\n";
    file.array("Int64", "connectivity", 1, &(0..n as i64).collect::<Vec<_>>(), "");
    file.array("Int64", "offsets", 1, &(1..=n as i64).collect::<Vec<_>>(), "");
    file.xml += "</Verts>\n<PointData>\n";
    file.array("UInt64", "id", 1, &frame.identities, "");
    file.array("UInt16", "material", 1, &frame.materials, "");
    for (field, values) in &frame.columns {
        // the others VTK names by itself
        let parts = if field.components == 6 { part_names(6) } else { &[] }.iter().enumerate();
        let parts = parts.map(|(i, part)| format!(" ComponentName{i}=\"{}\"", part.to_uppercase()));
        file.array("Float32", &field.name, field.components, values, &parts.collect::<String>());
    }
    file.xml += "</PointData>\n</Piece>\n";
    file
}

impl File {
    /// An array whose bytes are appended: their number as eight bytes, then they.
    fn array<T: Pod>(&mut self, kind: &str, name: &str, components: usize, values: &[T], more: &str) {
        let offset = self.bytes.len();
        let _ = writeln!(
            self.xml,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"{more} format=\"appended\" \
             offset=\"{offset}\"/>"
        );
        let bytes: &[u8] = cast_slice(values);
        self.bytes.extend((bytes.len() as u64).to_le_bytes());
        self.bytes.extend(bytes);
    }

    /// The names of the materials: letters as numbers, a zero after each name.
    fn names<'a>(&mut self, names: impl Iterator<Item = &'a str>) {
        let (mut letters, mut count) = (String::new(), 0);
        for name in names {
            count += 1;
            name.bytes().chain([0]).for_each(|byte| letters += &format!("{byte} "));
        }
        let _ = writeln!(
            self.xml,
            "<Array type=\"String\" Name=\"material_names\" NumberOfTuples=\"{count}\" format=\"ascii\">{letters}</Array>"
        );
    }

    fn write(&self, out: &mut impl Write) -> std::io::Result<()> {
        // bytes are those of this machine
        let order = if cfg!(target_endian = "little") { "LittleEndian" } else { "BigEndian" };
        writeln!(
            out,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{order}\" header_type=\"UInt64\">"
        )?;
        write!(out, "<PolyData>\n{}</PolyData>\n<AppendedData encoding=\"raw\">\n_", self.xml)?;
        out.write_all(&self.bytes)?;
        writeln!(out, "\n</AppendedData>\n</VTKFile>")
    }
}
