//! `sinew wound`: measures of a shot through a slab, beside the paper's.
use super::fail::Failure;
use super::say::say;
use scene::Scene;
use sinew::lab::figure::Format;
use sinew::lab::wound::{Report, Unmeasured, measure};
use sinew::output::frame::Frame;
use sinew::output::snapshot::Snapshot;
use sinew::output::vtkhdf::Reader;
use std::path::{Path, PathBuf};

/// Measure the wound that a run left: entry, exit, cavity and failed layer by depth, beside the paper's
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run
    dir: PathBuf,
    /// Which frame, counted from 0 (default: the last)
    #[arg(long, value_name = "K")]
    frame: Option<usize>,
    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,
    /// Draw diameters over the depth, too: a .svg or a .png
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// Width of the plot [mm], and pixels an inch.
const WIDTH: f64 = 120.0;
const DPI: f64 = 200.0;

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let report = report(&args.dir, args.frame)?;
    if let Some(file) = &args.plot {
        super::folder::refuse_result(file)?;
        let (format, scene) = (Format::of(file).map_err(Failure::usage)?, scene_of(&args.dir)?);
        report.plot(&scene.title).draw(WIDTH).write(file, format, DPI)?;
    }
    if args.json {
        println!("{:#}", report.json())
    } else {
        print!("{report}")
    }
    Ok(())
}

/// Prints the table of a run that has just ended.
pub fn print(folder: &Path) -> Result<(), Failure> {
    say!("\n{}", report(folder, None)?.to_string().trim_end());
    Ok(())
}

fn report(folder: &Path, frame: Option<usize>) -> Result<Report, Failure> {
    let shown = load(folder, frame)?;
    // of the first frame it is the first itself
    let first: &dyn Frame = shown.first.as_ref().unwrap_or(&shown.frame);
    measure(&shown.scene, Some(first), &shown.frame).map_err(|error| match error {
        Unmeasured::NoSection | Unmeasured::NoFailure => Failure::usage(error),
        Unmeasured::NoTarget => Failure::Run(error.to_string()),
    })
}

/// A frame of a run, with the scene and the first frame.
pub struct Shown {
    /// The scene as it was run.
    pub scene: Scene,
    /// The first frame, if it is another one.
    pub first: Option<Snapshot>,
    /// The frame.
    pub frame: Snapshot,
}

/// Fields that wound and pictures use.
const FIELDS: [&str; 3] = ["failure", "plastic_strain", "velocity"];

/// The frames of the run in `folder`.
pub fn frames_of(folder: &Path) -> Result<Reader, Failure> {
    let file = folder.join("particles.vtkhdf");
    if !file.exists() {
        return Err(Failure::usage(format!(
            "{} holds no particles.vtkhdf: name the folder of a run that wrote frames (output.frames above 0)",
            folder.display()
        )));
    }
    Ok(Reader::open(&file)?)
}

/// The scene of the run in `folder`, as it was run.
pub fn scene_of(folder: &Path) -> Result<Scene, Failure> {
    // whoever looks at a run needs no threads of its machine
    let threads = ("run.threads".to_owned(), String::new());
    Ok(sinew::input::read(&folder.join("scene.toml"), &[threads])?)
}

/// Loads frame `frame` (default: the last) of the run in `folder`.
pub fn load(folder: &Path, frame: Option<usize>) -> Result<Shown, Failure> {
    let (reader, scene) = (frames_of(folder)?, scene_of(folder)?);
    let last = reader.frames().saturating_sub(1);
    let chosen = frame.unwrap_or(last);
    if chosen > last {
        return Err(Failure::usage(format!("there is no frame {chosen}: the run has frames 0 to {last}")));
    }
    let first = (chosen > 0).then(|| reader.frame_with(0, &["failure"])).transpose()?;
    Ok(Shown { scene, first, frame: reader.frame_with(chosen, &FIELDS)? })
}
