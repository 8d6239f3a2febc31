//! `docs/VALIDATION.md`: made of `page.md` beside this file, of every `expect.toml`, and of what was measured.
use super::expect::{self, Metric};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;
use std::sync::Mutex;

/// Where tables go in the hand-written part.
const PLACE: &str = "{{problems}}";
const TEMPLATE: &str = include_str!("page.md");
const HEAD: &str = "| what | expected | tolerance | measured | deviation | of the tolerance | source of the expected number |";

/// What identifies a number: problem, overrides, name.
type Key = (String, String, String);
/// As they stand in the page.
pub type Measured = BTreeMap<Key, String>;

/// One test at a time rewrites the page.
static WRITES: Mutex<()> = Mutex::new(());

/// What was measured, by the page as it is.
pub fn measured() -> Measured {
    let mut found = Measured::new();
    let (mut problem, mut set) = (String::new(), String::new());
    for line in read().lines() {
        if let Some(title) = line.strip_prefix("### ") {
            problem = title.split([']', '[']).nth(1).unwrap_or_default().to_owned();
            set.clear();
        } else if line.starts_with("With ") {
            set = line.to_owned();
        } else if line.starts_with("| ") {
            let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
            if cells.len() == 7 {
                found.insert((problem.clone(), set.clone(), cells[0].to_owned()), cells[3].to_owned());
            }
        }
    }
    found
}

fn file() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/VALIDATION.md")
}

/// The page as it is.
pub fn read() -> String {
    std::fs::read_to_string(file()).unwrap_or_default()
}

/// Puts numbers that were measured now into the page, if that is asked for.
pub fn note(problem: &str, values: &[(Metric, f64)]) {
    if std::env::var_os("SINEW_WRITE_DOCS").is_none() {
        return;
    }
    let _alone = WRITES.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let mut all = measured();
    for (metric, value) in values {
        all.insert(key(problem, metric), show(*value));
    }
    std::fs::write(file(), page(&all)).expect("the page can be written");
}

/// What the page has of a metric.
pub fn key(problem: &str, metric: &Metric) -> Key {
    (problem.to_owned(), with(metric), metric.name.clone())
}

/// The overrides of a metric, as a line above its table.
fn with(metric: &Metric) -> String {
    if metric.set.is_empty() {
        return String::new();
    }
    let quoted = |pair: &String| format!("`--set '{pair}'`");
    format!("With {}:", metric.set.iter().map(quoted).collect::<Vec<_>>().join(" "))
}

/// Problems in the order of their names.
pub fn problems() -> Vec<String> {
    let folders = std::fs::read_dir("problems").expect("the problems").map(|entry| entry.expect("a folder"));
    let names = folders.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|name| !expect::metrics(name).is_empty()).collect();
    names.sort();
    names
}

/// The whole page.
pub fn page(measured: &Measured) -> String {
    let mut tables = String::new();
    for problem in problems() {
        let _ = writeln!(tables, "### [{problem}](../problems/{problem}/README.md)\n");
        let metrics = expect::metrics(&problem);
        let mut sets: Vec<&Vec<String>> = Vec::new();
        for metric in &metrics {
            if !sets.contains(&&metric.set) {
                sets.push(&metric.set);
            }
        }
        for set in sets {
            let of: Vec<&Metric> = metrics.iter().filter(|metric| metric.set == *set).collect();
            if !set.is_empty() {
                let _ = writeln!(tables, "{}\n", with(of[0]));
            }
            let _ = writeln!(tables, "{HEAD}\n|{}", " --- |".repeat(7));
            of.iter().for_each(|metric| tables.push_str(&row(metric, measured.get(&key(&problem, metric)))));
            tables.push('\n');
        }
    }
    let text = TEMPLATE.replace(PLACE, tables.trim_end());
    text.trim_end().to_owned() + "\n"
}

fn row(metric: &Metric, measured: Option<&String>) -> String {
    let Metric { name, reference, tolerance, source, open, .. } = metric;
    let value = measured.and_then(|text| text.parse::<f64>().ok());
    let apart = value.map(|value| value - reference);
    let deviation = match apart {
        None => "?".to_owned(),
        Some(apart) if *reference == 0.0 => format!("{apart:+.1e}"),
        Some(apart) => format!("{:+.2} %", 100.0 * apart / reference.abs()),
    };
    let part = apart.map_or("?".to_owned(), |apart| format!("{:.0} %", 100.0 * apart.abs() / tolerance));
    let why = open.as_ref().map(|why| format!(" **Not met**: {why}.")).unwrap_or_default();
    let second = match (&metric.plus, &metric.minus) {
        (Some(set), _) | (_, Some(set)) => {
            let quoted: Vec<String> = set.iter().map(|pair| format!("`--set '{pair}'`")).collect();
            format!(" Second run: {}.", quoted.join(" "))
        }
        _ => String::new(),
    };
    let measured = measured.map_or("?", String::as_str);
    format!(
        "| {name} | {} | ± {} | {measured} | {deviation} | {part} | {source}.{second}{why} |\n",
        show(*reference),
        show(*tolerance)
    )
}

/// A number with five digits that count, without zeros at its end.
pub fn show(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&size) {
        let text = format!("{value:.4e}");
        let (digits, power) = text.split_once('e').expect("a power");
        return format!("{}e{power}", shorter(digits));
    }
    let places = (4 - size.log10().floor() as i32).max(0) as usize;
    shorter(&format!("{value:.places$}")).to_owned()
}

fn shorter(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}
