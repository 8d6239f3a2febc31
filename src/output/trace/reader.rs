//! Sums up a trace.
use super::file::{Line, Trace};
use super::measured::{About, Measured, Sum, Worker};
use crate::output::error::{Error, Result};
use engine::exec::trace::Kind;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Sums up the trace in `path`: by task, wait and worker.
///
/// # Errors
/// A file that cannot be read, or is no trace of a run.
pub fn read(path: &Path) -> Result<Measured> {
    let trace = Trace::load(path)?;
    let events: Vec<&Line> = trace.lines.iter().filter(|line| line.is_event()).collect();
    if events.is_empty() {
        let problem = "the trace holds no events: record one with sinew run --trace".to_owned();
        return Err(Error::Content { path: path.into(), problem });
    }
    let steps: BTreeSet<u64> = events.iter().filter_map(|line| line.about.step).collect();
    let first = events.iter().map(|line| line.start()).fold(f64::INFINITY, f64::min);
    let last = events.iter().map(|line| line.start() + line.duration()).fold(f64::NEG_INFINITY, f64::max);
    let mut measured = Measured {
        steps: steps.len() as u64,
        span_ns: last - first,
        lost: trace.lost(),
        scene: trace.scene().to_owned(),
        ..Measured::default()
    };
    let named = trace.lines.iter().filter(|line| line.is_name());
    let mut workers: BTreeMap<(u64, u64), Worker> = BTreeMap::new();
    for line in named.chain(events.iter().copied()) {
        let (rank, thread) = (line.rank as u64, line.worker as u64);
        let worker = workers.entry((rank, thread)).or_default();
        (worker.rank, worker.thread) = (rank, thread);
        if line.is_event() {
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
    let args = &line.about;
    let sum = Sum { ns: line.duration(), events: 1, messages: args.messages, bytes: args.bytes };
    let kind = line.kind();
    let about = match kind {
        Some(Kind::Task) => About::Stage(args.tasks.clone(), args.material.clone()),
        Some(Kind::Idle) => About::Idle(args.tasks.clone(), args.material.clone()),
        Some(Kind::HaloWait) => About::Halo(args.phase.unwrap_or_default()),
        Some(Kind::ReduceWait) => About::Reduction(args.phase),
        _ => About::Other(line.category().to_owned()),
    };
    match kind {
        Some(Kind::HaloWait | Kind::ReduceWait) => worker.wait_ns += sum.ns,
        Some(Kind::Idle) => {}
        _ => worker.busy_ns += sum.ns,
    }
    measured.add(about, &sum);
}
