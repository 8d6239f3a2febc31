//! Which color a particle has, and what the legend says about it.
use super::canvas::{Color, mix};
use crate::lab::wound::{code, scalars};
use crate::output::frame::Frame;
use scene::Scene;

/// What colors mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coloring {
    /// Kind of failure; what knows none is gray to magenta by plastic strain.
    Failure,
    /// Magnitude of the velocity.
    Speed,
    /// The particle's material.
    Material,
}

impl Coloring {
    /// Failure if the frame knows it, else speed if it knows that, else the material.
    pub fn of(frame: &dyn Frame) -> Self {
        if scalars(frame, "failure").is_some_and(|f| f.iter().any(|f| f.is_finite())) {
            return Self::Failure;
        }
        if frame.fields().iter().any(|f| f.name == "velocity") { Self::Speed } else { Self::Material }
    }
}

/// An entry of the legend.
#[derive(Clone, Debug)]
pub enum LegendEntry {
    /// A color and what it means.
    Ball(Color, String),
    /// Colors from 0 to a number, what it is and its unit.
    Bar(fn(f64) -> Color, f64, &'static str),
}

/// Colors of all particles, in the order of the frame.
#[derive(Debug)]
pub struct Ink {
    pub colors: Vec<Color>,
    pub legend: Vec<LegendEntry>,
}

/// As the paper's figures 8 to 10: none, matrix, fiber, total.
const FAILURE: [(Color, &str); 4] = [
    ([88, 132, 204], "intact"),
    ([58, 172, 92], "matrix failed"),
    ([246, 200, 52], "fiber failed"),
    ([212, 52, 44], "both failed"),
];
/// Distinct also for the color blind (Okabe and Ito), muted.
const MATERIALS: [Color; 6] =
    [[204, 121, 110], [110, 118, 130], [86, 160, 211], [230, 170, 60], [60, 158, 130], [180, 130, 180]];

impl Ink {
    pub fn new(frame: &dyn Frame, scene: &Scene, coloring: Coloring) -> Self {
        match coloring {
            Coloring::Failure => Self::failure(frame),
            Coloring::Speed => Self::speed(frame),
            Coloring::Material => Self::material(frame, scene),
        }
    }

    fn failure(frame: &dyn Frame) -> Self {
        let failure = scalars(frame, "failure").unwrap_or_default();
        let plastic = scalars(frame, "plastic_strain").unwrap_or_default();
        let plastic = |i: usize| plastic.get(i).copied().filter(|p| p.is_finite());
        let knows = |i: usize| failure.get(i).is_some_and(|f| f.is_finite());
        let metal: Vec<_> = (0..frame.particles()).filter(|&i| !knows(i)).collect();
        let most = metal.iter().filter_map(|&i| plastic(i)).fold(0.0, f32::max);
        let top = round_up(f64::from(most).max(0.01));
        let color = |i: usize| match failure.get(i) {
            Some(f) if f.is_finite() => FAILURE[usize::from((f.round() as u8).min(code::TOTAL))].0,
            _ => yielding(f64::from(plastic(i).unwrap_or(0.0)) / top),
        };
        let mut legend: Vec<_> = FAILURE.iter().map(|&(c, text)| LegendEntry::Ball(c, text.into())).collect();
        if !metal.is_empty() {
            legend.push(LegendEntry::Bar(yielding, top, "plastic strain"));
        }
        Self { colors: (0..frame.particles()).map(color).collect(), legend }
    }

    fn speed(frame: &dyn Frame) -> Self {
        let field = frame.fields().into_iter().find(|f| f.name == "velocity" && f.components == 3);
        let column = field.map(|f| frame.column(&f)).unwrap_or_default();
        let speed = |v: &[f32; 3]| f64::from(v.iter().map(|x| x * x).sum::<f32>().sqrt());
        let mut speeds: Vec<f64> = column.as_chunks().0.iter().map(speed).collect();
        speeds.resize(frame.particles(), 0.0);
        let top = round_up(speeds.iter().copied().filter(|s| s.is_finite()).fold(1e-9, f64::max));
        let colors = speeds.iter().map(|s| heat(s / top)).collect();
        Self { colors, legend: vec![LegendEntry::Bar(heat, top, "m/s")] }
    }

    fn material(frame: &dyn Frame, scene: &Scene) -> Self {
        let color = |m: usize| MATERIALS[m % MATERIALS.len()];
        let names = scene.materials.iter().enumerate();
        Self {
            colors: frame.materials().iter().map(|&m| color(m.into())).collect(),
            legend: names.map(|(m, material)| LegendEntry::Ball(color(m), material.name.clone())).collect(),
        }
    }
}

/// Gray metal that turns magenta as it yields.
fn yielding(t: f64) -> Color {
    along(&[[128, 134, 142], [170, 110, 160], [222, 30, 150]], t)
}

/// Dark blue over green to yellow (the idea of viridis).
fn heat(t: f64) -> Color {
    along(&[[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]], t)
}

fn along(stops: &[Color], t: f64) -> Color {
    let s = t.clamp(0.0, 1.0) * (stops.len() - 1) as f64;
    let k = (s as usize).min(stops.len() - 2);
    mix(stops[k], stops[k + 1], s - k as f64)
}

/// The next 1, 2 or 5 times a power of ten.
pub fn round_up(x: f64) -> f64 {
    let power = 10f64.powf(x.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|&y| y >= x * (1.0 - 1e-9)).unwrap_or(x)
}
