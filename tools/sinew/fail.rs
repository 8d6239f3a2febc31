//! How a subcommand fails: what is printed, and the exit status.
use miette::Report;
use sinew::input::SceneError;
use sinew::output;
use sinew::simulation::RunError;
use std::process::ExitCode;

/// A failed subcommand.
pub enum Failure {
    /// Bad usage or a bad scene: exit status 2.
    Usage(Report),
    /// A run that failed: exit status 1.
    Run(String),
    /// A run that a signal ended in good order: what to say, and the exit status.
    Interrupted(String, u8),
}

impl Failure {
    /// Bad usage, in words.
    pub fn usage(message: impl std::fmt::Display) -> Self {
        Failure::Usage(miette::miette!("{message}"))
    }

    /// Prints the message; the exit status.
    pub fn report(self) -> ExitCode {
        match self {
            Failure::Usage(report) => {
                eprintln!("{report:?}");
                ExitCode::from(2)
            }
            Failure::Run(message) => {
                eprintln!("error: {message}");
                ExitCode::from(1)
            }
            Failure::Interrupted(message, status) => {
                eprintln!("{message}");
                ExitCode::from(status)
            }
        }
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
            | RunError::Outside { .. }
            | RunError::Checkpoint(_)
            | RunError::Pool(_) => Failure::usage(error),
            error => Failure::Run(error.to_string()),
        }
    }
}
