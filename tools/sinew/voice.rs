//! How a run talks: to a person, more or less, or to a program.
use super::say::say;
use clap::ValueEnum;
use serde_json::Value;

/// Who listens, and how much is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Voice {
    /// Nothing before the end.
    Quiet,
    /// Progress now and then.
    Plain,
    /// Progress often, all of where the time went, and what tools, faces and contacts gave.
    Verbose,
    /// One JSON object a line on standard output, and nothing else there.
    Json,
}

/// In which form a run says how far it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Log {
    /// Words for people
    #[default]
    Text,
    /// One JSON object a line on standard output: event is begin, progress, warning, picture or end
    Json,
}

/// What the command line says of it.
#[derive(Clone, Copy, clap::Args)]
pub struct Loudness {
    /// No progress on the screen
    #[arg(long, short, conflicts_with_all = ["verbose", "log"])]
    pub quiet: bool,
    /// More progress, where all of the time went, and what faces, tools, drives, forces and contacts gave
    #[arg(long, short, conflicts_with = "log")]
    pub verbose: bool,
    /// The form of progress, warnings and the end
    #[arg(long, value_enum, value_name = "FORM", default_value_t)]
    pub log: Log,
}

impl Loudness {
    /// How the run talks.
    pub fn voice(self) -> Voice {
        match self {
            Self { log: Log::Json, .. } => Voice::Json,
            Self { quiet: true, .. } => Voice::Quiet,
            Self { verbose: true, .. } => Voice::Verbose,
            _ => Voice::Plain,
        }
    }
}

/// Says that something happened: a JSON object on a line.
pub fn event(name: &str, mut about: Value) {
    let mut line = serde_json::Map::from_iter([("event".to_owned(), name.into())]);
    line.append(about.as_object_mut().unwrap_or(&mut serde_json::Map::new()));
    say!("{}", Value::Object(line));
}
