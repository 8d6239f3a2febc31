//! The folder of a run: scene, history, frames and summary. All ranks call what is here, rank 0 alone has the files.
mod rows;
mod summarize;

use super::{Simulation, parcel, together};
use crate::output::frame::Head;
use crate::output::history::History;
use crate::output::summary::{self, Status, Summary};
use crate::output::{self, vtkhdf};
use std::path::{Path, PathBuf};
use std::time::Instant;
use summarize::Ending;

/// Writes what a run leaves behind.
pub struct Recorder {
    folder: PathBuf,
    /// On rank 0.
    files: Option<Files>,
    frames: usize,
    began: Instant,
    /// Seconds spent on output.
    pub output_s: f64,
}

struct Files {
    history: History,
    particles: Option<vtkhdf::Writer>,
}

/// The files that make a folder a run's.
const FILES: [&str; 4] = ["scene.toml", "summary.json", "history.csv", "particles.vtkhdf"];

/// Whether a folder holds a run.
pub fn holds_run(folder: &Path) -> bool {
    FILES.iter().any(|file| folder.join(file).exists())
}

impl Recorder {
    /// Makes the folder, writes `scene.toml` and the first row and frame.
    ///
    /// # Errors
    /// If the folder or a file in it cannot be written.
    pub fn create(folder: &Path, simulation: &mut Simulation) -> output::Result<Self> {
        let files = match simulation.network().rank() {
            0 => Files::create(folder, simulation).map(Some),
            _ => Ok(None),
        };
        let files = together::agree(simulation.network(), files)?;
        let (folder, began) = (folder.to_owned(), Instant::now());
        let mut recorder = Self { folder, files, frames: 0, began, output_s: 0.0 };
        recorder.row(simulation)?;
        recorder.frame(simulation)?;
        Ok(recorder)
    }

    /// After a step: a row and a frame, if they are due.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn step(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        let finished = simulation.finished();
        if finished || simulation.steps().is_multiple_of(simulation.scene.output.history_every.max(1)) {
            self.row(simulation)?;
        }
        let every = simulation.scene.run.until / simulation.scene.output.frames.max(1) as f64;
        // a hair early rather than a step late
        let due = simulation.clock().time >= self.frames as f64 * every * (1.0 - 1e-12);
        if self.frames > 0 && (finished || due) {
            self.frame(simulation)?;
        }
        Ok(())
    }

    fn row(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        let began = Instant::now();
        let report = simulation.report()?;
        let written = self.files.as_mut().map_or(Ok(()), |files| files.history.row(&rows::cells(&report)));
        together::agree(simulation.network(), written)?;
        self.output_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    fn frame(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        if simulation.scene.output.frames == 0 {
            return Ok(());
        }
        let began = Instant::now();
        let writer = self.files.as_mut().and_then(|files| files.particles.as_mut());
        let written = frame(writer, simulation);
        together::agree(simulation.network(), written)?;
        self.frames += 1;
        self.output_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    /// Closes all files and writes `summary.json`.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn finish(mut self, simulation: &mut Simulation, error: Option<String>) -> output::Result<Summary> {
        if error.is_some() && self.frames > 0 {
            self.frame(simulation)?;
        }
        let writer = self.files.as_mut().and_then(|files| files.particles.take());
        together::agree(simulation.network(), writer.map_or(Ok(()), vtkhdf::Writer::close))?;
        let wall_s = self.began.elapsed().as_secs_f64();
        let status = if error.is_some() { Status::Failed } else { Status::Completed };
        let ending = Ending { status, error, wall_s, stepping_s: wall_s - self.output_s };
        let summary = summarize::summarize(simulation, ending)?;
        let path = self.folder.join("summary.json");
        let written = self.files.map_or(Ok(()), |_| summary.write(&path));
        together::agree(simulation.network(), written)?;
        Ok(summary)
    }
}

impl Files {
    fn create(folder: &Path, simulation: &Simulation) -> output::Result<Self> {
        let cannot = |source| output::Error::Io { action: "create", path: folder.into(), source };
        std::fs::create_dir_all(folder).map_err(cannot)?;
        for file in FILES.iter().map(|file| folder.join(file)).filter(|file| file.exists()) {
            std::fs::remove_file(&file).map_err(cannot)?;
        }
        summary::write_whole(&folder.join("scene.toml"), simulation.scene.resolved.as_bytes())?;
        let history = History::create(&folder.join("history.csv"), &rows::columns(&simulation.scene))?;
        let particles = match simulation.scene.output.frames {
            0 => None,
            _ => Some(vtkhdf::Writer::create(&folder.join("particles.vtkhdf"))?),
        };
        Ok(Self { history, particles })
    }
}

/// Writes a frame on rank 0 (the one with the writer), from pieces of all ranks.
fn frame(mut writer: Option<&mut vtkhdf::Writer>, simulation: &mut Simulation) -> output::Result<()> {
    let (time, step) = (simulation.clock().time, simulation.steps());
    let mine = simulation.warehouse.particle_count();
    let rank = simulation.network().rank();
    let counts = together::all(simulation.network(), &[mine as u64])?;
    let total = |ranks: &[Vec<u64>]| ranks.iter().map(|count| count[0] as usize).sum();
    let (row, particles) = (total(&counts[..rank]), total(&counts));
    let Simulation { scene, warehouse, network, .. } = simulation;
    let snapshot = super::Snapshot::new(scene, warehouse);
    let head = Head { time, step, particles, fields: snapshot.fields().to_vec() };
    let mut written = writer.as_mut().map_or(Ok(()), |writer| writer.begin(head));
    // whatever fails here, the others send all they have
    let take = |piece| {
        if let (Ok(()), Some(writer)) = (&written, &mut writer) {
            written = writer.piece(&piece);
        }
    };
    parcel::collect(&mut **network, |give| snapshot.pieces(row, give), take)?;
    written?;
    writer.map_or(Ok(()), vtkhdf::Writer::end)
}
