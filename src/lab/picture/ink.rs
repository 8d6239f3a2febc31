//! Which color a particle has, and what the legend says about it.
use super::legend::{Legend, Named};
use super::span::Span;
use crate::lab::figure::Color;
use crate::lab::figure::axis::Quantity;
use crate::lab::figure::colors::{self, PLAIN, TOOL};
use crate::lab::wound::{code, scalars};
use crate::output::frame::{Field, Frame, part_names};
use scene::Scene;

/// What colors mean.
#[derive(Clone, Debug, PartialEq)]
pub enum Coloring {
    /// Kind of failure; what knows none has the color of its material.
    Failure,
    /// The particle's material.
    Material,
    /// A field of the frames: its name, and which of its numbers.
    Field(String, Part),
}

/// A number of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The only one.
    Value,
    /// The length of a vector.
    Length,
    /// One of several.
    Of(usize),
}

/// Colors of the kinds of failure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Palette {
    /// Apart for every eye.
    #[default]
    Apart,
    /// Those of the paper.
    Paper,
}

impl Palette {
    fn colors(self) -> [Color; 4] {
        match self {
            Self::Apart => colors::FAILURE,
            Self::Paper => colors::FAILURE_OF_THE_PAPER,
        }
    }
}

const KINDS: [&str; 4] = ["intact", "matrix failed", "fibers failed", "both failed"];

impl Coloring {
    /// Failure if the frame knows it, else speed if it knows that, else the material.
    pub fn of(frame: &dyn Frame) -> Self {
        if scalars(frame, "failure").is_some_and(|f| f.iter().any(|f| f.is_finite())) {
            return Self::Failure;
        }
        match frame.fields().iter().any(|f| f.name == "velocity") {
            true => Self::Field("velocity".to_owned(), Part::Length),
            false => Self::Material,
        }
    }

    /// By its name: `failure`, `material`, `speed`, a field of the frames, or a part of it such as `stress.xx`.
    ///
    /// # Errors
    /// What frames have, if they do not have it.
    pub fn named(name: &str, fields: &[Field]) -> Result<Self, String> {
        let (whole, part) = name.split_once('.').map_or((name, None), |(whole, part)| (whole, Some(part)));
        let whole = if whole == "speed" { "velocity" } else { whole };
        if name == "material" {
            return Ok(Self::Material);
        }
        let Some(field) = fields.iter().find(|field| field.name == whole) else {
            let there: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
            return Err(format!(
                "the frames have no field {name:?}: they have material, {}; output.fields of a scene says what a run shows",
                there.join(", ")
            ));
        };
        let names = part_names(field.components);
        match (part, field.components) {
            (None, 1) if name == "failure" => Ok(Self::Failure),
            (None, 1) => Ok(Self::Field(whole.to_owned(), Part::Value)),
            (None, 3) => Ok(Self::Field(whole.to_owned(), Part::Length)),
            (Some(part), 2..) if names.contains(&part) => {
                let which = names.iter().position(|name| *name == part).unwrap_or(0);
                Ok(Self::Field(whole.to_owned(), Part::Of(which)))
            }
            (_, 1) => Err(format!("{whole} is one number: it has no part {:?}", part.unwrap_or_default())),
            _ => {
                let all: Vec<String> = names.iter().map(|part| format!("{whole}.{part}")).collect();
                Err(format!("{whole} has several numbers: name one of {}", all.join(", ")))
            }
        }
    }

    /// The number of each particle, in the order of the frame; NaN for those without one.
    fn values(&self, frame: &dyn Frame) -> Vec<f64> {
        let Self::Field(name, part) = self else { return Vec::new() };
        let found = frame.fields().into_iter().find(|field| field.name == *name);
        let Some(field) = found else { return vec![f64::NAN; frame.particles()] };
        let number = |numbers: &[f32]| match part {
            Part::Value => f64::from(numbers[0]),
            Part::Length => numbers.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>().sqrt(),
            Part::Of(which) => f64::from(numbers[*which]),
        };
        frame.column(&field).chunks_exact(field.components.max(1)).map(number).collect()
    }

    /// From where to where the numbers of a frame go that are shown.
    pub fn span(&self, frame: &dyn Frame, shown: impl Iterator<Item = usize>) -> Span {
        let values = self.values(frame);
        let numbers = shown.filter_map(|i| values.get(i).copied()).filter(|x| x.is_finite());
        Span::of(numbers.collect())
    }

    /// What the colors show, in words and a unit.
    pub fn quantity(&self, fields: &[Field]) -> Quantity {
        let Self::Field(name, part) = self else { return Quantity::default() };
        let field = fields.iter().find(|field| field.name == *name);
        let unit = field.map_or("", |field| field.unit.as_str());
        let words = match (name.as_str(), part) {
            ("velocity", Part::Length) => "speed".to_owned(),
            ("von_mises", _) => "von Mises stress".to_owned(),
            ("volume_ratio", _) => "volume ratio J".to_owned(),
            (name, Part::Of(which)) => {
                let parts = part_names(field.map_or(1, |field| field.components));
                format!("{} {}", name.replace('_', " "), parts.get(*which).unwrap_or(&""))
            }
            (name, _) => name.replace('_', " "),
        };
        Quantity { words, unit: if unit == "1" { String::new() } else { unit.replace("^3", "³") } }
    }
}

/// Colors of all particles, in the order of the frame, and the legend for those that are `shown`. `span` is that of all frames of
/// the picture.
pub fn ink(
    frame: &dyn Frame,
    scene: &Scene,
    coloring: &Coloring,
    (span, palette): (Span, Palette),
    shown: impl Fn(usize) -> bool,
) -> (Vec<Color>, Legend) {
    let material = |m: usize| colors::MATERIALS[m % colors::MATERIALS.len()];
    let materials = frame.materials();
    let name = |m: usize| scene.materials.get(m).map_or(String::new(), |it| it.name.clone());
    // those that show nothing, by name
    let without = |has: &dyn Fn(usize) -> bool| {
        let mut others: Vec<u16> =
            (0..materials.len()).filter(|&i| !has(i) && shown(i)).map(|i| materials[i]).collect();
        others.sort_unstable();
        others.dedup();
        let names: Vec<String> = others.iter().map(|m| name(usize::from(*m))).collect();
        let mut legend: Vec<Named> = Vec::new();
        legend.extend((!names.is_empty()).then(|| (PLAIN, names.join(", "))));
        let tools = scene.materials.iter().filter(|it| !it.has_particles());
        legend.extend(tools.map(|it| (TOOL, it.name.clone())));
        legend
    };
    match coloring {
        Coloring::Failure => {
            let failure = scalars(frame, "failure").unwrap_or_default();
            let kind = |i: usize| {
                failure.get(i).filter(|f| f.is_finite()).map(|f| (f.round() as u8).min(code::TOTAL))
            };
            let kinds = palette.colors();
            let color = |i: usize| kind(i).map_or(PLAIN, |kind| kinds[usize::from(kind)]);
            let mut legend: Vec<(Color, String)> = kinds.into_iter().zip(KINDS.map(str::to_owned)).collect();
            legend.extend(without(&|i| kind(i).is_some()));
            ((0..frame.particles()).map(color).collect(), Legend::Kinds(legend))
        }
        Coloring::Material => {
            let legend = (0..scene.materials.len()).map(|m| (material(m), name(m))).collect();
            (materials.iter().map(|&m| material(m.into())).collect(), Legend::Kinds(legend))
        }
        Coloring::Field(..) => {
            let (span, map) = span.rounded();
            let color = |x: f64| match x.is_finite() {
                true => map.at((x - span.low) / (span.high - span.low)),
                false => PLAIN,
            };
            let values = coloring.values(frame);
            let mut others = without(&|i| values.get(i).is_some_and(|x| x.is_finite()));
            let plain = others.iter_mut().filter(|(color, _)| *color == PLAIN);
            plain.for_each(|(_, name)| *name = format!("no value: {name}"));
            let colors = values.iter().map(|x| color(*x)).collect();
            (colors, Legend::Bar(map, span, coloring.quantity(&frame.fields()), others))
        }
    }
}
