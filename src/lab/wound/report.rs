//! The wound as numbers, as a table beside the paper's, and as JSON.
use super::{Ellipse, Layer, Scale, Tissue, code};
use crate::lab::figure::axis::Quantity;
use crate::lab::plot::{Line, Plot};
use serde::Serialize;
use std::fmt;

/// Where the projectile is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "state", rename_all = "snake_case")]
pub enum Passage {
    /// The frame holds no projectile.
    Gone,
    /// Before the slab.
    Before {
        /// Depth of its tip [m].
        tip_m: f64,
    },
    /// In the slab.
    Inside {
        /// Depth of its tip [m].
        tip_m: f64,
        /// Depth of its tail [m].
        tail_m: f64,
    },
    /// Past the surface of exit, tail and all.
    Out {
        /// Depth of its tail [m].
        tail_m: f64,
    },
}

impl Passage {
    pub(super) fn of(depths: Option<[f64; 2]>, thickness: f64) -> Self {
        match depths {
            None => Self::Gone,
            Some([_, tip_m]) if tip_m < 0.0 => Self::Before { tip_m },
            Some([tail_m, _]) if tail_m > thickness => Self::Out { tail_m },
            Some([tail_m, tip_m]) => Self::Inside { tip_m, tail_m },
        }
    }
}

/// Particles of the target by kind of failure, over all of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Failed {
    /// Matrix only.
    pub matrix: f64,
    /// Fibers only.
    pub fiber: f64,
    /// Both, by strain.
    pub total: f64,
    /// Both, because crushed.
    pub crushed: f64,
    /// Any.
    pub any: f64,
}

/// A measured wound. What each number means is said in [`super`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Time of the frame [s].
    pub time_s: f64,
    /// Where the projectile is.
    pub passage: Passage,
    /// Whether a first frame told where particles began.
    pub starts_known: bool,
    /// Diameter of the projectile [m].
    pub caliber_m: f64,
    /// Cavity of the first layer [m].
    pub entry_m: f64,
    /// Cavity of the last layer [m].
    pub exit_m: f64,
    /// Least and greatest cavity of all layers [m].
    pub cavity_m: [f64; 2],
    /// The same of cavity and failed layer [m].
    pub failed_layer_m: [f64; 2],
    /// The same of the failed reach [m].
    pub failed_reach_m: [f64; 2],
    /// Growth of the cavity's diameter with depth [m/m].
    pub taper: f64,
    /// Shape of the exit.
    pub exit_cavity: Option<Ellipse>,
    /// Shape of the failed tissue in the last layer.
    pub exit_failed: Option<Ellipse>,
    /// By kind.
    pub failed_fraction: Failed,
    /// Target particles no longer part of the slab, over all.
    pub loose_fraction: f64,
    /// Target particles that left the domain.
    pub missing: usize,
    /// From entry to exit.
    pub layers: Vec<Layer>,
}

impl Report {
    /// Diameters over the depth.
    pub fn plot(&self, title: &str) -> Plot {
        let line = |name: &str, diameter: fn(&Layer) -> f64| Line {
            name: name.to_owned(),
            points: self.layers.iter().map(|layer| [layer.depth_m, diameter(layer)]).collect(),
        };
        Plot {
            title: title.to_owned(),
            axes: ["depth from the surface of entry", "diameter"]
                .map(|words| Quantity { words: words.into(), unit: "m".into() }),
            log: [false; 2],
            marks: true,
            lines: vec![
                line("cavity", |layer| layer.cavity_m),
                line("cavity and failed layer", |layer| layer.failed_layer_m),
                line("failed reach", |layer| layer.failed_reach_m),
            ],
        }
    }

    pub(super) fn of(tissue: &Tissue, attached: &[bool], layers: Vec<Layer>, scale: Scale) -> Self {
        let share = |n: usize| n as f64 / tissue.failure.len().max(1) as f64;
        let fraction = |kind: u8| share(tissue.failure.iter().filter(|&&f| f == kind).count());
        let failed_fraction = Failed {
            matrix: fraction(code::MATRIX),
            fiber: fraction(code::FIBER),
            total: fraction(code::TOTAL),
            crushed: fraction(code::INVERTED),
            any: 1.0 - fraction(code::NONE),
        };
        let (first, last) = (layers.first(), layers.last());
        Self {
            time_s: 0.0,
            passage: Passage::Gone,
            starts_known: true,
            caliber_m: scale.caliber,
            entry_m: first.map_or(0.0, |l| l.cavity_m),
            exit_m: last.map_or(0.0, |l| l.cavity_m),
            cavity_m: range(&layers, |l| l.cavity_m),
            failed_layer_m: range(&layers, |l| l.failed_layer_m),
            failed_reach_m: range(&layers, |l| l.failed_reach_m),
            taper: slope(&layers),
            exit_cavity: last.and_then(|l| l.cavity),
            exit_failed: last.and_then(|l| l.failed),
            failed_fraction,
            loose_fraction: share(attached.iter().filter(|&&attached| !attached).count()),
            missing: 0,
            layers,
        }
    }

    /// Everything, for other programs.
    pub fn json(&self) -> serde_json::Value {
        // A struct of numbers always has a JSON form; NaN becomes null.
        serde_json::to_value(self).unwrap_or_default()
    }

    /// What a reader must know before the numbers.
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        match self.passage {
            Passage::Before { tip_m } => {
                notes.push(format!("The projectile has not reached the slab: its tip is {} before it.", mm(-tip_m)));
            }
            Passage::Inside { tip_m, tail_m } => notes.push(format!(
                "The projectile has not left: tip at depth {}, tail at {}. Exit and cavity will still change.",
                mm(tip_m),
                mm(tail_m)
            )),
            Passage::Gone => notes.push("The frame holds no projectile.".into()),
            Passage::Out { .. } => {}
        }
        if !self.starts_known {
            notes.push("Without a first frame, layers are made of where particles are now.".into());
        }
        if self.failed_fraction.any == 0.0 {
            notes.push("Nothing failed.".into());
        }
        if self.missing > 0 {
            notes.push(format!("{} particles left the domain and are in no number.", self.missing));
        }
        notes
    }
}

/// The table that people read.
impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "Wound at {:.4} ms", self.time_s * 1e3)?;
        self.notes().iter().try_for_each(|note| writeln!(f, "{note}"))?;
        let ellipse =
            |e: Option<Ellipse>| e.map_or("-".into(), |e| format!("{:.2} at {:.0}°", e.ratio, e.angle_deg));
        let failed = self.failed_fraction;
        let percent = |x: f64| format!("{:.2} %", 100.0 * x);
        let rows = [
            ("entry diameter", mm(self.entry_m), "10-11 mm", "10-11 mm"),
            ("exit diameter", mm(self.exit_m), "", ""),
            ("cavity over depth", span(self.cavity_m), "16-19 mm", "smaller"),
            ("cavity + failed layer", span(self.failed_layer_m), "29-38 mm", ""),
            ("cavity + failed reach", span(self.failed_reach_m), "(the same)", ""),
            ("taper (diameter/depth)", format!("{:.3}", self.taper), "grows", "less"),
            ("exit: axes ratio", ellipse(self.exit_cavity), "elliptical", "almost round"),
            ("exit: failed, axes ratio", ellipse(self.exit_failed), "elliptical", "almost round"),
            ("failed", percent(failed.any), "about 5 %", "about 5 %"),
            ("  matrix only", percent(failed.matrix), "", ""),
            ("  fiber only", percent(failed.fiber), "", ""),
            ("  total", percent(failed.total), "", ""),
            ("  crushed", percent(failed.crushed), "", ""),
            ("loose", percent(self.loose_fraction), "", ""),
        ];
        writeln!(f, "\n{:26}{:>18}{:>18}{:>18}", "", "this run", "paper, 50 m/s", "paper, 150 m/s")?;
        for (name, value, slow, fast) in rows {
            writeln!(f, "{}", format!("{name:26}{value:>18}{slow:>18}{fast:>18}").trim_end())?;
        }
        let heads = ["depth", "cavity", "+ layer", "+ reach", "ratio", "failed"];
        writeln!(f, "\n{}", heads.map(|h| format!("{h:>11}")).concat())?;
        for l in &self.layers {
            let ratio = l.cavity.map_or("-".into(), |e| format!("{:.2}", e.ratio));
            let cells = [mm(l.depth_m), mm(l.cavity_m), mm(l.failed_layer_m), mm(l.failed_reach_m), ratio];
            write!(f, "{}", cells.map(|c| format!("{c:>11}")).concat())?;
            writeln!(f, "{:>11}", percent(l.failed_fraction))?;
        }
        Ok(())
    }
}

fn mm(x: f64) -> String {
    format!("{:.2} mm", 1e3 * x)
}

fn span([low, high]: [f64; 2]) -> String {
    format!("{:.1}-{:.1} mm", 1e3 * low, 1e3 * high)
}

fn range(layers: &[Layer], of: impl Fn(&Layer) -> f64) -> [f64; 2] {
    let low = layers.iter().map(&of).min_by(f64::total_cmp).unwrap_or(0.0);
    [low, layers.iter().map(&of).max_by(f64::total_cmp).unwrap_or(0.0)]
}

/// Least squares of cavity against depth; 0 for a single layer.
fn slope(layers: &[Layer]) -> f64 {
    let n = layers.len() as f64;
    let mean = |of: &dyn Fn(&Layer) -> f64| layers.iter().map(of).sum::<f64>() / n;
    let (depth, cavity) = (mean(&|l| l.depth_m), mean(&|l| l.cavity_m));
    let spread = mean(&|l| (l.depth_m - depth).powi(2));
    if spread > 0.0 { mean(&|l| (l.depth_m - depth) * (l.cavity_m - cavity)) / spread } else { 0.0 }
}
