//! A job beside the caller, on a thread of its own: one at a time, so that no more than one is ever in memory.
use super::error::{Result, io};
use std::fmt;
use std::panic::resume_unwind;
use std::path::Path;
use std::thread::{Builder, JoinHandle};

/// A job that has begun. Dropped, it is waited for: nobody writes any more when its owner is gone.
pub struct Beside<T>(State<T>);

enum State<T> {
    Thread(JoinHandle<T>),
    /// Where there may be no thread, the one that waits for it does it.
    Later(Box<dyn FnOnce() -> T>),
    Over,
}

impl<T: Send + 'static> Beside<T> {
    /// Begins a job that writes `path`; without `threads` it is done by who waits for it.
    ///
    /// # Errors
    /// If the system has no thread for it.
    pub fn begin(path: &Path, threads: bool, job: impl FnOnce() -> T + Send + 'static) -> Result<Self> {
        if !threads {
            return Ok(Self(State::Later(Box::new(job))));
        }
        let thread = Builder::new().name("output".into()).spawn(job);
        Ok(Self(State::Thread(thread.map_err(io("start a thread that writes", path))?)))
    }

    /// Whether it does not run any more.
    pub fn is_done(&self) -> bool {
        match &self.0 {
            State::Thread(thread) => thread.is_finished(),
            State::Later(_) | State::Over => true,
        }
    }

    /// Waits for its end.
    pub fn end(mut self) -> Option<T> {
        match std::mem::replace(&mut self.0, State::Over) {
            // a panic goes on where it would have been without a thread
            State::Thread(thread) => Some(thread.join().unwrap_or_else(|panic| resume_unwind(panic))),
            State::Later(job) => Some(job()),
            State::Over => None,
        }
    }
}

impl<T> Drop for Beside<T> {
    fn drop(&mut self) {
        if let State::Thread(thread) = std::mem::replace(&mut self.0, State::Over) {
            // whatever it says, nobody asks any more
            let _ = thread.join();
        }
    }
}

impl<T> fmt::Debug for Beside<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a job")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Arc, mpsc};

    #[test]
    fn a_job_runs_beside_and_is_waited_for() {
        let (go, wait) = mpsc::channel::<u32>();
        let job = Beside::begin(Path::new("file"), true, move || wait.recv()).expect("a thread");
        assert!(!job.is_done());
        go.send(7).expect("it waits");
        assert_eq!(job.end(), Some(Ok(7)));
        let ended = Arc::new(AtomicBool::new(false));
        let (flag, (go, wait)) = (ended.clone(), mpsc::channel::<()>());
        let job = Beside::begin(Path::new("file"), true, move || {
            let _ = wait.recv();
            flag.store(true, Ordering::SeqCst);
        });
        drop(go);
        drop(job.expect("a thread"));
        assert!(ended.load(Ordering::SeqCst));
        let here = std::thread::current().id();
        let job = Beside::begin(Path::new("file"), false, move || std::thread::current().id() == here);
        assert_eq!(job.expect("none is needed").end(), Some(true));
    }
}
