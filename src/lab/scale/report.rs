//! All that `sinew scale` found, and its files.
use super::model::{Cluster, Costs};
use super::row::Row;
use super::series::Point;
use super::table;
use super::torus::Brick;
use super::validate::Check;
use crate::lab::figure::axis::Quantity;
use crate::lab::plot::{Line, Plot};
use crate::output::Result;
use crate::output::create::write_whole;
use crate::output::error::io;
use serde::Serialize;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// All that was measured and predicted.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Report {
    /// Name of the scene.
    pub scene: String,
    /// Processor of this machine.
    pub machine: String,
    /// Whether the cells shrink with the number of workers in what was measured.
    pub weak: bool,
    /// Steps that count, and repetitions.
    pub steps: u64,
    /// Repetitions, of which the best counts.
    pub repeat: usize,
    /// What was measured.
    pub rows: Vec<Row>,
    /// Whether all rows end in the same state.
    pub same_state: Option<bool>,
    /// Costs of work on this machine.
    pub costs: Option<Costs>,
    /// Messages between ranks on this machine, as the model of it has them.
    pub here: Option<Cluster>,
    /// The model against what was measured.
    pub checks: Vec<Check>,
    /// The cluster of the predictions.
    pub cluster: Option<Cluster>,
    /// Threads a rank in the predictions.
    pub threads: usize,
    /// Bytes that each rank gives to the reduction of a step.
    pub reduced_bytes: f64,
    /// What each worker has in the weak prediction.
    pub brick: Option<Brick>,
    /// Strong prediction.
    pub strong: Vec<Point>,
    /// Weak prediction.
    pub weak_points: Vec<Point>,
}

impl Report {
    /// Writes tables, plots and everything as JSON into a folder; returns their paths.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        fs::create_dir_all(folder).map_err(io("create", folder))?;
        let mut files = Vec::new();
        let mut file = |name: &str, text: String| -> Result<()> {
            let path = folder.join(name);
            write_whole(&path, text.as_bytes())?;
            files.push(path);
            Ok(())
        };
        if self.rows.iter().any(|row| row.error.is_none()) {
            file("efficiency.svg", svg(&self.efficiency()))?;
            file("time.svg", svg(&self.time()))?;
            file("patches.svg", svg(&self.patches()))?;
        }
        if !self.rows.is_empty() {
            file("measured.csv", table::csv(&self.rows))?;
        }
        if !self.weak_points.is_empty() {
            file("predicted.csv", table::predicted_csv(&self.strong, &self.weak_points))?;
            file("prediction.svg", svg(&self.prediction()))?;
        }
        let text = serde_json::to_string_pretty(self).unwrap_or_default();
        file("scale.json", text + "\n")?;
        Ok(files)
    }

    /// The best row of each number of workers, ranks or threads.
    fn best(&self, of: impl Fn(&Row) -> bool, value: impl Fn(&Row) -> f64) -> Vec<[f64; 2]> {
        let rows = || self.rows.iter().filter(|row| row.error.is_none() && of(row));
        let workers: BTreeSet<usize> = rows().map(Row::workers).collect();
        let quickest = |&workers: &usize| {
            let rows = rows().filter(|row| row.workers() == workers);
            let row = rows.max_by(|a, b| a.updates_per_s.total_cmp(&b.updates_per_s))?;
            Some([workers as f64, value(row)])
        };
        workers.iter().filter_map(quickest).collect()
    }

    /// A line for threads on one rank, and one for ranks of one thread.
    fn by_workers(&self, value: impl Fn(&Row) -> f64) -> Vec<Line> {
        let line = |name: &str, points| Line { name: name.to_owned(), points };
        let lines = [
            line("threads on one rank", self.best(|row| row.ranks == 1, &value)),
            line("ranks of one thread", self.best(|row| row.threads == 1, &value)),
        ];
        lines.into_iter().filter(|line| !line.points.is_empty()).collect()
    }

    fn efficiency(&self) -> Plot {
        let kind = if self.weak { "weak" } else { "strong" };
        Plot {
            title: format!("{}: {kind} scaling, measured", self.scene),
            axes: ["workers", "parallel efficiency"].map(Quantity::plain),
            log: [true, false],
            marks: true,
            lines: self.by_workers(|row| row.efficiency),
        }
    }

    fn time(&self) -> Plot {
        Plot {
            title: format!("{}: time of a step, measured", self.scene),
            axes: ["workers", "ms a step"].map(Quantity::plain),
            log: [true, true],
            marks: true,
            lines: self.by_workers(|row| row.step_ms[0]),
        }
    }

    fn patches(&self) -> Plot {
        let ok = || self.rows.iter().filter(|row| row.error.is_none());
        let groups: BTreeSet<(usize, usize)> = ok().map(|row| (row.ranks, row.threads)).collect();
        let line = |&(ranks, threads): &(usize, usize)| {
            let rows = ok().filter(|row| (row.ranks, row.threads) == (ranks, threads));
            let mut points: Vec<[f64; 2]> =
                rows.map(|row| [row.patches as f64, row.over_decomposition]).collect();
            points.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let name = format!("{ranks} rank{}, {threads} thread{}", plural(ranks), plural(threads));
            Line { name, points }
        };
        Plot {
            title: format!("{}: what more patches cost", self.scene),
            axes: ["patches", "time over that with the fewest, less one"].map(Quantity::plain),
            log: [true, false],
            marks: true,
            lines: groups.iter().map(line).collect(),
        }
    }

    fn prediction(&self) -> Plot {
        let line = |name: &str, points: &[Point]| Line {
            name: name.to_owned(),
            points: points.iter().map(|point| [point.ranks as f64, point.efficiency]).collect(),
        };
        Plot {
            title: format!("{}: efficiency, predicted", self.scene),
            axes: ["ranks", "parallel efficiency"].map(Quantity::plain),
            log: [true, false],
            marks: true,
            lines: vec![line("strong", &self.strong), line("weak", &self.weak_points)],
        }
    }
}

/// Plots are as wide as a page.
fn svg(plot: &Plot) -> String {
    // what has no images cannot fail
    plot.draw(140.0).to_svg().unwrap_or_default()
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}
