//! SIGINT, SIGTERM, SIGHUP and SIGUSR1 end a run in good order; the second one ends it at once.
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1, SIGXFSZ};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What the shell adds to a signal's number, to say in an exit status that it ended a program.
const BY_SIGNAL: i32 = 128;

/// Remembers the signal that came.
#[derive(Clone)]
pub struct Signals(Arc<AtomicUsize>);

impl Signals {
    /// From now on. What whoever started this process has it ignore (`nohup`, jobs in the background of a script) stays so.
    ///
    /// # Errors
    /// If the system does not allow it.
    pub fn watch() -> std::io::Result<Self> {
        let (came, second) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        let ignored = ignored();
        let heeded = |signal: &i32| ignored >> (signal - 1) & 1 == 0;
        for signal in [SIGINT, SIGTERM, SIGHUP, SIGUSR1].into_iter().filter(heeded) {
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

    /// The exit status of a run that the one which came has ended.
    pub fn exit_status(&self) -> Option<u8> {
        let signal = self.0.load(Ordering::Relaxed);
        (signal > 0).then(|| u8::try_from(BY_SIGNAL as usize + signal).unwrap_or(1))
    }
}

/// A write beyond `ulimit -f` becomes an error like that of a full disk, and does not kill the process.
pub fn let_long_files_fail() {
    // where that is not allowed, such a write kills as it always does
    let _ = flag::register(SIGXFSZ, Arc::default());
}

/// The signals that this process was started to ignore, a bit each (proc_pid_status(5)).
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0)
}
