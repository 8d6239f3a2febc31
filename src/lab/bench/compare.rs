//! Two reports beside each other: every number of one that has a partner in the other.
use super::report::Report;
use serde_json::Value;
use std::fmt;

/// A number now and then.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Where it is in the report.
    pub path: String,
    /// In the earlier report.
    pub then: f64,
    /// In this report.
    pub now: f64,
    /// Now over then.
    pub ratio: f64,
    /// The same, with times in multiply-adds of one core (on all threads: of all cores) and rates as shares of their
    /// ceiling: what is left when the machine is faster or slower by as much.
    pub normalized: f64,
}

/// All pairs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// In the order of the report.
    pub pairs: Vec<Pair>,
    /// What makes the two differ besides speed: another machine, instruction set or scene.
    pub notes: Vec<String>,
}

/// This report over an earlier one. Numbers that are zero in both are left out.
pub fn compare(now: &Report, then: &Report) -> Comparison {
    let machine = Faster {
        one: now.one_core.fma_gflop_per_s / then.one_core.fma_gflop_per_s,
        all: now.all_cores.fma_gflop_per_s / then.all_cores.fma_gflop_per_s,
    };
    let (mut mine, mut theirs) = (Vec::new(), Vec::new());
    flatten("", &value(now), &mut mine);
    flatten("", &value(then), &mut theirs);
    let pairs = mine.into_iter().filter_map(|(path, now)| {
        let then = theirs.iter().find(|(other, _)| *other == path)?.1;
        let ratio = if now == then { 1.0 } else { now / then };
        let normalized = ratio * machine.takes_out_of(&path);
        (now != 0.0 || then != 0.0).then_some(Pair { path, then, now, ratio, normalized })
    });
    Comparison { pairs: pairs.collect(), notes: notes(now, then) }
}

/// How much faster multiply-adds are now, on one core and on all.
struct Faster {
    one: f64,
    all: f64,
}

impl Faster {
    /// What takes the machine's speed out of a number, by the unit at the end of its name.
    fn takes_out_of(&self, path: &str) -> f64 {
        let all = path.contains("all_threads") || path.contains("all_cores");
        let machine = if all { self.all } else { self.one };
        match path {
            _ if path.ends_with("_per_s") => 1.0 / machine,
            _ if path.ends_with("_ns") => machine,
            _ => 1.0,
        }
    }
}

fn value(report: &Report) -> Value {
    serde_json::to_value(report).unwrap_or_default()
}

/// All numbers with their paths. Items of lists go by their names, and lists have none: `G2P tissue.Gather.bytes`.
fn flatten(path: &str, value: &Value, numbers: &mut Vec<(String, f64)>) {
    let below = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
    match value {
        Value::Number(number) => numbers.extend(number.as_f64().map(|x| (path.to_owned(), x))),
        Value::Object(fields) => {
            for (key, value) in fields {
                let path = if value.is_array() { path.to_owned() } else { below(key) };
                flatten(&path, value, numbers);
            }
        }
        Value::Array(items) => {
            for item in items {
                let name = item.get("name").and_then(Value::as_str).unwrap_or_default();
                flatten(&below(name), item, numbers);
            }
        }
        _ => {}
    }
}

fn notes(now: &Report, then: &Report) -> Vec<String> {
    let facts = |r: &Report| {
        let state = format!("{} at {:.4} ms", r.state.scene, r.state.time_ms);
        let threads = r.all_threads.threads.to_string();
        [r.machine.processor.clone(), r.machine.isa.clone(), state, threads]
    };
    let names = ["processor", "instruction set", "state", "threads"];
    let both = facts(now).into_iter().zip(facts(then)).zip(names);
    both.filter(|((now, then), _)| now != then)
        .map(|((now, then), name)| format!("{name}: {now}, then {then}"))
        .collect()
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{:<58} {:>12} {:>12} {:>9} {:>11}", "", "then", "now", "now/then", "normalized")?;
        for Pair { path, then, now, ratio, normalized } in &self.pairs {
            writeln!(f, "{path:<58} {then:>12.5e} {now:>12.5e} {ratio:>9.3} {normalized:>11.3}")?;
        }
        writeln!(
            f,
            "normalized: times and rates in units of the fused multiply-adds measured in the same run"
        )?;
        self.notes.iter().try_for_each(|note| writeln!(f, "differs: {note}"))
    }
}
