//! Where the time of a run went, from its trace: by rank and by kind of work.
//!
//! The first worker of a rank works on everything that is not tasks: its time line is that of the rank. What lies
//! between its events is the engine: lists of blocks, handing out work, checks.
use crate::output::error::{Error, Result};
use crate::output::trace::{Line, Trace};
use engine::exec::trace::Kind;
use std::collections::BTreeMap;
use std::path::Path;

/// The time of a rank, over the steps that count.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rank {
    /// From the first step that counts to the end of the last [ns].
    pub span: f64,
    /// In tasks: the first worker, and all workers [ns].
    pub tasks: [f64; 2],
    /// Packing and sending node data [ns].
    pub pack: f64,
    /// Waiting for node data, and putting them in their place [ns].
    pub halo: f64,
    /// In reductions, and waiting for travelers [ns].
    pub reduce: f64,
    /// Looking for particles that move [ns].
    pub relocate: f64,
    /// Waiting for other workers: the first worker [ns].
    pub idle: f64,
    /// Messages of halos and relocation.
    pub messages: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Bytes of halos among them.
    pub packed: u64,
    /// Workers.
    pub workers: usize,
}

impl Rank {
    /// What the first worker did that was neither tasks nor talk nor waiting [ns].
    pub fn engine(&self) -> f64 {
        (self.span - self.tasks[0] - self.pack - self.halo - self.reduce - self.idle).max(0.0)
    }
}

/// A trace, summed up over the steps that count.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Steps that count.
    pub steps: u64,
    /// The ranks.
    pub ranks: Vec<Rank>,
    /// Task time by phase and material, over all ranks and workers [ns].
    pub stages: BTreeMap<(usize, Option<String>), f64>,
    /// Events that the recorder had no room for.
    pub lost: u64,
}

/// Sums up a trace from step `first` on, but for its last step, whose end is that of the run.
///
/// # Errors
/// A file that cannot be read, is no trace, or holds no step that counts.
pub fn read(path: &Path, first: u64) -> Result<Tally> {
    let problem = |problem: String| Error::Content { path: path.into(), problem };
    let trace = Trace::load(path)?;
    let events = || trace.lines.iter().filter(|line| line.is_event());
    let last = events().filter_map(|line| line.about.step).max().unwrap_or(0);
    if last <= first {
        return Err(problem(format!("the trace ends with step {last}: no step after {first} is whole")));
    }
    let mut tally = Tally { steps: last - first, lost: trace.lost(), ..Tally::default() };
    let ranks = trace.lines.iter().map(|line| line.rank + 1).max().unwrap_or(1);
    tally.ranks.resize(ranks, Rank::default());
    let mut bounds = vec![[f64::INFINITY; 2]; ranks];
    for line in trace.lines.iter() {
        tally.ranks[line.rank].workers = tally.ranks[line.rank].workers.max(line.worker + 1);
        let Some(step) = line.about.step.filter(|_| line.is_event()) else { continue };
        // a rank is at a step as soon as one of its workers is
        for (bound, _) in bounds[line.rank].iter_mut().zip([first, last]).filter(|(_, edge)| step == *edge) {
            *bound = bound.min(line.start());
        }
        if (first..last).contains(&step) {
            add(&mut tally, line);
        }
    }
    for (rank, [begin, end]) in tally.ranks.iter_mut().zip(bounds) {
        rank.span = if end.is_finite() && begin.is_finite() { end - begin } else { 0.0 };
    }
    Ok(tally)
}

fn add(tally: &mut Tally, line: &Line) {
    let (rank, ns, args) = (&mut tally.ranks[line.rank], line.duration(), &line.about);
    // a file may say anything
    rank.messages = rank.messages.saturating_add(args.messages);
    rank.bytes = rank.bytes.saturating_add(args.bytes);
    match line.kind() {
        Some(Kind::Task) => {
            rank.tasks[1] += ns;
            rank.tasks[0] += if line.worker == 0 { ns } else { 0.0 };
            if let Some(phase) = args.phase {
                *tally.stages.entry((phase, args.material.clone())).or_default() += ns;
            }
        }
        Some(Kind::HaloWait) if args.bytes > 0 => {
            rank.pack += ns;
            rank.packed = rank.packed.saturating_add(args.bytes);
        }
        Some(Kind::HaloWait) => rank.halo += ns,
        Some(Kind::ReduceWait) => rank.reduce += ns,
        Some(Kind::Relocate) => rank.relocate += ns,
        Some(Kind::Idle) if line.worker == 0 => rank.idle += ns,
        _ => {}
    }
}
