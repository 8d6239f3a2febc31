//! Words of a run to the screen. They are best effort: a reader that has gone, a full disk and a closed descriptor end no run.
use std::fmt::Arguments;
use std::io::Write;

/// A line to the standard output.
macro_rules! say {
    ($($words:tt)*) => { $crate::say::line(std::io::stdout(), format_args!($($words)*)) };
}

/// A line to the standard error.
macro_rules! tell {
    ($($words:tt)*) => { $crate::say::line(std::io::stderr(), format_args!($($words)*)) };
}

pub(crate) use {say, tell};

/// Writes a line, if somebody takes it.
pub fn line(mut out: impl Write, words: Arguments) {
    let _ = writeln!(out, "{words}").and_then(|()| out.flush());
}

/// How the other subcommands end if their output cannot be written: without a word where a reader has enough, as in
/// `sinew check | head`, else with what is wrong.
pub fn end_where_nobody_reads() {
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let message = panic.payload_as_str().unwrap_or_default();
        let Some(problem) = message.strip_prefix("failed printing to stdout: ") else { return report(panic) };
        if problem.contains("Broken pipe") {
            std::process::exit(BROKEN_PIPE);
        }
        tell!("error: cannot write to the standard output: {problem}");
        std::process::exit(1);
    }));
}

/// Exit status of a program whose output nobody reads any more (128 + SIGPIPE).
const BROKEN_PIPE: i32 = 141;
