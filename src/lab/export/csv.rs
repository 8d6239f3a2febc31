//! Comma-separated values: `frame-000000.csv`, a row a particle, and `frames.csv` with the times.
use super::{Frames, component_names};
use crate::output::create::write_by;
use crate::output::error::Result;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes a file a frame, and the list of them, which comes first.
pub fn write(frames: &Frames, folder: &Path, told: &mut dyn FnMut(usize)) -> Result<Vec<PathBuf>> {
    let names: Vec<String> = frames.fields.iter().flat_map(component_names).collect();
    let header: Vec<&str> =
        ["id", "material", "x", "y", "z"].into_iter().chain(names.iter().map(String::as_str)).collect();
    let list = folder.join("frames.csv");
    let (mut written, mut times) = (vec![list.clone()], String::from("frame,time_s,step,file\n"));
    for &number in &frames.numbers {
        let table = frames.table(number)?;
        let path = folder.join(format!("frame-{number:06}.csv"));
        write_by(&path, |file| {
            writeln!(file, "{}", header.join(","))?;
            for (row, [x, y, z]) in table.frame.positions.iter().enumerate() {
                write!(
                    file,
                    "{},{},{x:?},{y:?},{z:?}",
                    table.frame.identities[row], table.frame.materials[row]
                )?;
                table.row(row).try_for_each(|value| write!(file, ",{value:?}"))?;
                writeln!(file)?;
            }
            Ok(())
        })?;
        let (time, step) = (table.frame.time, table.frame.step);
        times += &format!("{number},{time},{step},frame-{number:06}.csv\n");
        told(number);
        written.push(path);
    }
    write_by(&list, |file| file.write_all(times.as_bytes()))?;
    Ok(written)
}
