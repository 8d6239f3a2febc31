//! What a shot through a slab leaves: hole, failed tissue around it, and how both change with depth.
//!
//! Coordinates of the shot: depth from the surface of entry along the flight, and the two other axes from the point
//! of entry. The slab is cut into *layers*: the particles that began within one interval of depth, two particle
//! spacings thick. So a layer is a sheet of tissue, also where the slab bulges; its particles are looked at along the
//! shot, where they are now. (Without the first frame, layers are made of where particles are now.)
//!
//! - **loose**: no longer part of the slab: outside the largest connected body of target particles (cubes of two
//!   spacings, face to face), or failed and moved farther than the caliber. Loose particles fill no cavity.
//! - **cavity**: in a layer, the largest connected opening that touches the projectile's disc around the axis; an
//!   opening is where no attached particle is nearer than 1.5 spacings, grown by one spacing, so that its edge is
//!   half a spacing from the centers of the particles that bound it. Diameter: of the circle of equal area.
//! - **failed layer**: the cavity and what is connected to it and mostly failed (at least half of the attached
//!   particles within 1.5 spacings). Ends at the first intact shell.
//! - **failed reach**: the area inside which, in each sector of 10° around the cavity, 90 % of the failed attached
//!   particles lie. Includes intact shells between failed ones.
//! - **ellipse**: principal axes of the second moments of area (cavity) or of particles (failed), their ratio ≥ 1.
//! - **taper**: growth of the cavity's diameter with depth, least squares over the layers [m/m].
mod attached;
mod layer;
mod report;

pub(crate) use attached::attached;
pub use layer::{Ellipse, Layer};
pub use report::{Failed, Passage, Report};

use crate::output::frame::Frame;
use scene::{Scene, Wound};
use std::collections::HashMap;

/// Codes in the field `failure`.
pub mod code {
    /// Intact.
    pub const NONE: u8 = 0;
    /// Matrix failed.
    pub const MATRIX: u8 = 1;
    /// Fibers failed.
    pub const FIBER: u8 = 2;
    /// Both failed.
    pub const TOTAL: u8 = 3;
    /// Both failed because the particle was crushed.
    pub const INVERTED: u8 = 4;
}

/// Why there is nothing to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unmeasured {
    /// The scene is not a shot.
    #[error("the scene has no [output.wound] section: say there what is the target and what the projectile")]
    NoSection,
    /// No particles of the target.
    #[error("the frame holds no particle of the target material")]
    NoTarget,
    /// The target can fail, and the frame does not show where.
    #[error(
        "the frames do not show `failure`, of which the table is made: add it to output.fields of the scene"
    )]
    NoFailure,
}

/// What is measured, in the coordinates of the shot: two lateral ones and the depth [m].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tissue {
    /// Where particles are.
    pub now: Vec<[f64; 3]>,
    /// Where they began.
    pub start: Vec<[f64; 3]>,
    /// How they failed: see [`code`].
    pub failure: Vec<u8>,
}

/// Sizes that measures refer to [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Thickness of the slab.
    pub thickness: f64,
    /// Distance of neighboring target particles at the start.
    pub spacing: f64,
    /// Diameter of the projectile across the shot.
    pub caliber: f64,
}

/// Measures the last frame of a run. The first frame tells where particles began.
///
/// # Errors
/// If the scene is no shot, the target has no particles, or can fail and the frame does not show it.
pub fn measure(scene: &Scene, first: Option<&dyn Frame>, last: &dyn Frame) -> Result<Report, Unmeasured> {
    let wound = scene.output.wound.as_ref().ok_or(Unmeasured::NoSection)?;
    let fails = scene.materials[wound.target].declared().history.iter().any(|kept| kept.name == "failure");
    if fails && last.fields().iter().all(|field| field.name != "failure") {
        return Err(Unmeasured::NoFailure);
    }
    let tissue = tissue(wound, first, last);
    if tissue.now.is_empty() {
        return Err(Unmeasured::NoTarget);
    }
    let spacing = spacing(scene, wound.target);
    let bullet = of_material(last, wound.projectile, wound);
    let whole = first.map_or(bullet.clone(), |first| of_material(first, wound.projectile, wound));
    let thickness = (wound.surfaces[1] - wound.surfaces[0]).abs();
    let caliber = extent(&whole, 0).map_or(thickness, |[low, high]| high - low + spacing);
    let mut report = measure_tissue(&tissue, Scale { thickness, spacing, caliber });
    report.time_s = last.time();
    report.starts_known = first.is_some();
    report.passage = Passage::of(extent(&bullet, 2), thickness);
    report.missing = first.map_or(0, |first| {
        let began = first.materials().iter().filter(|&&m| usize::from(m) == wound.target).count();
        began.saturating_sub(tissue.now.len())
    });
    Ok(report)
}

/// Measures tissue alone; see the module for what each number means.
pub fn measure_tissue(tissue: &Tissue, scale: Scale) -> Report {
    let attached = attached(tissue, 2.0 * scale.spacing, scale.caliber);
    let count = ((scale.thickness / (2.0 * scale.spacing)).round() as usize).max(1);
    let mut members = vec![Vec::new(); count];
    for (i, start) in tissue.start.iter().enumerate() {
        let k = (start[2] / scale.thickness * count as f64).max(0.0) as usize;
        members[k.min(count - 1)].push(i);
    }
    let depth = |k: usize| (k as f64 + 0.5) / count as f64 * scale.thickness;
    let layers = members
        .iter()
        .enumerate()
        .map(|(k, m)| Layer::measure(tissue, &attached, m, depth(k), scale))
        .collect();
    Report::of(tissue, &attached, layers, scale)
}

/// Mean distance of a material's particles at the start [m].
pub(crate) fn spacing(scene: &Scene, material: usize) -> f64 {
    let body = scene.bodies.iter().find(|body| body.material == material);
    let per_cell = body.map_or(8, |body| body.particles_per_cell.iter().product::<usize>().max(1));
    scene.domain.cell / (per_cell as f64).cbrt()
}

/// A point in the coordinates of the shot.
pub(crate) fn shot_coordinates(wound: &Wound, x: [f32; 3]) -> [f64; 3] {
    let x = x.map(f64::from);
    let [a, b] = lateral(wound.axis);
    [x[a] - wound.center[0], x[b] - wound.center[1], wound.direction * (x[wound.axis] - wound.surfaces[0])]
}

/// The two other axes, ascending.
pub(crate) fn lateral(axis: usize) -> [usize; 2] {
    [[1, 2], [0, 2], [0, 1]][axis.min(2)]
}

/// Values of a field of one number a particle, if the frame has it.
pub(crate) fn scalars(frame: &dyn Frame, name: &str) -> Option<Vec<f32>> {
    let field = frame.fields().into_iter().find(|f| f.name == name && f.components == 1)?;
    Some(frame.column(&field))
}

fn of_material(frame: &dyn Frame, material: usize, wound: &Wound) -> Vec<[f64; 3]> {
    let (positions, materials) = (frame.positions(), frame.materials());
    let ours = positions.iter().zip(&materials).filter(|&(_, &m)| usize::from(m) == material);
    ours.map(|(&x, _)| shot_coordinates(wound, x)).collect()
}

/// The target's particles, in the order of the last frame.
pub(crate) fn tissue(wound: &Wound, first: Option<&dyn Frame>, last: &dyn Frame) -> Tissue {
    let (positions, materials, identities) = (last.positions(), last.materials(), last.identities());
    let failure = scalars(last, "failure").unwrap_or_default();
    let began: HashMap<u64, [f32; 3]> =
        first.map(|f| f.identities().into_iter().zip(f.positions()).collect()).unwrap_or_default();
    let mut tissue = Tissue::default();
    for (i, &now) in positions.iter().enumerate() {
        if usize::from(materials[i]) != wound.target {
            continue;
        }
        let start = began.get(&identities[i]).copied().unwrap_or(now);
        tissue.now.push(shot_coordinates(wound, now));
        tissue.start.push(shot_coordinates(wound, start));
        // NaN, where a law knows no failure, becomes 0.
        tissue.failure.push(failure.get(i).map_or(code::NONE, |&f| f.round() as u8));
    }
    tissue
}

/// Least and greatest coordinate.
fn extent(points: &[[f64; 3]], axis: usize) -> Option<[f64; 2]> {
    let values = points.iter().map(|x| x[axis]);
    let low = values.clone().min_by(f64::total_cmp)?;
    Some([low, values.max_by(f64::total_cmp)?])
}
