//! The plotting layer: figures of lines, marks, images and text, in millimeters, as SVG with real text or as PNG.
//!
//! History, scaling, wounds and pictures of particles are all drawn with it.
pub mod axis;
pub mod colors;
pub mod font;
mod ink;
mod png;
mod svg;

pub use colors::Color;
pub use font::{Anchor, Type};
pub use png::{Animation, MOST, Raster};

use crate::output::create::write_whole;
use crate::output::error::{Error, Result};
use std::path::Path;

/// Millimeters a typographic point.
pub const POINT: f64 = 25.4 / 72.0;

/// A part of a figure. Lengths are in millimeters, from the upper left corner, y downwards.
#[derive(Clone, Debug)]
pub enum Mark {
    /// A line through points.
    Line {
        /// The points.
        points: Vec<[f64; 2]>,
        /// Its color.
        color: Color,
        /// Its width.
        width: f64,
        /// Lengths of dashes and gaps; none: drawn through.
        dashes: &'static [f64],
    },
    /// A filled polygon.
    Area {
        /// Its corners.
        points: Vec<[f64; 2]>,
        /// Its color.
        color: Color,
    },
    /// A disc.
    Disc {
        /// Its center.
        center: [f64; 2],
        /// Its radius.
        radius: f64,
        /// Its color.
        color: Color,
    },
    /// A line of text.
    Text {
        /// Where it begins, has its middle or ends, on the line that letters stand on.
        at: [f64; 2],
        /// What it says.
        text: String,
        /// How.
        font: Type,
    },
    /// Pixels.
    Image {
        /// The upper left corner.
        at: [f64; 2],
        /// Width and height.
        size: [f64; 2],
        /// What is on it.
        raster: Raster,
    },
}

/// A figure.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Width and height [mm].
    pub size: [f64; 2],
    /// In the order in which they are drawn.
    pub marks: Vec<Mark>,
}

/// How a figure is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Pixels.
    Png,
    /// Lines and real text; particles are pixels in it.
    Svg,
}

impl Format {
    /// That of a file name.
    ///
    /// # Errors
    /// If it ends with neither `.png` nor `.svg`.
    pub fn of(path: &Path) -> std::result::Result<Self, String> {
        match path.extension().and_then(|end| end.to_str()).map(str::to_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("svg") => Ok(Self::Svg),
            _ => Err(format!("{}: a figure is a .png or a .svg file", path.display())),
        }
    }
}

impl Figure {
    /// An empty figure of a width and a height [mm].
    pub fn new(size: [f64; 2]) -> Self {
        Self { size, marks: Vec::new() }
    }

    /// Adds a thin line.
    pub fn line(&mut self, points: &[[f64; 2]], color: Color, width: f64) {
        self.marks.push(Mark::Line { points: points.to_vec(), color, width, dashes: &[] });
    }

    /// Adds a box from corner to corner.
    pub fn fill(&mut self, low: [f64; 2], high: [f64; 2], color: Color) {
        let points = vec![low, [high[0], low[1]], high, [low[0], high[1]]];
        self.marks.push(Mark::Area { points, color });
    }

    /// Adds the edges of a box.
    pub fn frame(&mut self, low: [f64; 2], high: [f64; 2], color: Color, width: f64) {
        self.line(&[low, [high[0], low[1]], high, [low[0], high[1]], low], color, width);
    }

    /// Adds a line of text.
    pub fn text(&mut self, at: [f64; 2], text: impl Into<String>, font: Type) {
        self.marks.push(Mark::Text { at, text: text.into(), font });
    }

    /// Adds another figure, with its corner at a place.
    pub fn place(&mut self, other: Figure, corner: [f64; 2]) {
        let moved = |p: &mut [f64; 2]| *p = [p[0] + corner[0], p[1] + corner[1]];
        self.marks.extend(other.marks.into_iter().map(|mut mark| {
            match &mut mark {
                Mark::Line { points, .. } | Mark::Area { points, .. } => points.iter_mut().for_each(moved),
                Mark::Disc { center: at, .. } | Mark::Text { at, .. } | Mark::Image { at, .. } => moved(at),
            }
            mark
        }));
    }

    /// Figures above one another.
    pub fn stack(figures: Vec<Figure>) -> Figure {
        let width = figures.iter().map(|figure| figure.size[0]).fold(0.0, f64::max);
        let mut all = Figure::new([width, 0.0]);
        for figure in figures {
            let below = all.size[1];
            all.size[1] += figure.size[1];
            all.place(figure, [0.0, below]);
        }
        all
    }

    /// Writes the figure; `dpi` is the number of pixels an inch of a PNG.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path, format: Format, dpi: f64) -> Result<()> {
        write_whole(path, &self.encode(path, format, dpi)?)
    }

    /// The bytes of a file at `path`, which errors name.
    ///
    /// # Errors
    /// If the figure cannot be drawn.
    pub fn encode(&self, path: &Path, format: Format, dpi: f64) -> Result<Vec<u8>> {
        let wrong = |problem| Error::Content { path: path.into(), problem };
        match format {
            Format::Svg => self.to_svg().map(String::into_bytes).map_err(wrong),
            Format::Png => self.rasterize(dpi).and_then(|raster| raster.to_png(dpi)).map_err(wrong),
        }
    }
}
