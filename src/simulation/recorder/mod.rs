//! The folder of a run: scene, history, frames, checkpoints and summary. All ranks call what is here, rank 0 alone has
//! the files.
mod backup;
mod due;
mod files;
mod rows;
mod seen;
mod summarize;

use super::Simulation;
use super::watch::{Said, Watch};
use crate::output::checkpoint::{self, Head, Reader, Recorded};
use crate::output::claim::Claim;
use crate::output::frame;
use crate::output::run_id::RunId;
use crate::output::summary::{Status, Summary};
use crate::output::{self, vtkhdf};
use crate::output::{parcel, together};
use backup::Backup;
use due::{Checkpoints, Due};
use engine::exec::ranks::{Network, collective};
use files::Files;
pub use files::{Held, held, is_result};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::Instant;
use summarize::Ending;

/// Writes what a run leaves behind.
pub struct Recorder {
    folder: PathBuf,
    run: RunId,
    /// Whose folder it is, on rank 0.
    claim: Option<Rc<Claim>>,
    /// On rank 0.
    files: Option<Files>,
    /// Number of the next frame of the whole run.
    due: usize,
    /// Simulated time after the last step [s].
    time: f64,
    checkpoints: Checkpoints,
    /// Whether the last row, and the last frame, were written only because the run ends.
    last: [bool; 2],
    began: Instant,
    /// What was recorded before a restart.
    before: Recorded,
    /// Seconds spent on output, without those before a restart.
    pub output_s: f64,
    watch: Watch,
    backup: Backup,
    /// All warnings so far, those before a restart and of it among them.
    warnings: Vec<Said>,
    /// How many of them were told.
    told: usize,
}

/// What to do after a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// The next step, if there is one.
    Go,
    /// Nothing: the run was interrupted, and a checkpoint is written.
    Stop,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// As the scene says.
    Completed,
    /// It was stopped from outside.
    Interrupted,
    /// By an error.
    Failed(String),
}

/// The last whole checkpoint of a folder, open on all ranks, and the damaged ones after it with what is wrong with them.
/// Rank 0 looks for it.
///
/// # Errors
/// If there is none, or it cannot be read: on all ranks.
pub fn last_checkpoint(
    network: &mut dyn Network,
    folder: &Path,
) -> output::Result<(Reader, checkpoint::Found)> {
    let found = match network.rank() {
        0 => checkpoint::last_whole(folder).map(Some),
        _ => Ok(None),
    };
    let found = together::agree(network, found)?;
    let path = found.as_ref().map_or_else(PathBuf::new, |found| found.path.clone());
    let path = together::path_from_first(network, &path)?;
    let reader = seen::open(network, &path)?;
    let none = checkpoint::Found { path, damaged: Vec::new(), warnings: Vec::new() };
    Ok((reader, found.unwrap_or(none)))
}

impl Recorder {
    /// Makes the folder, writes `scene.toml` and the first row and frame.
    ///
    /// # Errors
    /// If the folder or a file in it cannot be written.
    pub fn create(folder: &Path, simulation: &mut Simulation) -> output::Result<Self> {
        let run = RunId::new();
        let files = match simulation.network().rank() {
            0 => Files::create(folder, run, &simulation.scene).map(Some),
            _ => Ok(None),
        };
        let files = together::agree(simulation.network(), files)?;
        let mut recorder = Self::new(folder, run, simulation, files);
        recorder.row(simulation, true)?;
        recorder.frame(simulation)?;
        recorder.due = usize::from(simulation.scene.output.frames > 0);
        Ok(recorder)
    }

    /// Goes on in a folder from a checkpoint; what its files hold of later steps is dropped. Says what was not as it
    /// should be.
    ///
    /// # Errors
    /// If a file in the folder cannot be written.
    pub fn resume(
        folder: &Path,
        simulation: &mut Simulation,
        head: &Head,
        found: &checkpoint::Found,
    ) -> output::Result<(Self, Vec<String>)> {
        // what a run leaves at its end is dropped, if now it does not end there
        let dropped = head.recorded.last.map(|last| last && !simulation.finished());
        let files = match simulation.network().rank() {
            0 => Files::resume(folder, &simulation.scene, head, dropped, &found.damaged).map(Some),
            _ => Ok(None),
        };
        let (files, warnings) = together::agree(simulation.network(), files)?.unzip();
        let warnings = warnings.unwrap_or_default();
        let mut recorder = Self::new(folder, head.recorded.run, simulation, files);
        recorder.watch = Watch::after(&head.recorded.warnings);
        recorder.warnings.clone_from(&head.recorded.warnings);
        for words in found.warnings.iter().chain(&warnings) {
            if recorder.warnings.iter().all(|(_, said)| said != words) {
                recorder.warnings.push(("restart".into(), words.clone()));
            }
        }
        recorder.told = recorder.warnings.len();
        let frames = head.recorded.frames.saturating_sub(dropped[1].into());
        recorder.before = Recorded { frames, ..head.recorded.clone() };
        recorder.last = [0, 1].map(|i| head.recorded.last[i] && !dropped[i]);
        let every = due::frame_interval(&simulation.scene);
        let same = head.recorded.due > 0 && due::stored_frame_interval(&head.scene) == Some(every);
        let due = (head.recorded.due as usize).saturating_sub(dropped[1].into());
        recorder.due = if same { due } else { due::after(head.time, every) };
        Ok((recorder, warnings))
    }

    fn new(folder: &Path, run: RunId, simulation: &Simulation, files: Option<Files>) -> Self {
        let checkpoints = Checkpoints::begin(simulation.clock().time, &simulation.scene.output.checkpoint);
        let (folder, began, before) = (folder.to_owned(), Instant::now(), Recorded::default());
        Self {
            folder,
            run,
            claim: None,
            files,
            due: 0,
            time: simulation.clock().time,
            checkpoints,
            last: [false; 2],
            began,
            before,
            output_s: 0.0,
            watch: Watch::default(),
            backup: Backup::new(),
            warnings: Vec::new(),
            told: 0,
        }
    }

    /// From now on this writes only while the folder is this process's, which rank 0 claimed.
    pub fn guard(&mut self, claim: Option<Rc<Claim>>) {
        self.claim = claim;
    }

    /// Whether the folder is still this process's.
    fn hold(&self) -> output::Result<()> {
        let untouched = || self.files.as_ref().is_some_and(|files| files.history.is_in_place());
        self.claim.as_ref().map_or(Ok(()), |claim| claim.hold(untouched))
    }

    /// After a step: a row, a frame and a checkpoint, if they are due. A run that is `interrupted` on any rank gets a
    /// checkpoint and stops.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn step(&mut self, simulation: &mut Simulation, interrupted: bool) -> output::Result<Next> {
        let finished = simulation.finished();
        let time = simulation.clock().time;
        let between = [std::mem::replace(&mut self.time, time), time];
        let Due { row, probes, frame, extra } =
            Due::after(simulation.steps(), between, self.due, &simulation.scene);
        if row || finished {
            self.row(simulation, row)?;
        } else if !probes.is_empty() {
            self.probes(simulation, &probes)?;
        }
        if frame || extra || finished {
            self.frame(simulation)?;
            self.due += usize::from(frame || !extra);
        }
        let frames = simulation.scene.output.frames > 0;
        self.last = [finished && !row, finished && !frame && !extra && frames];
        let wanted = simulation.scene.output.checkpoint;
        let steps = simulation.steps();
        let by_step = self.checkpoints.by_step(steps, time, finished, &wanted);
        let by_clock = simulation.network().rank() == 0 && self.checkpoints.by_clock(&wanted);
        let keep = simulation.network().rank() == 0 && self.backup.is_due(simulation);
        // one message for all: whom a signal reached, and what clock and memory of rank 0 say
        let mut wishes = [interrupted, by_clock, keep].map(u64::from);
        collective::sum(simulation.network(), &mut wishes)?;
        let stop = wishes[0] > 0 && !finished;
        if by_step || wishes[1] > 0 || stop {
            self.checkpoint(simulation)?;
        } else if wishes[2] > 0 && !finished {
            let recorded = self.recorded();
            self.backup.keep(simulation, recorded)?;
        }
        Ok(if stop { Next::Stop } else { Next::Go })
    }

    /// A row; one that does not stay is there only because the run ends, and a run that goes further knows nothing of it.
    fn row(&mut self, simulation: &mut Simulation, stays: bool) -> output::Result<()> {
        let began = simulation.begin_output();
        let report = if stays { simulation.report()? } else { simulation.peek()? };
        let written = self.files.as_mut().map_or(Ok(()), |files| files.history.row(&rows::cells(&report)));
        together::agree(simulation.network(), written)?;
        self.warnings.extend(self.watch.look(simulation, &report)?);
        if stays {
            simulation.mark_row();
        }
        self.output_s += simulation.end_output(&began);
        Ok(())
    }

    /// A row with some probes alone.
    fn probes(&mut self, simulation: &mut Simulation, numbers: &[usize]) -> output::Result<()> {
        let began = simulation.begin_output();
        let values = simulation.probes()?;
        let (clock, step) = (simulation.clock(), simulation.steps());
        // the columns with which rows begin
        let first = [clock.time.into(), step.into(), clock.tick.into()];
        let last = rows::probe_cells(&simulation.scene, &values, numbers);
        let written = self.files.as_mut().map_or(Ok(()), |files| files.history.row_of_ends(&first, &last));
        together::agree(simulation.network(), written)?;
        self.output_s += simulation.end_output(&began);
        Ok(())
    }

    fn frame(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        if simulation.scene.output.frames == 0 {
            return Ok(());
        }
        let began = simulation.begin_output();
        let held = self.hold();
        let writer = self.files.as_mut().and_then(|files| files.particles.as_mut());
        let written = write_frame(writer, simulation, held);
        together::agree(simulation.network(), written)?;
        self.output_s += simulation.end_output(&began);
        Ok(())
    }

    fn checkpoint(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        let began = simulation.begin_output();
        // what a checkpoint counts on must be on the disk before it
        let held = self.hold();
        let synced = held.and_then(|()| self.files.as_mut().map_or(Ok(()), Files::sync));
        together::agree(simulation.network(), synced)?;
        simulation.write_checkpoint(&self.folder, self.recorded())?;
        let kept = simulation.scene.output.checkpoint.kept;
        let pruned = self.files.as_ref().map_or(Ok(()), |_| checkpoint::prune(&self.folder, kept));
        together::agree(simulation.network(), pruned)?;
        let took = simulation.end_output(&began);
        self.checkpoints.written(took);
        self.output_s += took;
        Ok(())
    }

    /// How far the files have come.
    fn recorded(&self) -> Recorded {
        let writer = self.files.as_ref().and_then(|files| files.particles.as_ref());
        Recorded {
            run: self.run,
            // those of a run that wants no more stay
            frames: writer.map_or(self.before.frames, vtkhdf::Writer::frames),
            due: self.due as u64,
            last: self.last,
            wall_s: self.wall_s(),
            output_s: self.before.output_s + self.output_s,
            history: self.files.as_ref().map_or([0; 2], |files| files.history.digests()),
            warnings: self.warnings.clone(),
        }
    }

    /// Looks at a run that has failed: its last numbers may say why. All ranks call it.
    pub fn look(&mut self, simulation: &mut Simulation) {
        // best effort: the error that matters is the one that ended the run
        if let Ok(report) = simulation.peek()
            && let Ok(news) = self.watch.look(simulation, &report)
        {
            self.warnings.extend(news);
        }
    }

    /// Warnings that were not asked for before.
    pub fn warnings(&mut self) -> impl Iterator<Item = &str> {
        let told = std::mem::replace(&mut self.told, self.warnings.len());
        self.warnings[told..].iter().map(|(_, words)| words.as_str())
    }

    /// Seconds that a checkpoint takes, if one was written.
    pub fn checkpoint_s(&self) -> Option<f64> {
        self.checkpoints.took
    }

    /// Seconds on the clock, with those before a restart.
    fn wall_s(&self) -> f64 {
        self.before.wall_s + self.began.elapsed().as_secs_f64()
    }

    /// Closes all files and writes `summary.json`. A run that failed leaves one more frame, if that can be written.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn finish(mut self, simulation: &mut Simulation, end: End) -> output::Result<Summary> {
        together::agree(simulation.network(), self.hold())?;
        let (status, error) = match end {
            End::Completed => (Status::Completed, None),
            End::Interrupted => (Status::Interrupted, None),
            End::Failed(error) => {
                // the error that matters is the one that ended the run
                let backup = std::mem::replace(&mut self.backup, Backup::new());
                let _ = backup.write(&self.folder, simulation);
                let _ = self.frame(simulation);
                (Status::Failed, Some(error))
            }
        };
        let synced = self.files.as_mut().map_or(Ok(()), Files::sync);
        together::agree(simulation.network(), synced)?;
        let wall_s = self.wall_s();
        let stepping_s = wall_s - self.output_s - self.before.output_s;
        let timing = simulation.timing(self.began.elapsed().as_secs_f64())?;
        let warnings = std::mem::take(&mut self.warnings).into_iter().map(|(_, words)| words).collect();
        let ending = Ending { run: self.run, status, error, warnings, wall_s, stepping_s, timing };
        let summary = summarize::summarize(simulation, ending)?;
        let path = self.folder.join(files::SUMMARY);
        let written = self.files.map_or(Ok(()), |_| summary.write(&path));
        together::agree(simulation.network(), written)?;
        Ok(summary)
    }
}

/// Writes a frame on rank 0 (the one with the writer), from pieces of all ranks, if the folder is `held`.
fn write_frame(
    mut writer: Option<&mut vtkhdf::Writer>,
    simulation: &mut Simulation,
    held: output::Result<()>,
) -> output::Result<()> {
    let (time, step) = (simulation.clock().time, simulation.steps());
    let mine = simulation.warehouse.particle_count();
    let rank = simulation.network().rank();
    let counts = collective::share(simulation.network(), &[mine as u64])?;
    let total = |ranks: &[Vec<u64>]| ranks.iter().map(|count| count[0] as usize).sum();
    let (row, particles) = (total(&counts[..rank]), total(&counts));
    let Simulation { scene, warehouse, network, .. } = simulation;
    let snapshot = super::Snapshot::new(scene, warehouse);
    let head = frame::Head { time, step, particles, columns: snapshot.columns() };
    let mut written = held.and_then(|()| writer.as_mut().map_or(Ok(()), |writer| writer.begin(head)));
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
