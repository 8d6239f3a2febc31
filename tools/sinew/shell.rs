//! `sinew completions` and `sinew man`: for shells and readers of manuals.
use super::Cli;
use super::fail::Failure;
use clap::CommandFactory;
use sinew::output::io;
use std::path::PathBuf;

/// Print the completions of a shell: for bash, sinew completions bash > ~/.local/share/bash-completion/completions/sinew
#[derive(clap::Args)]
pub struct Completions {
    /// Which shell
    shell: clap_complete::Shell,
}

/// Write manual pages: sinew man ~/.local/share/man/man1
#[derive(clap::Args)]
pub struct Manual {
    /// Folder to write into
    dir: PathBuf,
}

/// Runs `sinew completions`.
pub fn completions(args: &Completions) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "sinew", &mut script);
    print!("{}", String::from_utf8_lossy(&script));
    Ok(())
}

/// Runs `sinew man`.
pub fn manual(args: &Manual) -> Result<(), Failure> {
    std::fs::create_dir_all(&args.dir).map_err(io("create", &args.dir))?;
    clap_mangen::generate_to(Cli::command(), &args.dir).map_err(io("write pages into", &args.dir))?;
    println!("{}", args.dir.join("sinew.1").display());
    Ok(())
}
