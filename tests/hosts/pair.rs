//! Two hosts, `a` and `b`, on one machine: namespaces of their own for mounts, processes, names and the network, a wire
//! between them, and an sshd on each.
use crate::common::command::{ok, text};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Where Open MPI listens, and what the hosts are called.
const ADDRESSES: [(&str, &str); 2] = [("a", "10.0.0.1"), ("b", "10.0.0.2")];

/// After so long a job hangs, and timeout(1) ends it. Its status does not tell: 124, or 137 where `mpirun` does not go at once.
pub const HANGS: Duration = Duration::from_secs(40);

/// A host; nothing is left of it once it is dropped, or this process has ended.
pub struct Host {
    /// Outside of its namespaces.
    unshare: Child,
    /// Its first process, by the number that it has outside. It ends with this input.
    init: String,
    words: Option<ChildStdin>,
    said: BufReader<std::process::ChildStdout>,
}

impl Host {
    fn start(name: &str, address: &str, folder: &Path) -> Result<Self, String> {
        let mut command = Command::new("unshare");
        command.args(["-m", "-u", "-i", "-n", "-p", "--fork", "--kill-child", "--mount-proc", "sh"]);
        command.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/hosts/host.sh"));
        command.args([name, address, text(folder)]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut unshare = command.spawn().map_err(|error| format!("cannot start unshare: {error}"))?;
        let (words, said) = (unshare.stdin.take(), unshare.stdout.take().expect("it is piped"));
        let mut host = Self { unshare, init: String::new(), words, said: BufReader::new(said) };
        host.hears("up")?;
        let pid = host.unshare.id();
        let children = ok(fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")));
        host.init = children.trim().to_owned();
        Ok(host)
    }

    /// Waits for a line of its first process.
    fn hears(&mut self, wanted: &str) -> Result<(), String> {
        let mut line = String::new();
        ok(self.said.read_line(&mut line));
        if line.trim() == wanted {
            return Ok(());
        }
        drop(self.words.take());
        let mut problem = line;
        ok(self.unshare.stderr.take().expect("it is piped").read_to_string(&mut problem));
        Err(problem.trim().to_owned())
    }

    fn linked(&mut self) -> Result<(), String> {
        ok(writeln!(self.words.as_mut().expect("it listens")));
        self.hears("ready")
    }

    /// Runs a command on this host.
    pub fn command(&self, program: &str) -> Command {
        let mut command = Command::new("nsenter");
        command.args(["-t", &self.init, "-m", "-u", "-i", "-n", "-p"]);
        // another root is another working directory
        command.args(["sh", "-c", "cd \"$0\" && exec \"$@\"", env!("CARGO_MANIFEST_DIR"), program]);
        command.stdin(Stdio::null());
        command
    }

    /// Runs a command on this host, which succeeds; what it prints.
    #[track_caller]
    pub fn run(&self, words: &[&str]) -> String {
        let output = ok(self.command(words[0]).args(&words[1..]).output());
        assert!(output.status.success(), "{words:?}: {output:?}");
        String::from_utf8_lossy(&output.stdout).trim().to_owned()
    }

    /// Runs `sinew` on this host alone.
    #[track_caller]
    pub fn sinew(&self, words: &[&str]) -> Output {
        ok(self.command(text(assert_cmd::cargo::cargo_bin!("sinew"))).args(words).output())
    }

    /// How many ranks run here.
    pub fn ranks(&self) -> usize {
        let names = self.run(&["sh", "-c", "cat /proc/[0-9]*/comm 2>/dev/null || true"]);
        names.lines().filter(|name| *name == "sinew").count()
    }

    /// Kills one of the ranks here.
    pub fn kill_a_rank(&self) {
        self.run(&[
            "sh",
            "-c",
            "kill -9 $(basename $(dirname $(grep -lx sinew /proc/[0-9]*/comm | head -n 1)))",
        ]);
    }

    /// Ends the host, with all that runs on it, as a loss of power would.
    pub fn end(&self) {
        assert!(ok(Command::new("kill").args(["-9", &self.init]).status()).success());
    }

    /// Puts an empty folder over one, on this host alone.
    pub fn hide(&self, folder: &Path) {
        self.run(&["mount", "-t", "tmpfs", "none", text(folder)]);
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        drop(self.words.take());
        let _ = self.unshare.kill();
        let _ = self.unshare.wait();
    }
}

/// Both, and a folder that both see.
pub struct Pair {
    pub a: Host,
    pub b: Host,
    folder: TempDir,
    /// Keys and settings, apart from what is hidden.
    settings: TempDir,
}

impl Pair {
    /// `None`, and a word about it, where hosts cannot be had; under `CI=true` that is a failure.
    pub fn start() -> Option<Self> {
        match Self::try_start() {
            Ok(pair) => Some(pair),
            Err(reason) => {
                let reason = format!("runs over two hosts are not tested: {reason}");
                assert!(std::env::var("CI").as_deref() != Ok("true"), "{reason}");
                // past the test harness, which keeps what tests print
                let _ = writeln!(std::io::stderr(), "skipped: {reason}");
                None
            }
        }
    }

    fn try_start() -> Result<Self, String> {
        let version =
            Command::new("mpirun").arg("--version").output().map_err(|error| format!("mpirun: {error}"))?;
        if !String::from_utf8_lossy(&version.stdout).contains("Open MPI") {
            return Err("mpirun is not that of Open MPI".into());
        }
        let [folder, settings] = [(); 2].map(|()| ok(tempfile::tempdir()));
        configure(settings.path())?;
        let start = |(name, address)| Host::start(name, address, settings.path());
        let [mut a, mut b] = [start(ADDRESSES[0])?, start(ADDRESSES[1])?];
        // made in the network of `a`, so that the machine's own never has it
        let mut wire = Command::new("nsenter");
        wire.args(["-t", &a.init, "-n", "ip", "link", "add", "name", "eth0", "type", "veth"]);
        succeeds(wire.args(["peer", "name", "eth0", "netns", &b.init]))?;
        a.linked()?;
        b.linked()?;
        Ok(Self { a, b, folder, settings })
    }

    /// A path in the folder that both hosts see, unless one has hidden it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// `mpirun sinew` on host `a`, with two ranks on each host. What hangs is ended after [`HANGS`].
    pub fn mpirun(&self, words: &[&str]) -> Command {
        let mut command = self.a.command("timeout");
        command.args(["-k", "1", &HANGS.as_secs().to_string(), "mpirun"]);
        let agent = format!("ssh -F {}", text(&self.settings.path().join("ssh")));
        command.args(["--host", "a:2,b:2", "--mca", "plm_rsh_agent", &agent]);
        command.args(["--mca", "oob_tcp_if_include", "eth0", "--mca", "btl_tcp_if_include", "eth0"]);
        // a host that does not answer is given up after three seconds instead of eight minutes
        for (key, value) in [("time", "1"), ("intvl", "1"), ("probes", "2")] {
            command.args(["--mca", &format!("oob_tcp_keepalive_{key}"), value]);
        }
        command.envs([
            ("OMPI_ALLOW_RUN_AS_ROOT", "1"),
            ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"),
            ("OMPI_MCA_hwloc_base_binding_policy", "none"),
            // where nothing is left of it
            ("OMPI_MCA_orte_tmpdir_base", "/run"),
            // both hosts count the same cores
            ("OMPI_MCA_mpi_yield_when_idle", "1"),
        ]);
        command.arg(assert_cmd::cargo::cargo_bin!("sinew")).args(words);
        command
    }

    /// What a job over both hosts ends with. On a loaded machine `mpirun` has been seen to hang before its ranks said a word:
    /// what hangs is started once more, and what hangs again hangs.
    #[track_caller]
    pub fn output(&self, words: &[&str]) -> Output {
        let began = Instant::now();
        let output = ok(self.mpirun(words).output());
        if began.elapsed() < HANGS || !output.stdout.is_empty() {
            return output;
        }
        let _ = writeln!(std::io::stderr(), "mpirun hangs, once more: {words:?}");
        ok(self.mpirun(words).output())
    }
}

fn succeeds(command: &mut Command) -> Result<(), String> {
    let program = command.get_program().display().to_string();
    let output = command.output().map_err(|error| format!("cannot start {program}: {error}"))?;
    match output.status.success() {
        true => Ok(()),
        false => Err(format!("{program}: {}", String::from_utf8_lossy(&output.stderr).trim())),
    }
}

/// A key that both hosts have and accept, and the files that say so.
fn configure(folder: &Path) -> Result<(), String> {
    let [key, public] = ["key", "key.pub"].map(|name| folder.join(name).display().to_string());
    succeeds(Command::new("ssh-keygen").args(["-q", "-t", "ed25519", "-N", "", "-f", &key]))?;
    let sshd = format!(
        "HostKey {key}\nAuthorizedKeysFile {public}\nStrictModes no\nUsePAM no\nPidFile none\nPermitRootLogin prohibit-password\n"
    );
    let ssh = format!(
        "IdentityFile {key}\nIdentitiesOnly yes\nBatchMode yes\nLogLevel ERROR\nStrictHostKeyChecking no\nUserKnownHostsFile /dev/null\n"
    );
    let hosts = ADDRESSES.map(|(name, address)| format!("{address} {name}\n")).concat();
    for (name, text) in [("sshd", sshd), ("ssh", ssh), ("hosts", format!("127.0.0.1 localhost\n{hosts}"))] {
        ok(fs::write(folder.join(name), text));
    }
    Ok(())
}
