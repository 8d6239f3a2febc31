//! `sinew picture`: pictures of a run, and films.
use super::drawing::{Run, length, refuse_nothing};
use super::export::numbers;
use super::fail::Failure;
use super::folder::refuse_result;
use physics::parameter::Dimension;
use scene::Scene;
use sinew::input::units;
use sinew::lab::figure::Format;
use sinew::lab::picture::{self, Coloring, Cut, Palette, Request, Sight, Survey, View, view};
use std::path::PathBuf;

/// Draw particles of a run: any field, from any side, cut where you like; several frames beside one another, or a film
///
/// Without options it draws the section that tells most of the scene (of a shot that along the flight, as the paper's figure 8), and
/// of a shot the exit face (as its figure 10), to section.png and exit.png in the folder. With --field, --plane, --view, several frames
/// or --out it draws one picture. A .svg has real text, and the particles as pixels.
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run; the pictures go there, too
    dir: PathBuf,
    /// Frames, counted from 0: numbers and ranges with commas between, such as 0,5,10-20, or last (default: last; of a film all)
    #[arg(long, visible_alias = "frames", value_name = "LIST")]
    frame: Option<String>,
    /// What colors show: material, failure, speed, a field of the frames such as von_mises, or a part of one such as stress.xx; a row of
    /// panels each, if it is given several times
    #[arg(long, value_name = "NAME")]
    field: Vec<String>,
    /// A section one cell thick across an axis, through the middle of the domain or at a place: z, z=0, or "y=2 mm". With --view, what
    /// is before the plane is cut away
    #[arg(long, value_name = "AXIS[=PLACE]")]
    plane: Option<String>,
    /// From where one looks: +x, -x, +y, -y, +z, -z or corner
    #[arg(long, value_name = "SIDE", allow_hyphen_values = true)]
    view: Option<String>,
    /// A material to draw (repeatable; default: all)
    #[arg(long, value_name = "NAME")]
    material: Vec<String>,
    /// From where to where colors go, for example 0:2e5 in SI, or "0:200 kPa" (default: what is there, without a few far out)
    #[arg(long, value_name = "LOW:HIGH", allow_hyphen_values = true)]
    range: Option<String>,
    /// Colors of failure: apart (for every eye) or paper (the paper's)
    #[arg(long, value_enum, value_name = "SET", default_value_t)]
    colors: Colors,
    /// Width of the figure
    #[arg(long, value_name = "LENGTH", default_value = "160 mm")]
    width: String,
    /// Pixels an inch
    #[arg(long, value_name = "N", default_value_t = 160.0)]
    dpi: f64,
    /// The file to write, .png or .svg (default: picture.png in the folder)
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write a film: .png (an animated one, which browsers show), or .mp4 if there is ffmpeg
    #[arg(long, value_name = "FILE", conflicts_with = "out")]
    movie: Option<PathBuf>,
    /// Pictures a second of a film
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u16).range(1..=240))]
    rate: u16,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum Colors {
    #[default]
    Apart,
    Paper,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let one = args.frame.as_ref().is_none_or(|list| !list.contains([',', '-']));
    let given = [&args.plane, &args.view, &args.range].into_iter().any(Option::is_some)
        || [&args.field, &args.material].into_iter().any(|all| !all.is_empty())
        || args.out.is_some()
        || args.movie.is_some();
    let run = Run::open(&args.dir)?;
    if one && !given {
        let frame = args.frame.as_ref().map(|list| numbers(list, run.reader.frames())).transpose()?;
        for path in run.standard(frame.and_then(|all| all.first().copied()), |request| args.style(request))? {
            println!("{}", path.display());
        }
        return Ok(());
    }
    let request = args.request(&run)?;
    let written = match &args.movie {
        Some(file) => super::movie::write(
            &run,
            &request,
            &args.frames(&run, &format!("0-{}", run.reader.frames() - 1))?,
            file,
            args.rate,
        )?,
        None => {
            let file = args.out.clone().unwrap_or_else(|| args.dir.join("picture.png"));
            refuse_result(&file)?;
            let format = Format::of(&file).map_err(Failure::usage)?;
            let frames = run.frames(&args.frames(&run, "last")?)?;
            let subjects = run.subjects(&frames);
            let (mut survey, sight) = (Survey::new(&request), Sight::of(&request, &subjects));
            survey.add(&request, &sight);
            refuse_nothing(&survey, &request)?;
            let figure = picture::draw_with(&request, &survey, &sight).map_err(Failure::usage)?;
            figure.write(&file, format, request.dpi)?;
            file
        }
    };
    println!("{}", written.display());
    Ok(())
}

impl Args {
    /// The frames that are wanted; those of `usual`, if none are named.
    fn frames(&self, run: &Run, usual: &str) -> Result<Vec<usize>, Failure> {
        numbers(self.frame.as_deref().unwrap_or(usual), run.reader.frames())
    }

    fn request(&self, run: &Run) -> Result<Request, Failure> {
        let named = |name: &String| Coloring::named(name, run.reader.fields()).map_err(Failure::usage);
        let mut colorings = self.field.iter().map(named).collect::<Result<Vec<_>, _>>()?;
        if colorings.is_empty() {
            colorings.push(Coloring::of(&run.reader.frame(0)?));
        }
        let (view, cut) = self.sight(&run.scene)?;
        let material = |name: &String| {
            run.scene.materials.iter().position(|it| it.name == *name).ok_or_else(|| {
                let all: Vec<&str> = run.scene.materials.iter().map(|it| it.name.as_str()).collect();
                Failure::usage(format!("there is no material {name:?}: the scene has {}", all.join(", ")))
            })
        };
        let only = self.material.iter().map(material).collect::<Result<_, _>>()?;
        let span = match (&self.range, &colorings[..]) {
            (Some(text), [one]) => Some(range(text, &one.quantity(run.reader.fields()).unit)?),
            (Some(_), _) => {
                return Err(Failure::usage("--range is of one field: draw the others by themselves"));
            }
            (None, _) => None,
        };
        let section = Request::section(&run.scene, Coloring::Material);
        self.style(Request { view, cut, colorings, only, span, ..section })
    }

    /// From where one looks, and what is cut away.
    fn sight(&self, scene: &Scene) -> Result<(View, Cut), Failure> {
        let named = |name: &str| {
            let problem = format!("there is no side {name:?}: look from +x, -x, +y, -y, +z, -z or corner");
            View::named(name).ok_or_else(|| Failure::usage(problem))
        };
        let side = self.view.as_deref().map(named).transpose()?;
        let plane = self.plane.as_deref().map(|plane| plane_of(plane, scene)).transpose()?;
        match (side, plane) {
            (None, None) => Ok(view::section(scene)),
            (Some(side), None) => Ok((side, Cut::None)),
            (None, Some((axis, at))) => {
                Ok((view::across(axis), Cut::Slice(axis, at, 0.5 * scene.domain.cell)))
            }
            (Some(side), Some((axis, _))) if side.toward[axis].abs() < 1e-9 => Err(Failure::usage(
                "--view looks along the plane: look from a side of it, or leave --view out",
            )),
            (Some(side), Some((axis, at))) => Ok((side, Cut::Behind(axis, at))),
        }
    }

    /// The same with the size and the colors that are wanted.
    fn style(&self, request: Request) -> Result<Request, Failure> {
        let millimeters = 1e3 * length(&self.width, "--width")?;
        if !(30.0..=2000.0).contains(&millimeters) {
            return Err(Failure::usage(format!("--width {}: a figure is 30 mm to 2 m wide", self.width)));
        }
        if !(20.0..=2400.0).contains(&self.dpi) {
            return Err(Failure::usage(format!("--dpi {}: 20 to 2400 pixels an inch", self.dpi)));
        }
        let palette = match self.colors {
            Colors::Apart => Palette::Apart,
            Colors::Paper => Palette::Paper,
        };
        Ok(Request { width: millimeters, dpi: self.dpi, palette, ..request })
    }
}

/// Two numbers, in SI or with the unit of the field, of which the first may be without it.
fn range(text: &str, unit: &str) -> Result<[f64; 2], Failure> {
    let wrong = || {
        Failure::usage(format!(
            "--range {text}: write it as LOW:HIGH, LOW below HIGH, for example 0:2e5, or \"0:200 kPa\" with a unit of the field ({})",
            if unit.is_empty() { "which has none" } else { unit }
        ))
    };
    let (low, high) = text.split_once(':').ok_or_else(wrong)?;
    let dimension =
        Dimension::ALL.iter().copied().find(|it| units::accepted(*it).split(", ").next() == Some(unit));
    let number = |text: &str| {
        let plain = text.trim().parse::<f64>().ok();
        plain
            .or_else(|| dimension.and_then(|it| units::parse(text.trim(), it).ok()))
            .filter(|x| x.is_finite())
    };
    // the unit of the second number is that of both
    let after = high
        .trim()
        .find(|c: char| c.is_alphabetic() && c != 'e' && c != 'E')
        .map_or("", |at| &high.trim()[at..]);
    let first = if low.trim().parse::<f64>().is_ok() && !after.is_empty() {
        format!("{low} {after}")
    } else {
        low.into()
    };
    match (number(&first), number(high)) {
        (Some(low), Some(high)) if low < high => Ok([low, high]),
        _ => Err(wrong()),
    }
}

/// An axis, and where on it [m].
fn plane_of(text: &str, scene: &Scene) -> Result<(usize, f64), Failure> {
    let (name, at) = text.split_once('=').map_or((text, None), |(name, at)| (name, Some(at)));
    let Some(axis) = ["x", "y", "z"].iter().position(|axis| *axis == name.trim()) else {
        return Err(Failure::usage(format!(
            "--plane {text}: name an axis and a place on it, for example \"y=2 mm\""
        )));
    };
    // as in a scene, a bare number is in meters
    let meters = |at: &str| match at.trim().parse::<f64>().ok().filter(|at| at.is_finite()) {
        Some(at) => Ok(at),
        None => length(at.trim(), "--plane"),
    };
    let at = at.map(meters).transpose()?;
    Ok((axis, at.unwrap_or_else(|| view::middle(scene, axis))))
}
