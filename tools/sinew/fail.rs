//! How a subcommand fails: what is printed, and the exit status.
use miette::Report;
use sinew::exec::ranks::launch::Launch;
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
    /// A failure of this rank alone: exit status 1.
    Local(String),
    /// A failure that another rank tells: the exit status.
    Elsewhere(u8),
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
            Failure::Usage(_) => 2,
            Failure::Run(_) | Failure::Local(_) => 1,
            Failure::Interrupted(_, status) | Failure::Elsewhere(status) => *status,
        }
    }

    /// What there is to say; nothing, where another rank says it.
    pub fn message(&self) -> String {
        match self {
            Failure::Usage(report) => format!("{report:?}"),
            Failure::Run(message) | Failure::Local(message) => format!("error: {message}"),
            Failure::Interrupted(message, _) => message.clone(),
            Failure::Elsewhere(_) => String::new(),
        }
    }

    /// Prints the message; the exit status. What all ranks know, the first alone says.
    pub fn report(self) -> ExitCode {
        let rank = Launch::of_this_process().rank;
        match (&self, rank) {
            (Failure::Elsewhere(_), _) => {}
            (_, 0) => eprintln!("{}", self.message()),
            (Failure::Local(_), _) => eprintln!("on rank {rank}: {}", self.message()),
            _ => {}
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
            | RunError::Outside { .. }
            | RunError::Checkpoint(_) => Failure::usage(error),
            RunError::Pool(_) | RunError::Network(_) => Failure::Local(error.to_string()),
            error => Failure::Run(error.to_string()),
        }
    }
}
