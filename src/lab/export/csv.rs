//! Comma-separated values: `frame-000000.csv`, a row a particle, and `frames.csv` with the times.
use super::{Frames, component_names, values};
use crate::output::create::write_by;
use crate::output::error::Result;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes a file a frame, and the list of them.
pub fn write(frames: &Frames, folder: &Path, told: &mut dyn FnMut()) -> Result<PathBuf> {
    let names: Vec<String> = frames.fields.iter().flat_map(component_names).collect();
    let header: Vec<&str> =
        ["id", "material", "x", "y", "z"].into_iter().chain(names.iter().map(String::as_str)).collect();
    let list = folder.join("frames.csv");
    let mut times = String::from("frame,time_s,step,file\n");
    for &number in &frames.numbers {
        let (frame, name) = (frames.frame(number)?, format!("frame-{number:06}.csv"));
        write_by(&folder.join(&name), |file| {
            writeln!(file, "{}", header.join(","))?;
            for (row, [x, y, z]) in frame.positions.iter().enumerate() {
                write!(file, "{},{},{x:?},{y:?},{z:?}", frame.identities[row], frame.materials[row])?;
                values(&frame, row).try_for_each(|value| write!(file, ",{value:?}"))?;
                writeln!(file)?;
            }
            Ok(())
        })?;
        times += &format!("{number},{},{},{name}\n", frame.time, frame.step);
        told();
    }
    write_by(&list, |file| file.write_all(times.as_bytes()))?;
    Ok(list)
}
