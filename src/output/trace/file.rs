//! A trace as it stands in its file.
use crate::output::error::{Error, Result};
use crate::output::plain;
use engine::exec::trace::Kind;
use serde::Deserialize;
use std::io::BufReader;
use std::path::Path;

/// Ranks and workers have numbers below this: with one above, a list of them would fill the memory.
const MOST: usize = 1 << 20;

/// What a trace file holds.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Trace {
    /// Events of all ranks and workers, and their names.
    #[serde(rename = "traceEvents")]
    pub lines: Vec<Line>,
    #[serde(default)]
    other_data: OtherData,
}

#[derive(Default, Deserialize)]
struct OtherData {
    #[serde(default)]
    lost_events: u64,
    #[serde(default)]
    scene: String,
}

/// An event.
#[derive(Deserialize)]
pub struct Line {
    #[serde(default)]
    name: String,
    ph: String,
    #[serde(default)]
    cat: String,
    #[serde(default)]
    ts: f64,
    #[serde(default)]
    dur: f64,
    /// The rank.
    #[serde(default, rename = "pid")]
    pub rank: usize,
    /// The worker of the rank.
    #[serde(default, rename = "tid")]
    pub worker: usize,
    /// What else is known of it.
    #[serde(default, rename = "args")]
    pub about: About,
}

/// What is known of an event.
#[derive(Default, Deserialize)]
pub struct About {
    /// Names of the tasks of its stage.
    #[serde(default)]
    pub tasks: Vec<String>,
    /// Its material.
    pub material: Option<String>,
    /// Its phase, or the one that waits.
    pub phase: Option<usize>,
    /// Number of the exchange.
    pub exchange: Option<usize>,
    /// The first layer of blocks of the slab; `None`: the rim.
    pub slab: Option<u32>,
    /// Number of the step.
    pub step: Option<u64>,
    /// Messages sent.
    #[serde(default)]
    pub messages: u64,
    /// Bytes sent.
    #[serde(default)]
    pub bytes: u64,
}

impl Trace {
    /// Reads the trace in `path`.
    ///
    /// # Errors
    /// A file that cannot be read, or is no trace of a run.
    pub fn load(path: &Path) -> Result<Self> {
        let file = plain::open(path)?;
        let wrong = |why: String| Error::Content {
            path: path.into(),
            problem: format!("not a trace that sinew run --trace wrote: {why}"),
        };
        let trace: Self =
            serde_json::from_reader(BufReader::new(file)).map_err(|error| wrong(error.to_string()))?;
        match trace.lines.iter().find(|line| line.rank.max(line.worker) >= MOST) {
            Some(Line { rank, worker, .. }) => {
                Err(wrong(format!("it has an event of worker {worker} of rank {rank}")))
            }
            None => Ok(trace),
        }
    }

    /// The identity of the scene that ran; empty if the trace does not say it.
    pub fn scene(&self) -> &str {
        &self.other_data.scene
    }

    /// Events that the recorder had no room for.
    pub fn lost(&self) -> u64 {
        self.other_data.lost_events
    }
}

impl Line {
    /// Whether it is a piece of a worker's time.
    pub fn is_event(&self) -> bool {
        self.ph == "X"
    }

    /// Whether it names a rank or a worker.
    pub fn is_name(&self) -> bool {
        self.ph == "M"
    }

    /// What the worker was busy with; `None`: a kind of which this version knows nothing.
    pub fn kind(&self) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| kind.name() == self.cat)
    }

    /// What it is called.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The name of its kind.
    pub fn category(&self) -> &str {
        &self.cat
    }

    /// When it began [ns].
    pub fn start(&self) -> f64 {
        1e3 * self.ts
    }

    /// How long it took [ns].
    pub fn duration(&self) -> f64 {
        1e3 * self.dur
    }
}
