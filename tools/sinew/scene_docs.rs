//! `sinew scene-docs`: every field of a scene, from the tables that scenes are read by.
use super::fail::Failure;

/// Print the documentation of all scene fields (docs/SCENE.md)
#[derive(clap::Args)]
pub struct Args {}

/// Runs the subcommand.
pub fn run(_args: &Args) -> Result<(), Failure> {
    print!("{}", sinew::input::documentation());
    Ok(())
}
