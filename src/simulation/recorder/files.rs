//! The files of a run, on the rank that has them.
use super::rows;
use crate::output::checkpoint::{self, Head};
use crate::output::history::History;
use crate::output::{self, summary, vtkhdf};
use scene::Scene;
use std::path::{Path, PathBuf};

/// The files that make a folder a run's, but for checkpoints.
const FILES: [&str; 4] = ["scene.toml", "summary.json", "history.csv", "particles.vtkhdf"];

/// Whether a folder holds a run.
pub fn holds_run(folder: &Path) -> bool {
    FILES.iter().any(|file| folder.join(file).exists()) || !checkpoint::list(folder).is_empty()
}

/// The open ones.
pub struct Files {
    /// Rows in time.
    pub history: History,
    /// Frames, if the scene wants any.
    pub particles: Option<vtkhdf::Writer>,
}

impl Files {
    /// New ones. Those of an earlier run are deleted.
    ///
    /// # Errors
    /// If the folder or a file in it cannot be written.
    pub fn create(folder: &Path, scene: &Scene) -> output::Result<Self> {
        let cannot = |source| output::Error::Io { action: "create", path: folder.into(), source };
        std::fs::create_dir_all(folder).map_err(cannot)?;
        let files = FILES.iter().map(|file| folder.join(file)).filter(|file| file.exists());
        for file in files.chain(checkpoint::list(folder)) {
            std::fs::remove_file(&file).map_err(cannot)?;
        }
        summary::write_whole(&folder.join("scene.toml"), scene.resolved.as_bytes())?;
        let history = History::create(&folder.join("history.csv"), &rows::columns(scene))?;
        let particles = match scene.output.frames {
            0 => None,
            _ => Some(vtkhdf::Writer::create(&folder.join("particles.vtkhdf"))?),
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
        let mut warnings = Vec::new();
        checkpoint::set_aside(folder, damaged)?;
        let summary = folder.join("summary.json");
        if summary.exists() {
            std::fs::remove_file(&summary).map_err(output::io("remove", &summary))?;
        }
        summary::write_whole(&folder.join("scene.toml"), scene.resolved.as_bytes())?;
        let (path, columns) = (folder.join("history.csv"), rows::columns(scene));
        let history = match path.exists() {
            true => {
                History::resume(&path, &columns, if dropped[0] { head.time.next_down() } else { head.time })?
            }
            false => {
                warnings.push(format!("{} is missing: it begins anew", path.display()));
                History::create(&path, &columns)?
            }
        };
        let particles = match scene.output.frames {
            0 => None,
            _ => {
                let frames =
                    head.recorded.frames as usize - usize::from(dropped[1] && head.recorded.frames > 0);
                Some(resume_frames(&folder.join("particles.vtkhdf"), frames, &mut warnings)?)
            }
        };
        Ok((Self { history, particles }, warnings))
    }

    /// Waits until the disk has all that was written.
    ///
    /// # Errors
    /// If it does not take it.
    pub fn sync(&self) -> output::Result<()> {
        self.history.sync()?;
        self.particles.as_ref().map_or(Ok(()), vtkhdf::Writer::sync)
    }
}

/// The particle file; a damaged one is set aside.
fn resume_frames(path: &Path, frames: usize, warnings: &mut Vec<String>) -> output::Result<vtkhdf::Writer> {
    if !path.exists() {
        if frames > 0 {
            warnings.push(format!("{} is missing: it begins anew", path.display()));
        }
        return vtkhdf::Writer::create(path);
    }
    vtkhdf::Writer::resume(path, frames).or_else(|error| {
        let aside = path.with_added_extension("damaged");
        std::fs::rename(path, &aside).map_err(output::io("rename", path))?;
        warnings.push(format!("{error}. It is now {}, and frames begin anew", aside.display()));
        vtkhdf::Writer::create(path)
    })
}
