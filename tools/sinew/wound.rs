use super::fail::Failure;
use std::path::{Path, PathBuf};
/// Measure the wound of a run
#[derive(clap::Args)]
pub struct Args {
    /// Folder of a run
    dir: PathBuf,
}
/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    print(&args.dir)
}
pub fn print(_folder: &Path) -> Result<(), Failure> {
    Ok(())
}
