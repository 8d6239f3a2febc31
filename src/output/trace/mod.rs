//! `trace.json`: what each rank and worker did and when, in the Trace Event Format that Perfetto and `chrome://tracing`
//! open (Google, "Trace Event Format"). A process is a rank, a thread a worker; times are microseconds since the
//! recorders began.
mod file;
pub mod measured;
mod reader;
mod writer;

pub use file::{Line, Trace};
pub use reader::read;
pub use writer::write;
