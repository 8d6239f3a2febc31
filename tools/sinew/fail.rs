//! How a subcommand fails: what is printed, and the exit status.
use super::ranks::named;
use super::say::tell;
use engine::exec::ranks::launch::Launch;
use miette::Report;
use sinew::input::SceneError;
use sinew::output;
use sinew::simulation::RunError;
use std::process::ExitCode;

/// A failed subcommand.
pub enum Failure {
    /// Bad usage or a bad scene: exit status 2.
    Usage(Report),
    /// A folder that another run has: exit status 2.
    Taken(String),
    /// A run that failed: exit status 1.
    Run(String),
    /// A failure of this rank alone: exit status 1.
    Local(String),
    /// A failure that this rank has told: the exit status.
    Told(u8),
    /// A failure that another rank tells.
    Elsewhere,
    /// A run that a signal ended in good order: what to say, and the exit status.
    Interrupted(String, u8),
}

impl Failure {
    /// Bad usage, in words.
    pub fn usage(message: impl std::fmt::Display) -> Self {
        Failure::Usage(miette::miette!("{message}"))
    }

    /// The exit status.
    pub fn status(&self) -> u8 {
        match self {
            Failure::Usage(_) | Failure::Taken(_) => 2,
            Failure::Run(_) | Failure::Local(_) | Failure::Elsewhere => 1,
            Failure::Interrupted(_, status) | Failure::Told(status) => *status,
        }
    }

    /// What there is to say; nothing, where it is said already or another rank says it.
    pub fn message(&self) -> String {
        match self {
            Failure::Usage(report) => format!("{report:?}"),
            Failure::Run(message) | Failure::Local(message) | Failure::Taken(message) => {
                format!("error: {message}")
            }
            Failure::Interrupted(message, _) => message.clone(),
            Failure::Told(_) | Failure::Elsewhere => String::new(),
        }
    }

    /// Prints the message; the exit status. What all ranks know, the first alone says. The others end as if nothing had
    /// happened: a launcher that sees a bad status kills the rest, and nobody would hear the message.
    pub fn report(self) -> ExitCode {
        let rank = Launch::of_this_process().rank;
        match (&self, rank) {
            (Failure::Told(_), _) => {}
            (Failure::Local(_), 1..) => tell!("on {}: {}", named(rank), self.message()),
            (Failure::Elsewhere, _) | (_, 1..) => return ExitCode::SUCCESS,
            _ => tell!("{}", self.message()),
        }
        ExitCode::from(self.status())
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Failure::Usage(Report::new(error))
    }
}

impl From<output::Error> for Failure {
    fn from(error: output::Error) -> Self {
        Failure::Run(error.to_string())
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Patches(_)
            | RunError::Resolution { .. }
            | RunError::Memory { .. }
            | RunError::TwoDrives { .. }
            | RunError::TwoForces { .. }
            | RunError::Checkpoint(_) => Failure::usage(error),
            RunError::Pool(_) | RunError::Network(_) => Failure::Local(error.to_string()),
            error => Failure::Run(error.to_string()),
        }
    }
}
