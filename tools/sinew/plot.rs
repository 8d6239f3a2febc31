//! `sinew plot`: columns of a run's history as a picture.
use super::drawing::length;
use super::fail::Failure;
use super::folder::refuse_result;
use sinew::lab::figure::axis::Quantity;
use sinew::lab::figure::{Figure, Format};
use sinew::lab::overview;
use sinew::lab::plot::{Line, NARROWEST, Plot};
use sinew::output::history::Table;
use sinew::output::{create::write_whole, io};
use std::collections::BTreeSet;
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
    /// A column to draw (repeatable), with what the legend says of it, if that is not its name: drive.right.force_x_n="pulling grip"
    #[arg(long, value_name = "COLUMN[=WORDS]")]
    y: Vec<String>,
    /// Draw minus this column (repeatable): what a grip gives is not what it takes
    #[arg(long, value_name = "COLUMN[=WORDS]")]
    minus: Vec<String>,
    /// Which axes are logarithmic: x, y or xy; with columns
    #[arg(long, value_name = "AXES", value_parser = ["x", "y", "xy"])]
    log: Option<String>,
    /// What stands above (default: the title of the scene; "": nothing); with columns
    #[arg(long, value_name = "WORDS")]
    title: Option<String>,
    /// What stands along the axis, before the unit; with columns
    #[arg(long, value_name = "WORDS")]
    x_label: Option<String>,
    /// What stands beside it, before the unit; with columns
    #[arg(long, value_name = "WORDS")]
    y_label: Option<String>,
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
    if table.rows.is_empty() {
        return Err(Failure::usage(format!("{} has no rows yet", args.dir.join("history.csv").display())));
    }
    let title = title(&args.dir);
    let of_columns =
        [args.log.is_some(), args.title.is_some(), args.x_label.is_some(), args.y_label.is_some()];
    let plots = match args.y.is_empty() && args.minus.is_empty() {
        true if of_columns.contains(&true) => {
            let message =
                "--log, --title, --x-label and --y-label are of columns: name some with --y or --minus";
            return Err(Failure::usage(message));
        }
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
        let along = Quantity::of_column(&self.x);
        let all = self.y.iter().map(|name| (name, 1.0)).chain(self.minus.iter().map(|name| (name, -1.0)));
        let all: Vec<(&str, Option<&str>, f64)> = all
            .map(|(name, sign)| match name.split_once('=') {
                Some((name, words)) => (name, Some(words), sign),
                None => (name.as_str(), None, sign),
            })
            .collect();
        // lines of one unit share it
        let units: BTreeSet<String> = all.iter().map(|(name, ..)| Quantity::of_column(name).unit).collect();
        let shared =
            if units.len() == 1 { units.into_iter().next().unwrap_or_default() } else { String::new() };
        let line = |(name, words, sign): &(&str, Option<&str>, f64)| -> Result<Line, Failure> {
            let points: Vec<[f64; 2]> = x.iter().zip(column(name)?).map(|(x, y)| [*x, sign * y]).collect();
            let own = Quantity::of_column(name);
            let unit = if own.unit == shared || own.unit.is_empty() {
                String::new()
            } else {
                format!(" [{}]", own.unit)
            };
            let minus = if *sign < 0.0 { "−" } else { "" };
            let name = words.map_or_else(|| format!("{minus}{}{unit}", own.words), str::to_owned);
            Ok(Line { name, points })
        };
        let lines = all.iter().map(line).collect::<Result<Vec<_>, _>>()?;
        let log = ["x", "y"].map(|axis| self.log.as_ref().is_some_and(|axes| axes.contains(axis)));
        let words = match (&lines[..], shared.as_str()) {
            ([line], _) => line.name.clone(),
            (_, "N") => "force".to_owned(),
            (_, "N m") => "torque".to_owned(),
            (_, "J") => "energy".to_owned(),
            (_, "m/s") => "velocity".to_owned(),
            (_, "Pa") => "stress".to_owned(),
            (_, "m") => "length".to_owned(),
            _ => String::new(),
        };
        let up = Quantity { words: self.y_label.clone().unwrap_or(words), unit: shared };
        let along = Quantity { words: self.x_label.clone().unwrap_or(along.words), ..along };
        let title = self.title.clone().unwrap_or(title);
        let plot = Plot { title, axes: [along, up], log, marks: false, lines };
        match plot.lines.iter().find(|line| plot.shown(line).next().is_none()) {
            None => Ok(plot),
            Some(line) => {
                let problem = "has no number above zero, which a logarithmic axis could show";
                Err(Failure::usage(format!("{:?} {problem}", line.name)))
            }
        }
    }
}
