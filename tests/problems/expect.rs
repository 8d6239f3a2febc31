//! What an `expect.toml` says, and how its numbers are measured.
use assert_cmd::Command;
use serde::Deserialize;
use std::path::Path;

/// The file: what must hold, number by number.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Expectations {
    metric: Vec<Metric>,
}

/// A number of a run, and what it must be.
#[derive(Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Metric {
    /// What it is, with its unit in brackets.
    pub name: String,
    /// Overrides of the scene (`--set`).
    #[serde(default)]
    pub set: Vec<String>,
    /// A number of `summary.json`; of several the sum, of those with a minus before them the opposite. Keys are separated by dots,
    /// or by slashes where names have dots.
    #[serde(default)]
    path: Names,
    /// A column of `history.csv`, or several, in the same way.
    #[serde(default)]
    history: Names,
    /// Columns by whose sum that of `history` is divided.
    #[serde(default)]
    over: Names,
    /// Where in the history.
    #[serde(default)]
    at: At,
    /// A number of `sinew wound --json`.
    #[serde(default)]
    wound: Names,
    /// A number that is known, such as the momentum at the start: it is taken away.
    #[serde(default)]
    less: f64,
    /// The number of this second run, with these overrides, is added.
    pub plus: Option<Vec<String>>,
    /// The number of this second run is taken away.
    pub minus: Option<Vec<String>>,
    pub reference: f64,
    pub tolerance: f64,
    /// Where the reference comes from, and what the tolerance is.
    pub source: String,
    /// Why it is not met, if that is known: the test demands then that it is not.
    pub open: Option<String>,
}

/// One name or several.
#[derive(Clone, Default, Deserialize)]
#[serde(untagged)]
enum Names {
    #[default]
    None,
    One(String),
    Several(Vec<String>),
}

impl Names {
    fn all(&self) -> &[String] {
        match self {
            Self::None => &[],
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        }
    }

    /// The sum of what they are called, with its signs.
    fn sum(&self, mut value: impl FnMut(&str) -> f64) -> f64 {
        let signed = |name: &String| match name.strip_prefix('-') {
            Some(name) => (-1.0, name.to_owned()),
            None => (1.0, name.clone()),
        };
        self.all().iter().map(signed).map(|(sign, name)| sign * value(&name)).sum()
    }
}

/// Where in the history a number is read.
#[derive(Clone, Default, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
enum At {
    /// In the last row.
    #[default]
    End,
    /// The largest of all rows.
    Largest,
    /// The largest without its sign, between two times.
    LargestSize([f64; 2]),
    /// Where a column first passes a value: linear between the rows.
    Passes { column: String, value: f64 },
    /// At a time of the summary: linear between the rows.
    Event(String),
}

/// What is left of a run.
pub struct Run {
    summary: serde_json::Value,
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
    wound: serde_json::Value,
}

/// The metrics of a problem; none if it has no `expect.toml`.
pub fn metrics(problem: &str) -> Vec<Metric> {
    let file = Path::new("problems").join(problem).join("expect.toml");
    let Ok(text) = std::fs::read_to_string(&file) else { return Vec::new() };
    let all: Expectations =
        toml::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    all.metric
}

/// Runs a scene with overrides.
pub fn run(problem: &str, set: &[String], wound: bool) -> Run {
    let out = tempfile::tempdir().expect("a temporary folder");
    let mut command = Command::cargo_bin("sinew").expect("the command is built");
    command.args(["run", &format!("problems/{problem}"), "--quiet", "--set"]);
    command.arg(format!("output.frames={}", u8::from(wound))).arg("--out").arg(out.path());
    set.iter().for_each(|pair| {
        command.args(["--set", pair]);
    });
    command.assert().success();
    let read = |name: &str| std::fs::read_to_string(out.path().join(name)).expect("a file of the run");
    let history = read("history.csv");
    let mut lines = history.lines();
    let columns = lines.next().expect("a header").split(',').map(str::to_owned).collect();
    let numbers = |line: &str| line.split(',').map(|x| x.parse().unwrap_or(f64::NAN)).collect();
    let rows = lines.map(numbers).collect();
    let wound = if wound {
        let mut command = Command::cargo_bin("sinew").expect("the command is built");
        let told = command.arg("wound").arg(out.path()).arg("--json").assert().success();
        serde_json::from_slice(&told.get_output().stdout).expect("valid JSON")
    } else {
        serde_json::Value::Null
    };
    Run { summary: serde_json::from_str(&read("summary.json")).expect("valid JSON"), columns, rows, wound }
}

impl Metric {
    pub fn of_wound(&self) -> bool {
        !self.wound.all().is_empty()
    }

    /// Its value in a run.
    pub fn value(&self, run: &Run) -> f64 {
        self.found(run) - self.less
    }

    fn found(&self, run: &Run) -> f64 {
        if self.of_wound() {
            return self.wound.sum(|path| number(&run.wound, path));
        }
        if self.history.all().is_empty() {
            return self.path.sum(|path| number(&run.summary, path));
        }
        let of = |names: &Names, row: &[f64]| names.sum(|column| row[run.column(column)]);
        let value = |row: &[f64]| {
            let over = if self.over.all().is_empty() { 1.0 } else { of(&self.over, row) };
            of(&self.history, row) / over
        };
        let most = |rows: &mut dyn Iterator<Item = f64>| rows.fold(f64::NEG_INFINITY, f64::max);
        match &self.at {
            At::End => value(run.rows.last().expect("a row")),
            At::Largest => most(&mut run.rows.iter().map(|row| value(row))),
            At::LargestSize([from, until]) => {
                let time = run.column("time_s");
                let within = |row: &&Vec<f64>| (*from..=*until).contains(&row[time]);
                most(&mut run.rows.iter().filter(within).map(|row| value(row).abs()))
            }
            At::Passes { column, value: wanted } => value(&run.between(column, *wanted)),
            At::Event(path) => value(&run.between("time_s", number(&run.summary, path))),
        }
    }

    pub fn meets(&self, value: f64) -> bool {
        (value - self.reference).abs() <= self.tolerance
    }
}

impl Run {
    fn column(&self, name: &str) -> usize {
        let found = self.columns.iter().position(|column| column == name);
        found.unwrap_or_else(|| panic!("no column {name} in the history"))
    }

    /// The row, between two, where a column passes a value for the first time.
    fn between(&self, column: &str, value: f64) -> Vec<f64> {
        let c = self.column(column);
        let pair = self
            .rows
            .windows(2)
            .find(|pair| pair[0][c] <= value && value <= pair[1][c] && pair[0][c] < pair[1][c]);
        let Some([before, after]) = pair else { panic!("{column} does not pass {value}") };
        let part = (value - before[c]) / (after[c] - before[c]);
        before.iter().zip(after).map(|(a, b)| a + part * (b - a)).collect()
    }
}

/// A number in JSON: keys and indices with dots between, or slashes.
fn number(json: &serde_json::Value, path: &str) -> f64 {
    let step = |value: &serde_json::Value, key: &str| match key.parse::<usize>() {
        Ok(index) => value.get(index).cloned(),
        Err(_) => value.get(key).cloned(),
    };
    // names of reactions have dots: with slashes between keys, dots are part of them
    let between = if path.contains('/') { '/' } else { '.' };
    let found = path.split(between).try_fold(json.clone(), |value, key| step(&value, key));
    found.and_then(|value| value.as_f64()).unwrap_or_else(|| panic!("no number {path} in the results"))
}
