//! `sinew plot`: columns of a run's history as a picture.
use super::fail::Failure;
use super::folder::refuse_result;
use super::picture::length;
use sinew::lab::figure::axis::Quantity;
use sinew::lab::figure::{Figure, Format};
use sinew::lab::overview;
use sinew::lab::plot::{Line, NARROWEST, Plot};
use sinew::output::history::Table;
use sinew::output::{create::write_whole, io};
use std::path::{Path, PathBuf};

/// Plot columns of a run's history over each other: energies in time, forces over displacements
///
/// Without columns it plots energies in time, and the forces of drives and tools over their displacements.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run
    dir: PathBuf,
    /// The column along the axis
    #[arg(long, value_name = "COLUMN", default_value = "time_s")]
    x: String,
    /// A column to draw (repeatable)
    #[arg(long, value_name = "COLUMN")]
    y: Vec<String>,
    /// Draw minus this column (repeatable): what a grip gives is not what it takes
    #[arg(long, value_name = "COLUMN")]
    minus: Vec<String>,
    /// Which axes are logarithmic: x, y or xy
    #[arg(long, value_name = "AXES", value_parser = ["x", "y", "xy"])]
    log: Option<String>,
    /// Print the names of all columns, and draw nothing
    #[arg(long)]
    list: bool,
    /// Width of the figure
    #[arg(long, value_name = "LENGTH", default_value = "120 mm")]
    width: String,
    /// Pixels an inch of a .png
    #[arg(long, value_name = "N", default_value_t = 200.0)]
    dpi: f64,
    /// The file to write, .svg or .png (default: plot.svg in the folder)
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let table = Table::read(&args.dir.join("history.csv"))?;
    if args.list {
        table.header.iter().for_each(|name| println!("{name}"));
        return Ok(());
    }
    let title = title(&args.dir);
    let plots = match args.y.is_empty() && args.minus.is_empty() {
        true => overview::plots(&table, &title),
        false => vec![args.chosen(&table, title)?],
    };
    let width = 1e3 * length(&args.width, "--width")?;
    if !(NARROWEST..=2000.0).contains(&width) {
        return Err(Failure::usage(format!("--width {}: a plot is {NARROWEST} mm to 2 m wide", args.width)));
    }
    let figure = Figure::stack(plots.iter().map(|plot| plot.draw(width)).collect());
    let out = args.out.clone().unwrap_or_else(|| args.dir.join("plot.svg"));
    refuse_result(&out)?;
    // a file that the user names may be a pipe, which has no ending
    let format = match args.out.as_deref().and_then(Path::extension) {
        Some(_) => Format::of(&out).map_err(Failure::usage)?,
        None => Format::Svg,
    };
    let bytes = figure.encode(&out, format, args.dpi)?;
    let written = match &args.out {
        Some(out) => std::fs::write(out, bytes).map_err(io("write", out)),
        None => write_whole(&out, &bytes),
    };
    written?;
    println!("{}", out.display());
    Ok(())
}

/// What stands above: the title of the scene, or the name of the folder.
fn title(folder: &Path) -> String {
    let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let scene = super::wound::scene_of(folder).ok();
    scene.map(|scene| scene.title).filter(|title| !title.is_empty()).unwrap_or(name)
}

impl Args {
    /// The columns that are named.
    fn chosen(&self, table: &Table, title: String) -> Result<Plot, Failure> {
        let column = |name: &str| {
            let numbers = table.column(name).ok_or_else(|| {
                Failure::usage(format!(
                    "the history has no column {name:?}: `sinew plot {} --list` prints their names",
                    self.dir.display()
                ))
            })?;
            match numbers.iter().any(|x| x.is_finite()) {
                true => Ok(numbers),
                false => Err(Failure::usage(format!("the column {name:?} of the history has no numbers"))),
            }
        };
        let x = column(&self.x)?;
        let line = |(name, sign): (&String, f64)| -> Result<Line, Failure> {
            let points = x.iter().zip(column(name)?).map(|(x, y)| [*x, sign * y]);
            let words = Quantity::of_column(name).words;
            let name = if sign < 0.0 { format!("−{words}") } else { words };
            Ok(Line { name, points: points.collect() })
        };
        let all = self.y.iter().map(|name| (name, 1.0)).chain(self.minus.iter().map(|name| (name, -1.0)));
        let lines = all.map(line).collect::<Result<Vec<_>, _>>()?;
        // lines of one unit share it
        let mut units: Vec<String> =
            self.y.iter().chain(&self.minus).map(|name| Quantity::of_column(name).unit).collect();
        units.dedup();
        let unit = if let [unit] = &units[..] { unit.clone() } else { String::new() };
        let words = match (&lines[..], unit.as_str()) {
            ([line], _) => line.name.clone(),
            (_, "N") => "force".to_owned(),
            (_, "J") => "energy".to_owned(),
            _ => String::new(),
        };
        let log = ["x", "y"].map(|axis| self.log.as_ref().is_some_and(|axes| axes.contains(axis)));
        let axes = [Quantity::of_column(&self.x), Quantity { words, unit }];
        Ok(Plot { title, axes, log, marks: false, lines })
    }
}
