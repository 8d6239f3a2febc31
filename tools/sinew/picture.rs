//! `sinew picture`: PNG pictures of a run.
use super::fail::Failure;
use super::wound::{Shown, load};
use sinew::lab::picture::{Coloring, exit_face, section};
use sinew::output::frame::Frame;
use std::path::{Path, PathBuf};

/// Draw the section through the tract (as the paper's figure 8) and the exit face (as its figure 10)
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run; the pictures go there too
    dir: PathBuf,
    /// Which frame, counted from 0 (default: the last)
    #[arg(long, value_name = "K")]
    frame: Option<usize>,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    for path in draw(&args.dir, args.frame)? {
        println!("{}", path.display());
    }
    Ok(())
}

/// Draws a frame (default: the last) of the run in `folder`; the files written.
pub fn draw(folder: &Path, frame: Option<usize>) -> Result<Vec<PathBuf>, Failure> {
    let Shown { scene, first, frame: shown } = load(folder, frame)?;
    let first: Option<&dyn Frame> = first.as_ref().map(|first| first as &dyn Frame);
    let name = |what: &str| match frame {
        Some(k) => folder.join(format!("{what}-{k:04}.png")),
        None => folder.join(format!("{what}.png")),
    };
    let coloring = Coloring::of(&shown);
    let mut written = vec![name("section")];
    section(&shown, &scene, coloring).write(&written[0])?;
    if let Some(canvas) = exit_face(&shown, first, &scene, coloring) {
        written.push(name("exit"));
        canvas.write(&written[1])?;
    }
    Ok(written)
}
