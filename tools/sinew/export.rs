//! `sinew export`: frames of a run for other programs.
use super::fail::Failure;
use super::wound::{frames_of, scene_of};
use sinew::lab::export::{Format, Frames};
use sinew::output::frame::Field;
use sinew::output::vtkhdf::Reader;
use std::io::IsTerminal;
use std::path::PathBuf;

/// Write frames of a run in the format of another program: vtp (ParaView of any age, PyVista), netcdf (OVITO, xarray), lammps
/// (OVITO, VMD), csv
///
/// netcdf has as many particles in all frames: of a run that deletes some, name frames that have the same number. Files of an earlier
/// export that are not written anew stay. Particles come in the order of their identities, numbers are in SI, a material has the number that it has in the run's own
/// files.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run
    dir: PathBuf,
    /// Which format
    #[arg(long, value_enum)]
    format: Named,
    /// Fields to write, with commas between (default: all that the frames have)
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    fields: Option<Vec<String>>,
    /// Frames to write, counted from 0: numbers and ranges with commas between, such as 0,5,10-20, or last (default: all)
    #[arg(long, value_name = "LIST")]
    frames: Option<String>,
    /// Folder to write into (default: the format's name in the folder of the run)
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Named {
    Vtp,
    Netcdf,
    Lammps,
    Csv,
}

impl Named {
    fn format(self) -> (&'static str, Format) {
        match self {
            Self::Vtp => ("vtp", Format::Vtp),
            Self::Netcdf => ("netcdf", Format::Netcdf),
            Self::Lammps => ("lammps", Format::Lammps),
            Self::Csv => ("csv", Format::Csv),
        }
    }
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (reader, scene) = (frames_of(&args.dir)?, scene_of(&args.dir)?);
    let numbers = match &args.frames {
        None => (0..reader.frames()).collect(),
        Some(text) => numbers(text, reader.frames())?,
    };
    let fields = chosen(&reader, args.fields.as_deref())?;
    let (name, format) = args.format.format();
    let folder = args.out.clone().unwrap_or_else(|| args.dir.join(name));
    let frames = Frames { scene: &scene, reader: &reader, numbers, fields };
    let (all, shows) = (frames.numbers.len(), std::io::stderr().is_terminal());
    let mut done = 0;
    let written = frames.export(format, &folder, &mut || {
        done += 1;
        if shows {
            eprint!("\r{done} of {all} frames");
        }
    });
    if shows && done > 0 {
        eprintln!();
    }
    println!("{}", written?.display());
    Ok(())
}

/// The fields that are wanted.
fn chosen(reader: &Reader, wanted: Option<&[String]>) -> Result<Vec<Field>, Failure> {
    let Some(wanted) = wanted else { return Ok(reader.fields().to_vec()) };
    let there: Vec<&str> = reader.fields().iter().map(|field| field.name.as_str()).collect();
    let one = |name: &String| {
        let found = reader.fields().iter().find(|field| field.name == name.trim());
        found.cloned().ok_or_else(|| {
            Failure::usage(format!(
                "the frames have no field {name:?}: they have {}; output.fields of a scene says what a run shows",
                there.join(", ")
            ))
        })
    };
    let mut fields: Vec<Field> = Vec::new();
    for field in wanted.iter().map(one) {
        let field = field?;
        // each once
        if fields.iter().all(|other| other.name != field.name) {
            fields.push(field);
        }
    }
    Ok(fields)
}

/// `0,5,10-20`, `last`: in ascending order, each once.
pub fn numbers(text: &str, frames: usize) -> Result<Vec<usize>, Failure> {
    let wrong = |part: &str| {
        let last = frames.saturating_sub(1);
        Failure::usage(format!(
            "frames {part}: write numbers from 0 to {last}, ranges such as 0-{last}, or last, with commas between"
        ))
    };
    let number = |text: &str| text.trim().parse().ok().filter(|&k: &usize| k < frames);
    let mut numbers = Vec::new();
    for part in text.split(',') {
        match part.split_once('-') {
            None if part.trim() == "last" && frames > 0 => numbers.push(frames - 1),
            None => numbers.push(number(part).ok_or_else(|| wrong(part))?),
            Some((from, to)) => match (number(from), number(to)) {
                (Some(from), Some(to)) if from <= to => numbers.extend(from..=to),
                _ => return Err(wrong(part)),
            },
        }
    }
    numbers.sort_unstable();
    numbers.dedup();
    Ok(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbers_and_ranges() {
        let of = |text: &str| numbers(text, 30).ok();
        assert_eq!(of("0,5,10-12"), Some(vec![0, 5, 10, 11, 12]));
        assert_eq!(of("12, 3-4,3,last"), Some(vec![3, 4, 12, 29]));
        for text in ["", "30", "5-3", "a", "-1", "1-", "0-30", "1,,2"] {
            assert_eq!(of(text), None, "{text}");
        }
        assert!(numbers("last", 0).is_err());
    }
}
