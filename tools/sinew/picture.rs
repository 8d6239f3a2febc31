use super::fail::Failure;
use std::path::{Path, PathBuf};
/// Draw pictures of a run
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run
    dir: PathBuf,
    /// Which frame (default: the last)
    #[arg(long)]
    frame: Option<usize>,
}
/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    draw(&args.dir, args.frame).map(|_| ())
}
pub fn draw(_folder: &Path, _frame: Option<usize>) -> Result<Vec<PathBuf>, Failure> {
    Ok(vec![])
}
