//! SIGINT, SIGTERM and SIGUSR1 end a run in good order; the second one ends it at once.
use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What the shell adds to a signal's number, to say in an exit status that it ended a program.
const BY_SIGNAL: i32 = 128;

/// Remembers the signal that came.
pub struct Signals(Arc<AtomicUsize>);

impl Signals {
    /// From now on.
    ///
    /// # Errors
    /// If the system does not allow it.
    pub fn watch() -> std::io::Result<Self> {
        let (came, second) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        for signal in [SIGINT, SIGTERM, SIGUSR1] {
            flag::register_conditional_shutdown(signal, BY_SIGNAL + signal, Arc::clone(&second))?;
            flag::register(signal, Arc::clone(&second))?;
            flag::register_usize(signal, Arc::clone(&came), signal as usize)?;
        }
        Ok(Self(came))
    }

    /// Whether one came.
    pub fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed) > 0
    }

    /// The exit status of a run that one ended. If it reached another rank alone, it counts as SIGTERM.
    pub fn exit_status(&self) -> u8 {
        let signal = match self.0.load(Ordering::Relaxed) {
            0 => SIGTERM as usize,
            signal => signal,
        };
        u8::try_from(BY_SIGNAL as usize + signal).unwrap_or(1)
    }
}
