//! The `sinew` command: one file a subcommand.
mod args;
mod bench;
mod check;
mod compare;
mod fail;
mod graph;
mod picture;
mod ping;
mod plot;
mod progress;
mod ranks;
mod restart;
mod run;
mod scale;
mod scene_docs;
mod signals;
mod wound;

use clap::{Parser, Subcommand};
use engine::exec::ranks::launch::Launch;
use std::io::IsTerminal;
use std::process::ExitCode;

/// Coupled solids by the material point method: tissue that fails, metal that yields, rigid tools.
///
/// Exit status: 0 success, 1 a run that failed, 2 bad usage or a bad scene, 128 + n a run
/// that signal n ended.
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
    Compare(compare::Args),
    Bench(bench::Args),
    Scale(scale::Args),
    Ping(ping::Args),
    SceneDocs(scene_docs::Args),
}

/// Exit status of a program whose output nobody reads any more (128 + SIGPIPE).
const BROKEN_PIPE: i32 = 141;

/// `sinew ... | head` ends when `head` has enough, without a word.
fn end_quietly_on_a_broken_pipe() {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let message = panic.payload_as_str().unwrap_or_default();
        if message.starts_with("failed printing to stdout") && message.contains("Broken pipe") {
            std::process::exit(BROKEN_PIPE);
        }
        report(panic);
    }));
}

fn main() -> ExitCode {
    end_quietly_on_a_broken_pipe();
    let filter = tracing_subscriber::EnvFilter::from_env("SINEW_LOG");
    let spans = tracing_subscriber::fmt::format::FmtSpan::CLOSE;
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_span_events(spans)
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .init();
    let command = match Cli::try_parse() {
        Ok(cli) => cli.command,
        // as one of several ranks, the first alone talks
        Err(_) if Launch::of_this_process().rank > 0 => return ExitCode::SUCCESS,
        Err(error) => error.exit(),
    };
    if Launch::of_this_process().rank > 0 && !matches!(command, Command::Run(_) | Command::Ping(_)) {
        return ExitCode::SUCCESS;
    }
    let result = match command {
        Command::Run(args) => run::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Graph(args) => graph::run(&args),
        Command::Wound(args) => wound::run(&args),
        Command::Picture(args) => picture::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Scale(args) => scale::run(&args),
        Command::Ping(args) => ping::run(&args),
        Command::SceneDocs(args) => scene_docs::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
