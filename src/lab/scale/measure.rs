//! Measures: runs `sinew run` over patches, threads and ranks.
use super::row::{Parts, Row, compare};
use super::tally::{self, Tally};
use crate::output::summary::Summary;
use crate::simulation::layout;
use scene::{Patches, Scene};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What is measured.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The scene: a folder or a file.
    pub scene: PathBuf,
    /// What is changed in it, as for `sinew run --set`.
    pub set: Vec<String>,
    /// Patches.
    pub patches: Vec<Patches>,
    /// Threads a rank.
    pub threads: Vec<usize>,
    /// Ranks.
    pub ranks: Vec<usize>,
    /// Steps that count.
    pub steps: u64,
    /// Steps before them.
    pub warm: u64,
    /// Repetitions.
    pub repeat: usize,
    /// Whether each worker keeps its number of particles.
    pub weak: bool,
    /// What starts several ranks; `{ranks}` stands for their number.
    pub launcher: String,
    /// The program to run.
    pub program: PathBuf,
    /// Where runs leave their files.
    pub folder: PathBuf,
}

/// One combination.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Patches.
    pub patches: Patches,
    /// Threads a rank.
    pub threads: usize,
    /// Ranks.
    pub ranks: usize,
}

/// A scene with other cells: how cases get their scene.
pub type Reader<'a> = dyn Fn(&[(String, String)]) -> Result<Scene, String> + 'a;

impl Plan {
    /// All combinations, few workers first.
    pub fn cases(&self) -> Vec<Case> {
        let mut cases = Vec::new();
        for &ranks in &self.ranks {
            for &threads in &self.threads {
                cases.extend(self.patches.iter().map(|&patches| Case { patches, threads, ranks }));
            }
        }
        cases.sort_by_key(|case| (case.ranks * case.threads, case.ranks));
        cases
    }
}

/// The rows, and where the time went in the best repetition of each that could be measured.
pub type Measured = (Vec<Row>, Vec<Option<Tally>>);

/// A row that is being measured.
struct Open {
    case: Case,
    row: Row,
    overrides: Vec<(String, String)>,
    times: Vec<f64>,
    best: Option<Tally>,
}

/// Measures all combinations, in turns, so that all of them see the same neighbors on the machine. `say` hears about each
/// run.
pub fn measure(plan: &Plan, read: &Reader<'_>, say: &mut dyn FnMut(&str)) -> Measured {
    let mut all: Vec<Open> = plan.cases().iter().map(|case| Open::new(plan, case, read)).collect();
    let count = all.len();
    for repetition in 1..=plan.repeat {
        for (number, open) in all.iter_mut().enumerate().filter(|(_, open)| open.row.error.is_none()) {
            let Row { patches, threads, ranks, .. } = open.row;
            let place = format!("repetition {repetition} of {}, {}/{count}", plan.repeat, number + 1);
            say(&format!("{place}: {patches} patches, {threads} threads, {ranks} ranks"));
            if let Err(error) = open.repeat(plan) {
                say(&format!("{place}: failed: {error}"));
                (open.row.error, open.best) = (Some(error), None);
            }
        }
    }
    let (mut rows, tallies): (Vec<Row>, Vec<Option<Tally>>) =
        all.into_iter().map(|open| (open.row, open.best)).unzip();
    compare(&mut rows);
    (rows, tallies)
}

impl Open {
    fn new(plan: &Plan, case: &Case, read: &Reader<'_>) -> Self {
        let row = Row { threads: case.threads, ranks: case.ranks, ..Row::default() };
        let mut open = Self { case: *case, row, overrides: Vec::new(), times: Vec::new(), best: None };
        open.row.error = open.cut(plan, read).err();
        open
    }

    /// Cuts the scene.
    fn cut(&mut self, plan: &Plan, read: &Reader<'_>) -> Result<(), String> {
        if let Patches::Total(patches) = self.case.patches {
            self.row.patches = patches;
        }
        self.overrides = cell(plan, &self.case, read)?;
        let mut scene = read(&self.overrides)?;
        self.row.cell_m = scene.domain.cell;
        scene.run.patches = Some(self.case.patches);
        self.row.grid = layout::decompose(&scene, 1, self.case.ranks)?.0.counts;
        self.row.patches = self.row.grid.iter().product();
        Ok(())
    }

    /// One repetition.
    fn repeat(&mut self, plan: &Plan) -> Result<(), String> {
        let (summary, tally) = child(plan, &self.case, self.row.grid, &self.overrides)?;
        if summary.ranks != self.case.ranks {
            let launcher = &plan.launcher;
            return Err(format!("{launcher:?} started {} ranks: give another --launcher", summary.ranks));
        }
        let ms = 1e-6 * tally.ranks.iter().map(|rank| rank.span).fold(0.0, f64::max) / tally.steps as f64;
        if self.times.iter().all(|&other| ms < other) {
            record(&mut self.row, &summary, &tally, ms);
            self.best = Some(tally);
        }
        self.times.push(ms);
        self.times.sort_by(f64::total_cmp);
        self.row.step_ms[1] = self.times[self.times.len() / 2];
        Ok(())
    }
}

fn record(row: &mut Row, summary: &Summary, tally: &Tally, ms: f64) {
    let number = |name: &str| summary.more.get(name).and_then(serde_json::Value::as_u64).unwrap_or(0);
    row.particles = summary.particles;
    row.step_ms[0] = ms;
    let updates = number("updates") as f64 / summary.steps.max(1) as f64;
    row.updates_per_s = updates / (1e-3 * ms).max(f64::MIN_POSITIVE);
    row.parts = Parts::of(tally);
    row.peak_bytes = number("peak_bytes");
    row.state_hash.clone_from(&summary.state_hash);
    row.lost = tally.lost;
}

/// The cell that keeps the particles of each worker.
fn cell(plan: &Plan, case: &Case, read: &Reader<'_>) -> Result<Vec<(String, String)>, String> {
    let workers = case.ranks * case.threads;
    if !plan.weak || workers == 1 {
        return Ok(Vec::new());
    }
    Ok(vec![("domain.cell".to_owned(), resized(&read(&[])?, (workers as f64).cbrt()).to_string())])
}

/// The cell [m] closest to cell / factor of which a whole number fits between the faces of the domain.
pub fn resized(scene: &Scene, factor: f64) -> f64 {
    let (cells, cell) = (scene.domain.cells, scene.domain.cell);
    // the cells along the axes have a common measure, so that all of them stay whole
    let common = cells.iter().copied().fold(0, gcd).max(1) as f64;
    cell * common / (common * factor).round().max(1.0)
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Runs one child; its summary, and where its time went.
fn child(
    plan: &Plan,
    case: &Case,
    grid: [usize; 3],
    overrides: &[(String, String)],
) -> Result<(Summary, Tally), String> {
    let folder = plan.folder.join("run");
    let mut command = command(plan, case.ranks)?;
    let [x, y, z] = grid;
    // the step before the last one that the trace holds is the last one that counts
    let steps = plan.warm + plan.steps + 1;
    command.arg("run").arg(&plan.scene).args(["--quiet", "--force", "--trace", "--out"]).arg(&folder);
    command.args(["--patches", &format!("{x}x{y}x{z}"), "--threads", &case.threads.to_string()]);
    command.args(["--steps", &steps.to_string()]);
    for set in QUIET.iter().map(|set| (*set).to_owned()).chain(plan.set.iter().cloned()) {
        command.args(["--set", &set]);
    }
    for (key, value) in overrides {
        command.args(["--set", &format!("{key}={value}")]);
    }
    let output = command
        .stdin(Stdio::null())
        .output()
        .map_err(|error| format!("cannot start {}: {error}", command.get_program().to_string_lossy()))?;
    if !output.status.success() {
        return Err(words(&String::from_utf8_lossy(&output.stderr)));
    }
    let result = results(&folder, plan.warm);
    // best effort: the next run overwrites what is left
    let _ = fs::remove_dir_all(&folder);
    result
}

/// No output that takes time.
const QUIET: [&str; 3] =
    ["output.frames=0", "output.history-every=1000000000", "output.checkpoint.final=false"];

fn command(plan: &Plan, ranks: usize) -> Result<Command, String> {
    if ranks == 1 {
        return Ok(Command::new(&plan.program));
    }
    let line = plan.launcher.replace("{ranks}", &ranks.to_string());
    let mut words = line.split_whitespace();
    let program = words.next().ok_or("the launcher is empty: give --launcher \"mpirun -n {ranks}\"")?;
    let mut command = Command::new(program);
    command.args(words).arg(&plan.program);
    Ok(command)
}

fn results(folder: &Path, warm: u64) -> Result<(Summary, Tally), String> {
    let summary = Summary::read(&folder.join("summary.json")).map_err(|error| error.to_string())?;
    let tally = tally::read(&folder.join("trace.json"), warm).map_err(|error| error.to_string())?;
    Ok((summary, tally))
}

/// What a program says, in one line: from its first error on, without the words of the launcher around it.
fn words(text: &str) -> String {
    let starts = ["× ", "error: "].map(|mark| text.find(mark).map(|at| at + mark.len()));
    let said = starts.into_iter().flatten().min().map_or(text, |at| &text[at..]);
    let said = said.split("-----").find(|part| !part.trim().is_empty()).unwrap_or_default();
    let all: Vec<&str> =
        said.split(|c: char| c.is_whitespace() || c == '│').filter(|word| !word.is_empty()).collect();
    let line = all.join(" ");
    match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} …", &line[..end]),
        None if line.is_empty() => "it failed without a word".to_owned(),
        None => line,
    }
}

/// Letters of an error in a table.
const LONGEST: usize = 300;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_told_without_the_words_of_the_launcher() {
        let told = "-----\nPrimary job aborted.\n-----\n  × 2 ranks cannot\n  │ share 1 patch\n\n-----\nmpirun detected\n";
        assert_eq!(words(told), "2 ranks cannot share 1 patch");
        assert_eq!(words("-----\nNo such launcher\n-----\n"), "No such launcher");
        assert_eq!(words("  \n"), "it failed without a word");
    }

    #[test]
    fn few_workers_come_first() {
        let plan = Plan {
            scene: "scene".into(),
            set: Vec::new(),
            patches: vec![Patches::Total(1), Patches::Grid([2, 1, 2])],
            threads: vec![2, 1],
            ranks: vec![2, 1],
            steps: 1,
            warm: 0,
            repeat: 1,
            weak: false,
            launcher: "mpirun -n {ranks}".to_owned(),
            program: "sinew".into(),
            folder: "scaling".into(),
        };
        let cases: Vec<_> =
            plan.cases().iter().map(|case| (case.ranks, case.threads, case.patches)).collect();
        let (one, grid) = (Patches::Total(1), Patches::Grid([2, 1, 2]));
        assert_eq!(cases[..4], [(1, 1, one), (1, 1, grid), (1, 2, one), (1, 2, grid)]);
        assert_eq!(cases[4..], [(2, 1, one), (2, 1, grid), (2, 2, one), (2, 2, grid)]);
        let line = command(&plan, 2).expect("a launcher");
        let words: Vec<_> = line.get_args().map(|arg| arg.to_string_lossy().into_owned()).collect();
        assert_eq!(
            (line.get_program().to_str(), &words[..]),
            (Some("mpirun"), &["-n", "2", "sinew"].map(String::from)[..])
        );
    }
}
