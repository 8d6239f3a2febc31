//! `sinew scene-docs`: every field of a scene and of a frame, from the tables that they are read and written by.
use super::fail::Failure;

/// Print the documentation of all scene fields (docs/SCENE.md), or of the fields of particle files (docs/FIELDS.md)
#[derive(clap::Args)]
pub struct Args {
    /// Which page
    #[arg(value_enum, default_value = "scene")]
    page: Page,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Page {
    /// What a scene may say
    Scene,
    /// What frames may show
    Fields,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let page = match args.page {
        Page::Scene => sinew::input::documentation(),
        Page::Fields => sinew::input::documentation_of_fields(),
    };
    print!("{page}");
    Ok(())
}
