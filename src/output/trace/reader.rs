//! Sums up a trace.
use crate::exec::trace::Kind;
use crate::graph::measured::{About, Measured, Sum, Worker};
use crate::output::error::{Error, Result, io};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Trace {
    trace_events: Vec<Line>,
    #[serde(default)]
    other_data: OtherData,
}

#[derive(Default, Deserialize)]
struct OtherData {
    #[serde(default)]
    lost_events: u64,
}

#[derive(Deserialize)]
struct Line {
    ph: String,
    #[serde(default)]
    cat: String,
    #[serde(default)]
    ts: f64,
    #[serde(default)]
    dur: f64,
    #[serde(default)]
    pid: u64,
    #[serde(default)]
    tid: u64,
    #[serde(default)]
    args: Arguments,
}

#[derive(Default, Deserialize)]
struct Arguments {
    #[serde(default)]
    tasks: Vec<String>,
    material: Option<String>,
    phase: Option<usize>,
    step: Option<u64>,
    #[serde(default)]
    messages: u64,
    #[serde(default)]
    bytes: u64,
}

/// Sums up the trace in `path`: by task, wait and worker.
///
/// # Errors
/// A file that cannot be read, or is no trace of a run.
pub fn read(path: &Path) -> Result<Measured> {
    let file = File::open(path).map_err(io("open", path))?;
    let trace: Trace = serde_json::from_reader(BufReader::new(file)).map_err(|error| Error::Content {
        path: path.into(),
        problem: format!("not a trace that sinew run --trace wrote: {error}"),
    })?;
    let events: Vec<&Line> = trace.trace_events.iter().filter(|line| line.ph == "X").collect();
    if events.is_empty() {
        let problem = "the trace holds no events: record one with sinew run --trace".to_owned();
        return Err(Error::Content { path: path.into(), problem });
    }
    let steps: BTreeSet<u64> = events.iter().filter_map(|line| line.args.step).collect();
    let first = events.iter().map(|line| line.ts).fold(f64::INFINITY, f64::min);
    let last = events.iter().map(|line| line.ts + line.dur).fold(f64::NEG_INFINITY, f64::max);
    let mut measured = Measured {
        steps: steps.len() as u64,
        span_ns: 1e3 * (last - first),
        lost: trace.other_data.lost_events,
        ..Measured::default()
    };
    let named = trace.trace_events.iter().filter(|line| line.ph == "M");
    let mut workers: BTreeMap<(u64, u64), Worker> = BTreeMap::new();
    for line in named.chain(events.iter().copied()) {
        let (rank, thread) = (line.pid, line.tid);
        let worker = workers.entry((rank, thread)).or_default();
        (worker.rank, worker.thread) = (rank, thread);
        if line.ph == "X" {
            add(&mut measured, worker, line);
        }
    }
    measured.workers = workers.into_values().collect();
    for worker in &mut measured.workers {
        worker.idle_ns = (measured.span_ns - worker.busy_ns - worker.wait_ns).max(0.0);
    }
    Ok(measured)
}

fn add(measured: &mut Measured, worker: &mut Worker, line: &Line) {
    let args = &line.args;
    let sum = Sum { ns: 1e3 * line.dur, events: 1, messages: args.messages, bytes: args.bytes };
    let kind = Kind::ALL.into_iter().find(|kind| kind.name() == line.cat);
    let about = match kind {
        Some(Kind::Task) => About::Stage(args.tasks.clone(), args.material.clone()),
        Some(Kind::Idle) => About::Idle(args.tasks.clone(), args.material.clone()),
        Some(Kind::HaloWait) => About::Halo(args.phase.unwrap_or_default()),
        Some(Kind::ReduceWait) => About::Reduction(args.phase),
        _ => About::Other(line.cat.clone()),
    };
    match kind {
        Some(Kind::HaloWait | Kind::ReduceWait) => worker.wait_ns += sum.ns,
        Some(Kind::Idle) => {}
        _ => worker.busy_ns += sum.ns,
    }
    measured.add(about, &sum);
}
