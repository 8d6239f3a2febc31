//! The `sinew` command: one file a subcommand.
mod args;
mod bench;
mod check;
mod compare;
#[cfg(test)]
mod documented;
mod drawing;
mod ending;
mod export;
mod fail;
mod folder;
mod graph;
mod greet;
mod movie;
mod picture;
mod ping;
mod plot;
mod progress;
mod ranks;
mod restart;
mod run;
mod say;
mod scale;
mod scene_docs;
mod shell;
mod signals;
mod stop;
mod trial;
mod voice;
mod wound;

use clap::{Parser, Subcommand};
use ranks::Crew;
use std::io::IsTerminal;
use std::process::ExitCode;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Layer, fmt};

/// Coupled solids by the material point method: tissue that fails, metal that yields, rigid tools.
///
/// Exit status: 0 success, 1 a run that failed, 2 bad usage or a bad scene, 124 a run whose time
/// (--wall) was over, 128 + n a run that signal n ended.
#[derive(Parser)]
#[command(name = "sinew", version, propagate_version = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(args::RunArgs),
    Check(check::Args),
    Graph(graph::Args),
    Wound(wound::Args),
    Picture(picture::Args),
    Plot(plot::Args),
    Export(export::Args),
    Compare(compare::Args),
    Bench(bench::Args),
    Scale(scale::Args),
    Ping(ping::Args),
    SceneDocs(scene_docs::Args),
    Completions(shell::Completions),
    Man(shell::Manual),
}

/// What the environment variable `SINEW_LOG` wants to see, for example `engine=debug`; else errors alone.
fn logged() -> Targets {
    let errors = Targets::new().with_default(LevelFilter::ERROR);
    let wanted = std::env::var("SINEW_LOG").unwrap_or_default();
    let parsed = if wanted.is_empty() { Ok(errors.clone()) } else { wanted.parse() };
    parsed.unwrap_or_else(|error| {
        eprintln!("SINEW_LOG={wanted} is passed over: {error}; it takes levels, or targets with levels, as engine=debug");
        errors
    })
}

fn main() -> ExitCode {
    say::end_where_nobody_reads();
    signals::let_long_files_fail();
    let log = fmt::layer()
        .with_span_events(fmt::format::FmtSpan::CLOSE)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .log_internal_errors(false);
    tracing_subscriber::registry().with(log.with_filter(logged())).init();
    // whatever they were started as: one of several that goes its own way leaves the others waiting
    let crew = match Crew::meet() {
        Ok(crew) => crew,
        Err(failure) => return failure.report(),
    };
    let first = crew.network.rank() == 0;
    let command = match Cli::try_parse() {
        Ok(cli) => cli.command,
        // as one of several ranks, the first alone talks
        Err(_) if !first => return ExitCode::SUCCESS,
        Err(error) => error.exit(),
    };
    if !first && !matches!(command, Command::Run(_) | Command::Ping(_)) {
        return ExitCode::SUCCESS;
    }
    let result = match command {
        Command::Run(args) => run::run(&args, crew),
        Command::Check(args) => check::run(&args),
        Command::Graph(args) => graph::run(&args),
        Command::Wound(args) => wound::run(&args),
        Command::Picture(args) => picture::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Scale(args) => scale::run(&args),
        Command::Ping(args) => ping::run(&args, crew),
        Command::SceneDocs(args) => scene_docs::run(&args),
        Command::Completions(args) => shell::completions(&args),
        Command::Man(args) => shell::manual(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
