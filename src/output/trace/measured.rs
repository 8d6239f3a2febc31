//! Times that a run measured, as plain numbers from who read its trace.

/// Sums over all events of one kind and name, all ranks and workers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sum {
    /// Time [ns].
    pub ns: f64,
    /// Events.
    pub events: u64,
    /// Messages sent.
    pub messages: u64,
    /// Bytes sent.
    pub bytes: u64,
}

impl Sum {
    /// Adds another sum.
    pub fn add(&mut self, more: &Sum) {
        self.ns += more.ns;
        // a file may say anything
        self.events = self.events.saturating_add(more.events);
        self.messages = self.messages.saturating_add(more.messages);
        self.bytes = self.bytes.saturating_add(more.bytes);
    }
}

/// What an event was about.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum About {
    /// The fused tasks of a stage, and their material.
    Stage(Vec<String>, Option<String>),
    /// Waiting until other workers have done a stage.
    Idle(Vec<String>, Option<String>),
    /// Waiting for the halos before a phase.
    Halo(usize),
    /// Waiting for a reduction before a phase; `None`: at the end of a tick.
    Reduction(Option<usize>),
    /// Anything else, by the name of its kind.
    Other(String),
}

/// Where the time of one worker went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Worker {
    /// Its rank.
    pub rank: u64,
    /// Its number on the rank.
    pub thread: u64,
    /// In tasks, relocation and output [ns].
    pub busy_ns: f64,
    /// Waiting for other ranks [ns].
    pub wait_ns: f64,
    /// The rest [ns].
    pub idle_ns: f64,
}

/// A trace, summed up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Steps that the trace covers.
    pub steps: u64,
    /// From the first event to the end of the last [ns].
    pub span_ns: f64,
    /// What took how long, over all ranks and workers.
    pub sums: Vec<(About, Sum)>,
    /// Where the time of each worker went.
    pub workers: Vec<Worker>,
    /// Events that the recorder had no room for.
    pub lost: u64,
    /// The identity of the scene that ran; empty: the trace does not say it.
    pub scene: String,
}

impl Measured {
    /// The sum of what an event was about.
    pub fn sum(&self, about: &About) -> Option<&Sum> {
        self.sums.iter().find(|(a, _)| a == about).map(|(_, sum)| sum)
    }

    /// Adds an event.
    pub fn add(&mut self, about: About, sum: &Sum) {
        match self.sums.iter_mut().find(|(a, _)| *a == about) {
            Some((_, known)) => known.add(sum),
            None => self.sums.push((about, sum.clone())),
        }
    }

    /// Mean of a sum over steps [ns].
    pub fn per_step(&self, ns: f64) -> f64 {
        ns / self.steps.max(1) as f64
    }

    /// The table of workers, with mean milliseconds a step.
    pub fn table(&self) -> String {
        let mut out = format!(
            "measured: {} steps, {:.3} ms a step\n  rank thread      busy ms      wait ms      idle ms\n",
            self.steps,
            1e-6 * self.per_step(self.span_ns)
        );
        for w in &self.workers {
            let [busy, wait, idle] = [w.busy_ns, w.wait_ns, w.idle_ns].map(|ns| 1e-6 * self.per_step(ns));
            out += &format!("  {:>4} {:>6} {busy:>12.4} {wait:>12.4} {idle:>12.4}\n", w.rank, w.thread);
        }
        if self.lost > 0 {
            out += &format!("  {} events did not fit into the trace: means are too small\n", self.lost);
        }
        out
    }
}
