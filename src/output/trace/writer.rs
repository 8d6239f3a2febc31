//! Writes the events of all ranks, piece by piece, so that no rank ever holds those of all.
use crate::output::create::create;
use crate::output::error::{Result, io};
use engine::exec::ranks::{Network, collective, pack, unpack};
use engine::exec::recorder::{Recorder, Track};
use engine::exec::trace::{Event, Kind, NONE, TRAVELERS};
use engine::graph::build::TaskGraph;
use engine::graph::phase::Stage;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Events that travel in one message.
const PIECE: usize = 1 << 14;
/// Numbers before the events of a piece: their worker, and how many the worker lost.
const HEAD: usize = 2;

/// Writes what `recorder` has recorded of the graphs of a program, and the recorders of all other ranks, into one file. All ranks must call it
/// together; rank 0 writes. The recorders go on with empty lists. `scene` is the identity of the scene.
///
/// # Errors
/// A file that cannot be written (on rank 0), or a rank that is gone.
pub fn write(
    path: &Path,
    scene: &str,
    graphs: &[&TaskGraph],
    recorder: &Recorder,
    network: &mut dyn Network,
) -> Result<()> {
    let pieces = pieces(&recorder.take());
    let counts = collective::share(network, &[pieces.len() as u64])?;
    let rounds = counts.iter().filter_map(|count| count.first()).max().copied().unwrap_or(0);
    let mut writer = None;
    let mut result = Ok(());
    if network.rank() == 0 {
        match Writer::create(path, graphs, network.size()) {
            Ok(created) => writer = Some(created),
            Err(error) => result = Err(error),
        }
    }
    let mut pieces = pieces.into_iter();
    for _ in 0..rounds {
        // a rank that has no more sends an empty piece: all take part in every round
        let message = pack(&pieces.next().unwrap_or_default());
        let take = |rank: usize, lines: &[_]| {
            if let (Some(writer), Ok(())) = (&mut writer, &result) {
                result = writer.piece(rank, unpack(lines));
            }
        };
        collective::gather(network, message, take)?;
    }
    match writer {
        Some(writer) if result.is_ok() => writer.finish(scene),
        _ => result,
    }
}

/// The tracks of a rank, cut into pieces.
fn pieces(tracks: &[Track]) -> Vec<Vec<u64>> {
    let mut pieces = Vec::new();
    for (worker, track) in tracks.iter().enumerate() {
        let mut lost = track.lost;
        // a worker without events has a piece as well: it has a track, and may have lost some
        for events in track.events.chunks(PIECE).chain(track.events.is_empty().then_some(&[][..])) {
            let mut words = vec![worker as u64, std::mem::take(&mut lost)];
            words.extend(events.iter().flat_map(|event| event.to_words()));
            pieces.push(words);
        }
    }
    pieces
}

/// A trace that is being written.
struct Writer<'a> {
    file: BufWriter<File>,
    path: &'a Path,
    graphs: &'a [&'a TaskGraph],
    /// Stages and their phases by their graph and the first of their lines in the recipe.
    stages: HashMap<[u32; 2], (usize, &'a Stage)>,
    /// Tracks that have their names.
    named: Vec<(usize, u64)>,
    /// Bytes that each rank has sent so far.
    sent: Vec<u64>,
    lost: u64,
    first: bool,
}

impl<'a> Writer<'a> {
    fn create(path: &'a Path, graphs: &'a [&'a TaskGraph], ranks: usize) -> Result<Self> {
        let file = create(path)?;
        let mut stages = HashMap::new();
        for (graph, it) in graphs.iter().enumerate() {
            for (number, phase) in it.phases.iter().enumerate() {
                let first = |stage: &Stage| stage.entries.first().map(|&entry| [graph as u32, entry as u32]);
                stages.extend(phase.stages.iter().filter_map(|stage| Some((first(stage)?, (number, stage)))));
            }
        }
        let (file, named, sent) = (BufWriter::new(file), Vec::new(), vec![0; ranks]);
        let mut writer = Self { file, path, graphs, stages, named, sent, lost: 0, first: true };
        writer.text("{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n")?;
        for rank in 0..ranks {
            writer.line(&meta("process_name", rank, 0, json!({ "name": format!("rank {rank}") })))?;
            writer.line(&meta("process_sort_index", rank, 0, json!({ "sort_index": rank })))?;
        }
        Ok(writer)
    }

    fn text(&mut self, text: &str) -> Result<()> {
        self.file.write_all(text.as_bytes()).map_err(io("write", self.path))
    }

    fn line(&mut self, event: &Value) -> Result<()> {
        let comma = if std::mem::take(&mut self.first) { "" } else { ",\n" };
        self.text(&format!("{comma}{event}"))
    }

    /// Writes a piece of a worker's track.
    fn piece(&mut self, rank: usize, words: &[u64]) -> Result<()> {
        let [worker, lost, events @ ..] = words else { return Ok(()) };
        debug_assert_eq!(words.len() % Event::WORDS, HEAD);
        self.lost += lost;
        if !self.named.contains(&(rank, *worker)) {
            self.named.push((rank, *worker));
            let name = json!({ "name": format!("worker {worker}") });
            self.line(&meta("thread_name", rank, *worker, name))?;
        }
        for event in events.chunks_exact(Event::WORDS).filter_map(Event::from_words) {
            self.line(&self.complete(rank, *worker, &event))?;
            if event.bytes > 0 {
                self.sent[rank] += event.bytes;
                let sent = json!({ "bytes": self.sent[rank] });
                let end = micros(event.start + event.duration);
                self.line(&json!({
                    "name": "bytes sent", "ph": "C", "ts": end, "pid": rank, "tid": worker, "args": sent
                }))?;
            }
        }
        Ok(())
    }

    /// An event with a beginning and a duration.
    fn complete(&self, rank: usize, worker: u64, event: &Event) -> Value {
        let (name, tasks) = self.name(event);
        let known = |number: u32| (number != NONE).then_some(number);
        let phase = match event.kind {
            Kind::HaloWait | Kind::ReduceWait => known(event.place),
            _ => self.stages.get(&[event.graph, event.place]).map(|(phase, _)| *phase as u32),
        };
        let mut args = json!({ "step": event.step });
        let graph = self.graphs.get(event.graph as usize);
        let materials = graph.map_or(&[][..], |graph| &graph.recipe.materials);
        let material = known(event.material).and_then(|m| materials.get(m as usize));
        let mut add = |key: &str, value: Value| {
            if !value.is_null() {
                args[key] = value;
            }
        };
        add("tasks", if tasks.is_empty() { Value::Null } else { json!(tasks) });
        add("material", json!(material));
        add("graph", json!(graph.filter(|_| self.graphs.len() > 1).map(|graph| graph.name)));
        add("phase", json!(phase));
        add("exchange", json!(known(event.message).filter(|_| event.kind == Kind::HaloWait)));
        add("patch", json!(known(event.patch)));
        add("slab", json!(known(event.slab)));
        if event.messages > 0 {
            add("messages", json!(event.messages));
            add("bytes", json!(event.bytes));
        }
        json!({
            "name": name, "cat": event.kind.name(), "ph": "X", "ts": micros(event.start),
            "dur": micros(event.duration), "pid": rank, "tid": worker, "args": args
        })
    }

    /// What an event is called, and the tasks that it ran.
    fn name(&self, event: &Event) -> (String, Vec<&str>) {
        let labels = |labels: &[engine::schema::LabelId]| {
            labels.iter().map(|label| label.name()).collect::<Vec<_>>().join(", ")
        };
        let Some(graph) = self.graphs.get(event.graph as usize) else {
            return (event.kind.name().to_owned(), Vec::new());
        };
        let phase = graph.phases.get(event.place as usize);
        match (event.kind, phase) {
            (Kind::Task | Kind::Idle, _) => {
                let stage = self.stages.get(&[event.graph, event.place]).map(|(_, stage)| *stage);
                let name = stage.filter(|_| event.kind == Kind::Task).map(|stage| graph.name_of(stage));
                let tasks = stage.map_or_else(Vec::new, |stage| graph.tasks_of(stage));
                (name.unwrap_or_else(|| event.kind.name().to_owned()), tasks)
            }
            (Kind::HaloWait, Some(phase)) => (format!("halo: {}", labels(&phase.halos)), Vec::new()),
            (Kind::ReduceWait, Some(phase)) => (format!("reduce: {}", labels(&phase.reductions)), Vec::new()),
            (Kind::ReduceWait, None) if event.message == TRAVELERS => ("travelers".to_owned(), Vec::new()),
            (Kind::ReduceWait, None) => (format!("reduce: {}", labels(&graph.at_end)), Vec::new()),
            (kind, _) => (kind.name().to_owned(), Vec::new()),
        }
    }

    fn finish(mut self, scene: &str) -> Result<()> {
        let about = json!({ "lost_events": self.lost, "scene": scene });
        self.text(&format!("\n],\n\"otherData\":{about}}}\n"))?;
        self.file.flush().map_err(io("write", self.path))
    }
}

/// An event that names a process or a thread.
fn meta(what: &str, rank: usize, worker: u64, args: Value) -> Value {
    json!({ "name": what, "ph": "M", "ts": 0, "pid": rank, "tid": worker, "args": args })
}

fn micros(ns: u64) -> f64 {
    ns as f64 / 1e3
}
