//! The folder of a run: scene, history, frames, checkpoints and summary. All ranks call what is here, rank 0 alone has
//! the files but for frames.
mod backup;
mod due;
mod files;
mod frames;
mod rows;
mod seen;
mod summarize;

use super::Simulation;
use super::watch::{Said, Watch};
use crate::output::checkpoint::{self, Head, Recorded};
use crate::output::claim::Claim;
use crate::output::run_id::RunId;
use crate::output::summary::{Status, Summary};
use crate::output::vtkhdf::INDEX;
use crate::output::{self, together};
use backup::Backup;
use due::{Checkpoints, Due};
use engine::exec::ranks::collective;
use files::Files;
pub use files::{Held, held, is_result};
use frames::Frames;
pub use seen::last_checkpoint;
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
    /// If the scene wants any.
    frames: Option<Frames>,
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

impl Recorder {
    /// Makes the folder, writes `scene.toml` and the first row and frame.
    ///
    /// # Errors
    /// If the folder or a file in it cannot be written.
    pub fn create(folder: &Path, simulation: &mut Simulation) -> output::Result<Self> {
        let run = RunId::common(simulation.network())?;
        let files = match simulation.network().rank() {
            0 => Files::create(folder, run, &simulation.scene).map(Some),
            _ => Ok(None),
        };
        let files = together::agree(simulation.network(), files)?;
        let mut recorder = Self::new(folder, run, simulation, files, 0)?;
        recorder.row(simulation, true)?;
        recorder.frame(simulation)?;
        // what cannot be written is told before the first step
        recorder.settle(simulation)?;
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
        let frames = due::frames_kept(&head.recorded, dropped);
        let mut recorder = Self::new(folder, head.recorded.run, simulation, files, frames)?;
        recorder.watch = Watch::after(&head.recorded.warnings);
        recorder.warnings.clone_from(&head.recorded.warnings);
        for words in found.warnings.iter().chain(&warnings) {
            if recorder.warnings.iter().all(|(_, said)| said != words) {
                recorder.warnings.push(("restart".into(), words.clone()));
            }
        }
        recorder.told = recorder.warnings.len();
        recorder.before = Recorded { frames, ..head.recorded.clone() };
        recorder.last = [0, 1].map(|i| head.recorded.last[i] && !dropped[i]);
        let every = due::frame_interval(&simulation.scene);
        let same = head.recorded.due > 0 && due::stored_frame_interval(&head.scene) == Some(every);
        let due = (head.recorded.due as usize).saturating_sub(dropped[1].into());
        recorder.due = if same { due } else { due::after(head.time, every) };
        Ok((recorder, warnings))
    }

    /// `next` is the number of the next frame.
    fn new(
        folder: &Path,
        run: RunId,
        simulation: &mut Simulation,
        mut files: Option<Files>,
        next: u64,
    ) -> output::Result<Self> {
        let checkpoints = Checkpoints::begin(simulation.clock().time, &simulation.scene.output.checkpoint);
        let (folder, began, before) = (folder.to_owned(), Instant::now(), Recorded::default());
        let writer = files.as_mut().and_then(|files| files.particles.take());
        let frames = match simulation.scene.output.frames {
            0 => None,
            _ => Some(Frames::new(simulation.network(), &folder.join(INDEX), run, next, writer)?),
        };
        Ok(Self {
            folder,
            run,
            claim: None,
            files,
            frames,
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
        })
    }

    /// From now on this writes only while the folder is this process's, which rank 0 claimed.
    pub fn guard(&mut self, claim: Option<Rc<Claim>>) {
        self.claim = claim;
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
        let written = self.frames.as_ref().is_some_and(Frames::is_done);
        // one message for all: whom a signal reached, what clock and memory of rank 0 say, and who has written its part of a frame
        let mut wishes = [interrupted, by_clock, keep, written].map(u64::from);
        collective::sum(simulation.network(), &mut wishes)?;
        if wishes[3] == simulation.network().size() as u64 {
            self.of_frames(simulation, |frames, simulation, held| {
                frames.advance(simulation.network(), held)
            })?;
        }
        let stop = wishes[0] > 0 && !finished;
        if by_step || wishes[1] > 0 || stop {
            self.checkpoint(simulation)?;
        } else if wishes[2] > 0 && !finished {
            let recorded = self.recorded();
            self.backup.keep(simulation, recorded)?;
        }
        if finished {
            self.settle(simulation)?;
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

    /// Begins a frame.
    fn frame(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        self.of_frames(simulation, Frames::begin)
    }

    /// Waits until all frames are written.
    fn settle(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        self.of_frames(simulation, |frames, simulation, held| frames.settle(simulation.network(), held))
    }

    /// Does something about frames, if there are any, which takes time of output.
    fn of_frames(&mut self, simulation: &mut Simulation, act: Act) -> output::Result<()> {
        let Some(frames) = &mut self.frames else { return Ok(()) };
        let began = simulation.begin_output();
        let done = act(frames, simulation, &|| hold(&self.claim, &self.files));
        self.output_s += simulation.end_output(&began);
        done
    }

    /// Waits until the disk has all that was written.
    fn sync(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        let held = || hold(&self.claim, &self.files);
        if let Some(frames) = &mut self.frames {
            frames.sync(simulation.network(), &held)?;
        }
        let history = self.files.as_mut().map_or(Ok(()), |files| files.history.sync());
        together::agree(simulation.network(), history)
    }

    fn checkpoint(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        let began = simulation.begin_output();
        // what a checkpoint counts on must be on the disk before it
        together::agree(simulation.network(), hold(&self.claim, &self.files))?;
        self.sync(simulation)?;
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
        Recorded {
            run: self.run,
            // those of a run that wants no more stay
            frames: self.frames.as_ref().map_or(self.before.frames, Frames::begun),
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
        together::agree(simulation.network(), hold(&self.claim, &self.files))?;
        let (status, error) = match end {
            End::Completed => (Status::Completed, None),
            End::Interrupted => (Status::Interrupted, None),
            End::Failed(error) => {
                // the error that matters is the one that ended the run
                let _ = self.settle(simulation);
                let backup = std::mem::replace(&mut self.backup, Backup::new());
                // a frame that was on its way when the state was kept may be the one that failed
                let there = |recorded: &Recorded| {
                    self.frames.as_ref().is_none_or(|frames| frames.has(recorded.frames))
                };
                let _ = backup.write(&self.folder, simulation, there);
                if !self.frames.as_ref().is_some_and(|frames| frames.shows(simulation.steps())) {
                    let _ = self.frame(simulation).and_then(|()| self.settle(simulation));
                }
                (Status::Failed, Some(error))
            }
        };
        let synced = self.sync(simulation);
        if error.is_none() {
            synced?;
        }
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

/// Something about frames, if the folder is held.
type Act = fn(&mut Frames, &mut Simulation, &dyn Fn() -> output::Result<()>) -> output::Result<()>;

/// Whether the folder is still this process's.
fn hold(claim: &Option<Rc<Claim>>, files: &Option<Files>) -> output::Result<()> {
    let untouched = || files.as_ref().is_some_and(|files| files.history.is_in_place());
    claim.as_ref().map_or(Ok(()), |claim| claim.hold(untouched))
}
