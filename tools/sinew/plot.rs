//! `sinew plot`: columns of a run's history as a picture.
use super::fail::Failure;
use super::folder::refuse_result;
use sinew::lab::plot::{Line, Plot};
use sinew::output::history::Table;
use sinew::output::{create::write_whole, io};
use std::path::PathBuf;

/// Plot columns of a run's history over each other, as SVG: energies in time, forces over displacements
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run
    dir: PathBuf,
    /// The column along the axis
    #[arg(long, value_name = "COLUMN", default_value = "time_s")]
    x: String,
    /// A column to draw (repeatable); without any, the names of all columns are printed
    #[arg(long, value_name = "COLUMN")]
    y: Vec<String>,
    /// Draw minus this column (repeatable): what a grip gives is not what it takes
    #[arg(long, value_name = "COLUMN")]
    minus: Vec<String>,
    /// The file to write (default: plot.svg in the folder)
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let table = Table::read(&args.dir.join("history.csv"))?;
    if args.y.is_empty() && args.minus.is_empty() {
        table.header.iter().for_each(|name| println!("{name}"));
        return Ok(());
    }
    let column = |name: &str| {
        let numbers = table.column(name).ok_or_else(|| {
            Failure::usage(format!(
                "the history has no column {name:?}: `sinew plot {}` prints their names",
                args.dir.display()
            ))
        })?;
        let some = numbers.iter().any(|x| x.is_finite());
        if some {
            Ok(numbers)
        } else {
            Err(Failure::usage(format!("the column {name:?} of the history has no numbers")))
        }
    };
    let x = column(&args.x)?;
    let line = |(name, sign): (&String, f64)| -> Result<Line, Failure> {
        let points = x.iter().zip(column(name)?).map(|(x, y)| [*x, sign * y]);
        let name = if sign < 0.0 { format!("−{name}") } else { name.clone() };
        Ok(Line { name, points: points.collect() })
    };
    let all = args.y.iter().map(|name| (name, 1.0)).chain(args.minus.iter().map(|name| (name, -1.0)));
    let lines = all.map(line).collect::<Result<Vec<_>, _>>()?;
    let up = if let [line] = &lines[..] { line.name.clone() } else { String::new() };
    let title = args.dir.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let plot = Plot { title, axes: [args.x.clone(), up], log: [false, false], marks: false, lines };
    let out = args.out.clone().unwrap_or_else(|| args.dir.join("plot.svg"));
    // a file that the user names may be a pipe
    refuse_result(&out)?;
    let written = match &args.out {
        Some(out) => std::fs::write(out, plot.to_svg()).map_err(io("write", out)),
        None => write_whole(&out, plot.to_svg().as_bytes()),
    };
    written?;
    println!("{}", out.display());
    Ok(())
}
