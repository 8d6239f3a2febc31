//! The files of a run, on the rank that has them.
use super::{due, rows};
use crate::output::checkpoint::{self, Head};
use crate::output::claim::LOCK;
use crate::output::create::{remove, set_aside, write_whole};
use crate::output::history::{History, Table};
use crate::output::run_id::RunId;
use crate::output::{self, draft, space, vtkhdf};
use scene::Scene;
use std::path::{Path, PathBuf};

/// Bytes beside those of the files that are there.
const ROOM: usize = 1 << 15;
const SCENE: &str = "scene.toml";
const HISTORY: &str = "history.csv";
const PARTICLES: &str = vtkhdf::INDEX;
/// The file that a run writes at its end.
pub const SUMMARY: &str = "summary.json";
/// The files of a run, but for checkpoints and frames.
const FILES: [&str; 4] = [HISTORY, SUMMARY, PARTICLES, SCENE];

/// What shows a run in its folder, and would show another one there.
const SHOWN: [&str; 3] = ["section.png", "exit.png", "trace.json"];

/// What a folder holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Held {
    /// Nothing of a run.
    Nothing,
    /// A scene that no run left there.
    Scene,
    /// A run, or a part of one.
    Run,
}

/// What a folder holds. Links count, whatever they point to.
pub fn held(folder: &Path) -> Held {
    let there = |file: &&&str| std::fs::symlink_metadata(folder.join(file)).is_ok();
    let checkpoints = || !checkpoint::list(folder).is_empty();
    match FILES.iter().find(there) {
        Some(&SCENE) if !checkpoints() => Held::Scene,
        None if !checkpoints() => Held::Nothing,
        _ => Held::Run,
    }
}

/// Whether a file is there that a run has left: what a user asks for must not replace it.
pub fn is_result(path: &Path) -> bool {
    // as links lead to it
    let real = path.canonicalize().unwrap_or_default();
    let (Some(folder), Some(name)) = (real.parent(), real.file_name()) else { return false };
    let checkpoints = checkpoint::list(folder);
    let ours = FILES.iter().chain(&[LOCK]).any(|file| *file == name) || checkpoints.contains(&real);
    // others call a table of theirs so, too
    let others = FILES.iter().filter(|file| **file != name && folder.join(file).exists()).count();
    let frame = || folder.parent().is_some_and(|run| held(run) == Held::Run && vtkhdf::is_frame(run, &real));
    ours && others + checkpoints.len() > 0 || frame()
}

/// The open ones.
pub struct Files {
    /// Rows in time.
    pub history: History,
    /// The index of frames, if the scene wants any, until somebody takes it.
    pub particles: Option<vtkhdf::Writer>,
}

impl Files {
    /// New ones. Those of an earlier run are deleted.
    ///
    /// # Errors
    /// If the folder or a file in it cannot be written.
    pub fn create(folder: &Path, run: RunId, scene: &Scene) -> output::Result<Self> {
        let cannot = |source| output::Error::Io { action: "create", path: folder.into(), source };
        std::fs::create_dir_all(folder).map_err(cannot)?;
        // the scene first: alone, after a kill, it would pass for somebody's
        let files = FILES.iter().rev().chain(&SHOWN).map(|file| folder.join(file));
        for file in files.chain(checkpoint::list(folder)) {
            remove(&file)?;
        }
        let index = folder.join(PARTICLES);
        vtkhdf::remove_frames(&index)?;
        // a folder with a scene and no history holds somebody's scene: see `Held::Scene`
        let history = History::create(&folder.join(HISTORY), &rows::columns(scene))?;
        write_whole(&folder.join(SCENE), scene.resolved.as_bytes())?;
        let particles = match scene.output.frames {
            0 => None,
            _ => Some(vtkhdf::Writer::create(&index, run)?),
        };
        Ok(Self { history, particles })
    }

    /// Those of a run that goes on from a checkpoint: what they hold of later steps is dropped, and, if `dropped` says so, the
    /// last row and the last frame before. Says what was not as
    /// it should be.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn resume(
        folder: &Path,
        scene: &Scene,
        head: &Head,
        dropped: [bool; 2],
        damaged: &[PathBuf],
    ) -> output::Result<(Self, Vec<String>)> {
        let (index, mut warnings) = (folder.join(PARTICLES), Vec::new());
        // what is refused is refused before anything is changed
        vtkhdf::refuse_link(&index)?;
        writable(folder)?;
        let frames = due::frames_kept(&head.recorded, dropped);
        let found = match scene.output.frames {
            0 => None,
            _ => Some(vtkhdf::Found::look(&index, head.recorded.run, frames)?),
        };
        let end = if dropped[0] { head.time.next_down() } else { head.time };
        let history = resume_history(&folder.join(HISTORY), scene, end, &mut warnings)?;
        let wanted = head.recorded.history[usize::from(!dropped[0])];
        if warnings.is_empty() && history.digests()[1] != wanted {
            warnings.push(other_rows(&folder.join(HISTORY), head));
        }
        checkpoint::set_aside(folder, damaged)?;
        write_whole(&folder.join(SCENE), scene.resolved.as_bytes())?;
        let particles = match found {
            None => None,
            Some(found) => {
                let (writer, problems) = vtkhdf::Writer::resume(&index, found)?;
                warnings.extend(problems);
                Some(writer)
            }
        };
        remove(&folder.join(SUMMARY))?;
        Ok((Self { history, particles }, warnings))
    }
}

/// Whether the files of a run can be written, and there is room for what a restart writes anew.
fn writable(folder: &Path) -> output::Result<()> {
    let files = FILES.map(|file| folder.join(file));
    if let Some(path) = files.iter().find(|file| file.is_dir()) {
        let problem = "it is a folder, where a run writes a file: move it away".into();
        return Err(output::Error::Content { path: path.clone(), problem });
    }
    let size = |path: &PathBuf| std::fs::metadata(path).map_or(0, |found| found.len()) as usize;
    let bytes = files.iter().map(size).sum::<usize>() + ROOM;
    space::probe(&draft::aside(&folder.join(HISTORY)), bytes)
}

/// What is wrong with rows until a checkpoint that are not those of the run.
fn other_rows(path: &Path, head: &Head) -> String {
    let steps = Table::read(path).ok().and_then(|table| table.column("step")).unwrap_or_default();
    let every = due::stored_history_every(&head.scene).unwrap_or(1).max(1);
    let (first, last) = (*steps.first().unwrap_or(&f64::NAN), *steps.last().unwrap_or(&f64::NAN));
    let in_order = first == 0.0 && steps.is_sorted_by(|a, b| a < b);
    let problem = if in_order && last >= (head.steps - head.steps % every) as f64 {
        "its rows until the checkpoint are not those that this run has written: they were changed, or are another run's".into()
    } else {
        let step = head.steps;
        format!(
            "rows are missing or not in order: it has steps {first} to {last}, where the checkpoint is of step {step}"
        )
    };
    format!("{}: {problem}", path.display())
}

/// The history until a time [s]; a damaged one is set aside.
fn resume_history(
    path: &Path,
    scene: &Scene,
    end: f64,
    warnings: &mut Vec<String>,
) -> output::Result<History> {
    let columns = rows::columns(scene);
    let problem = match std::fs::symlink_metadata(path) {
        Err(_) => format!("{} is missing", path.display()),
        Ok(_) => match History::resume(path, &columns, end) {
            Err(output::Error::Content { .. }) => {
                format!("{} is damaged, and now {}", path.display(), set_aside(path)?.display())
            }
            history => return history,
        },
    };
    warnings.push(format!("{problem}: it begins anew"));
    History::create(path, &columns)
}
