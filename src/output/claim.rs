//! One run, one folder: who writes there has its lock, the file `run.lock` with who that is.
//!
//! A process that was killed leaves its lock behind; whoever comes next on this machine sees that it is gone. Of a process
//! on another machine, or in another container, nobody here can tell: then a person decides.
use super::create::create;
use super::error::{Error, Result, io};
use engine::exec::ranks::launch;
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// The file that says who writes in a folder.
pub const LOCK: &str = "run.lock";
/// How often, and how long at most, one waits for others that look at the lock in this moment.
const LOOK: Duration = Duration::from_millis(5);
const LOOKS: usize = 400;

/// A folder that is this process's, until this is dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    text: String,
}

/// Who has a lock.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Holder {
    pid: u32,
    /// When it started, in clock ticks after the boot: a later process may have the same number.
    started: Option<u64>,
    /// Which boot of the machine.
    boot: String,
    /// Name and identity of the machine.
    host: String,
    machine: String,
    /// Where its number counts: containers have numbers of their own.
    namespace: String,
    command: String,
}

/// What can be said of a holder from here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Alive,
    Gone,
    Unknown,
}

impl Claim {
    /// Takes a folder that exists.
    ///
    /// # Errors
    /// If another process has it, which it names with what to do; or if the folder cannot be written.
    pub fn take(folder: &Path) -> Result<Self> {
        // of several that find a dead one's lock, one removes it
        let _turn = turn(folder);
        let path = folder.join(LOCK);
        let me = Holder::here();
        let text = serde_json::to_string_pretty(&me).unwrap_or_default() + "\n";
        if fs::metadata(&path).is_ok_and(|found| !found.is_file()) {
            return Err(refusal(folder, &path, None, &me));
        }
        for _ in 0..LOOKS {
            match fs::read_to_string(&path) {
                Ok(found) => {
                    let holder: Option<Holder> = serde_json::from_str(&found).ok();
                    // asked once: it may end while this is told
                    let holder = holder.map(|holder| (holder.state(&me), holder));
                    if !matches!(holder, Some((State::Gone, _))) {
                        return Err(refusal(folder, &path, holder, &me));
                    }
                    super::create::remove(&path)?;
                }
                Err(error) if error.kind() == ErrorKind::NotFound => {
                    if place(&path, &text, &me)? {
                        return Ok(Self { path, text });
                    }
                }
                Err(error) => return Err(io("read", &path)(error)),
            }
        }
        Err(refusal(folder, &path, None, &me))
    }

    /// Looks whether the folder is still this process's. A lock that somebody has removed is put back, if the folder is
    /// `untouched`: another run may have come and gone since.
    ///
    /// # Errors
    /// If another process has it now, or has had it.
    pub fn hold(&self, untouched: impl FnOnce() -> bool) -> Result<()> {
        let found = match fs::read_to_string(&self.path) {
            Err(error) if error.kind() == ErrorKind::NotFound && untouched() => {
                match place(&self.path, &self.text, &Holder::here())? {
                    true => return Ok(()),
                    false => fs::read_to_string(&self.path),
                }
            }
            found => found,
        };
        match found {
            Ok(text) if text == self.text => Ok(()),
            // what cannot be read now may be this process's all the same
            Err(error) if error.kind() != ErrorKind::NotFound => Ok(()),
            found => Err(lost(&self.path, serde_json::from_str(&found.unwrap_or_default()).ok())),
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        // somebody may have removed it by hand, and another run taken the folder
        if fs::read_to_string(&self.path).is_ok_and(|text| text == self.text) {
            // a lock that stays is a dead process's
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Puts a lock there at once with all that it says; false: another one was first.
fn place(path: &Path, text: &str, me: &Holder) -> Result<bool> {
    let aside = path.with_added_extension(format!("{}-{}", me.pid, me.started.unwrap_or(0)));
    let written = create(&aside)?.write_all(text.as_bytes()).map_err(io("write", &aside));
    if written.is_err() {
        super::create::remove(&aside)?;
    }
    written?;
    let linked = fs::hard_link(&aside, path);
    super::create::remove(&aside)?;
    match linked {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(false),
        // a file system without hard links
        Err(_) => match File::create_new(path) {
            Ok(mut file) => file.write_all(text.as_bytes()).map(|()| true).map_err(io("write", path)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(false),
            Err(error) => Err(io("create", path)(error)),
        },
    }
}

/// A lock of the folder itself among processes of this machine, for as long as it takes to look; without one where the file
/// system has none.
fn turn(folder: &Path) -> Option<File> {
    let folder = File::open(folder).ok()?;
    for _ in 0..LOOKS {
        match folder.try_lock() {
            Ok(()) => return Some(folder),
            Err(fs::TryLockError::WouldBlock) => std::thread::sleep(LOOK),
            Err(fs::TryLockError::Error(_)) => return None,
        }
    }
    None
}

impl Holder {
    /// This process.
    fn here() -> Self {
        let word = |path: &str| fs::read_to_string(path).unwrap_or_default().trim().to_owned();
        let pid = std::process::id();
        let namespace = fs::read_link("/proc/self/ns/pid").unwrap_or_default();
        let words: Vec<_> = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
        Self {
            pid,
            started: started(pid),
            boot: word("/proc/sys/kernel/random/boot_id"),
            host: launch::host(),
            machine: word("/etc/machine-id"),
            namespace: namespace.to_string_lossy().into_owned(),
            command: words.join(" "),
        }
    }

    /// Whether this one still runs, as `me` can see it.
    fn state(&self, me: &Self) -> State {
        let same_host = (&self.host, &self.machine) == (&me.host, &me.machine);
        if !same_host || me.boot.is_empty() {
            return State::Unknown;
        }
        if self.boot != me.boot {
            return State::Gone;
        }
        if self.namespace != me.namespace {
            return State::Unknown;
        }
        if self.started.is_some() && started(self.pid) == self.started { State::Alive } else { State::Gone }
    }
}

/// When a process started, in clock ticks after the boot (proc_pid_stat(5), field 22); `None`: there is none, or it has ended.
fn started(pid: u32) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    let (_, rest) = stat.rsplit_once(')')?;
    let mut fields = rest.split_whitespace();
    let ended = fields.next().is_none_or(|state| matches!(state, "Z" | "X"));
    if ended { None } else { fields.nth(18)?.parse().ok() }
}

fn lost(path: &Path, holder: Option<Holder>) -> Error {
    let who = holder.map_or_else(
        || "another run has had the folder since, or it was moved away".into(),
        |it| format!("process {} on {} ({}) has the folder now", it.pid, plain(&it.host), plain(&it.command)),
    );
    let problem = format!(
        "it was removed, and {who}: this run writes nothing more there. What it had written until then may be \
         gone; run it again, with another --out"
    );
    Error::Content { path: path.into(), problem }
}

/// What others have written, for a terminal.
fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn refusal(folder: &Path, path: &Path, holder: Option<(State, Holder)>, me: &Holder) -> Error {
    let shown = holder.map(|(state, it)| (state, it.pid, plain(&it.host), plain(&it.command)));
    let since = fs::metadata(path).and_then(|found| found.modified()).ok();
    let age = since.and_then(|then| SystemTime::now().duration_since(then).ok());
    let age = age.map_or_else(String::new, |age| format!(", since {} s", age.as_secs()));
    let remedy = "choose another folder with --out";
    let problem = match &shown {
        Some((State::Alive, pid, _, command)) => {
            format!(
                "another run is writing there: process {pid} ({command}){age}; {remedy}, or wait until it ends"
            )
        }
        Some((_, pid, host, command)) => format!(
            "another run may be writing there: process {pid} on {host} ({command}){age}, and nobody can tell from {} whether \
             it still runs; {remedy}, or, if it does not, remove {}",
            me.host,
            path.display()
        ),
        None => format!(
            "another run may be writing there: its lock {} cannot be read; {remedy}, or, if no run is there, remove it",
            path.display()
        ),
    };
    Error::Content { path: folder.into(), problem }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> tempfile::TempDir {
        tempfile::tempdir().expect("a folder")
    }

    fn leave(folder: &Path, holder: &Holder) {
        let text = serde_json::to_string(holder).expect("a lock");
        fs::write(folder.join(LOCK), text).expect("a lock is written");
    }

    #[test]
    fn a_folder_is_taken_once_and_given_back() {
        let folder = folder();
        let claim = Claim::take(folder.path()).expect("it is free");
        let refused = Claim::take(folder.path()).expect_err("it is taken").to_string();
        for fact in ["another run is writing", &std::process::id().to_string(), "--out"] {
            assert!(refused.contains(fact), "{refused}");
        }
        drop(claim);
        assert_eq!(fs::read_dir(folder.path()).expect("it is there").count(), 0, "nothing is left");
        Claim::take(folder.path()).expect("it is free again");
    }

    #[test]
    fn locks_of_the_dead_are_taken_over_and_others_are_named() {
        let me = Holder::here();
        // number 1 of this machine runs, and did not start when this says
        let dead = Holder { pid: 1, started: Some(u64::MAX), ..me.clone() };
        let rebooted = Holder { boot: "before".into(), ..me.clone() };
        let remote = Holder { host: "elsewhere".into(), ..me.clone() };
        let contained = Holder { namespace: "pid:[1]".into(), ..me.clone() };
        for (holder, state) in [
            (&dead, State::Gone),
            (&rebooted, State::Gone),
            (&remote, State::Unknown),
            (&contained, State::Unknown),
            (&me, State::Alive),
        ] {
            assert_eq!(holder.state(&me), state, "{holder:?}");
            let folder = folder();
            leave(folder.path(), holder);
            match Claim::take(folder.path()) {
                Ok(_) => assert_eq!(state, State::Gone),
                Err(error) => {
                    assert_ne!(state, State::Gone);
                    let remedy = error.to_string().contains("run.lock");
                    assert_eq!(remedy, state == State::Unknown, "{error}");
                }
            }
        }
        let folder = folder();
        fs::write(folder.path().join(LOCK), "half a l").expect("it is written");
        let refused = Claim::take(folder.path()).expect_err("nobody knows").to_string();
        assert!(refused.contains("remove it"), "{refused}");
    }

    #[test]
    fn of_many_that_find_a_dead_ones_lock_one_takes_it() {
        let me = Holder::here();
        for _ in 0..50 {
            let folder = folder();
            leave(folder.path(), &Holder { started: Some(1), ..me.clone() });
            let claims: Vec<_> = std::thread::scope(|scope| {
                let all: Vec<_> = (0..8).map(|_| scope.spawn(|| Claim::take(folder.path()).ok())).collect();
                all.into_iter().filter_map(|one| one.join().expect("it ends")).collect()
            });
            assert_eq!(claims.len(), 1);
        }
    }

    #[test]
    fn a_lock_that_was_taken_away_and_given_to_another_stays() {
        let folder = folder();
        let claim = Claim::take(folder.path()).expect("it is free");
        leave(folder.path(), &Holder { host: "elsewhere".into(), ..Holder::here() });
        let lost = claim.hold(|| true).expect_err("another has it").to_string();
        assert!(lost.contains("on elsewhere") && lost.contains("--out"), "{lost}");
        drop(claim);
        assert!(folder.path().join(LOCK).exists());
    }

    #[test]
    fn a_lock_that_was_removed_is_put_back() {
        let folder = folder();
        let claim = Claim::take(folder.path()).expect("it is free");
        claim.hold(|| false).expect("nobody took it");
        fs::remove_file(folder.path().join(LOCK)).expect("it is there");
        let lost = claim.hold(|| false).expect_err("another has come and gone").to_string();
        assert!(lost.contains("has had the folder since"), "{lost}");
        claim.hold(|| true).expect("nobody took it");
        Claim::take(folder.path()).expect_err("it is there again");
    }
}
