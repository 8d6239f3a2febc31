//! Balls as pixels, anti-aliased, over white.
use crate::lab::figure::colors::{mix, shade};
use crate::lab::figure::{Color, Raster};
use std::ops::Range;

/// An image in the making.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    raster: Raster,
    /// How near to the viewer the ball in each pixel is [pixels].
    nearness: Vec<f64>,
}

impl Canvas {
    /// White.
    pub fn new(size: [usize; 2]) -> Self {
        Self { raster: Raster::new(size), nearness: vec![f64::NEG_INFINITY; size[0] * size[1]] }
    }

    /// What is on it.
    pub fn into_raster(self) -> Raster {
        self.raster
    }

    /// A ball `near` pixels before the page, lit from the upper left. Balls cut each other as spheres do, so
    /// neighbors look the same in whatever order they are drawn.
    pub fn ball(&mut self, center: [f64; 2], near: f64, radius: f64, color: Color) {
        let [across, down] = self.clip(center, radius + 0.5);
        for (y, x) in down.flat_map(|y| across.clone().map(move |x| (y, x))) {
            let [u, v] = [x as f64 + 0.5 - center[0], y as f64 + 0.5 - center[1]];
            let (square, cell) = ((u * u + v * v) / (radius * radius), x + self.raster.size[0] * y);
            let height = near + radius * (1.0 - square).max(0.0).sqrt();
            let cover = radius + 0.5 - u.hypot(v);
            if cover <= 0.0 || height < self.nearness[cell] {
                continue;
            }
            let light = 1.08 - 0.21 * (u + v) / radius - 0.19 * square;
            let pixel = &mut self.raster.pixels[cell];
            *pixel = mix(*pixel, shade(color, light), cover);
            if cover > 0.5 {
                self.nearness[cell] = height;
            }
        }
    }

    /// The pixels of a square that are on the canvas.
    fn clip(&self, center: [f64; 2], half: f64) -> [Range<usize>; 2] {
        [0, 1].map(|a| {
            let (start, end) = ((center[a] - half).floor().max(0.0), (center[a] + half).ceil().max(0.0));
            start as usize..(end as usize).min(self.raster.size[a])
        })
    }
}
