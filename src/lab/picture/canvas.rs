//! Pixels: anti-aliased discs, strokes and boxes over white.
use crate::output::create::create;
use crate::output::error::{Error, Result, io};
use std::io::BufWriter;
use std::ops::Range;
use std::path::Path;

/// sRGB.
pub type Color = [u8; 3];

/// An image in the making.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<Color>,
    /// How near to the viewer the ball in each pixel is [pixels].
    nearness: Vec<f64>,
}

impl Canvas {
    /// White.
    pub fn new(width: usize, height: usize) -> Self {
        let nearness = vec![f64::NEG_INFINITY; width * height];
        Self { width, height, pixels: vec![[255; 3]; width * height], nearness }
    }

    /// Pixels across and down.
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Color of a pixel; white outside.
    pub fn pixel(&self, x: usize, y: usize) -> Color {
        if x < self.width && y < self.height { self.pixels[x + self.width * y] } else { [255; 3] }
    }

    /// A ball `near` pixels before the page, lit from the upper left. Balls cut each other as spheres do, so
    /// neighbors look the same in whatever order they are drawn.
    pub fn ball(&mut self, center: [f64; 2], near: f64, radius: f64, color: Color) {
        let [across, down] = self.clip(&bounds(center, center, radius));
        for (y, x) in down.flat_map(|y| across.clone().map(move |x| (y, x))) {
            let [u, v] = [x as f64 + 0.5 - center[0], y as f64 + 0.5 - center[1]];
            let (square, cell) = ((u * u + v * v) / (radius * radius), x + self.width * y);
            let height = near + radius * (1.0 - square).max(0.0).sqrt();
            let cover = radius + 0.5 - u.hypot(v);
            if cover <= 0.0 || height < self.nearness[cell] {
                continue;
            }
            let light = 1.08 - 0.21 * (u + v) / radius - 0.19 * square;
            self.pixels[cell] = mix(self.pixels[cell], shade(color, light), cover);
            if cover > 0.5 {
                self.nearness[cell] = height;
            }
        }
    }

    /// A straight stroke with round ends.
    pub fn stroke(&mut self, from: [f64; 2], to: [f64; 2], radius: f64, color: Color) {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length2 = along[0].powi(2) + along[1].powi(2);
        self.paint(bounds(from, to, radius), |x, y| {
            let [u, v] = [x - from[0], y - from[1]];
            let s =
                if length2 > 0.0 { ((u * along[0] + v * along[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
            (radius + 0.5 - (u - s * along[0]).hypot(v - s * along[1]), color)
        });
    }

    /// A box from corner to corner; `color` may depend on the place along x, 0 to 1.
    pub fn fill(&mut self, low: [f64; 2], high: [f64; 2], color: impl Fn(f64) -> Color) {
        self.paint([low[0]..high[0], low[1]..high[1]], |x, _| {
            (1.0, color((x - low[0]) / (high[0] - low[0])))
        });
    }

    /// Blends `ink(x, y)` = (cover, color) over the pixels of a region.
    fn paint(&mut self, region: [Range<f64>; 2], ink: impl Fn(f64, f64) -> (f64, Color)) {
        let [across, down] = self.clip(&region);
        for (y, x) in down.flat_map(|y| across.clone().map(move |x| (y, x))) {
            let (cover, color) = ink(x as f64 + 0.5, y as f64 + 0.5);
            let pixel = &mut self.pixels[x + self.width * y];
            *pixel = mix(*pixel, color, cover);
        }
    }

    /// The pixels of a region that are on the canvas.
    fn clip(&self, region: &[Range<f64>; 2]) -> [Range<usize>; 2] {
        let on = |r: &Range<f64>, size| {
            r.start.floor().max(0.0) as usize..(r.end.ceil().max(0.0) as usize).min(size)
        };
        [on(&region[0], self.width), on(&region[1], self.height)]
    }

    /// Writes a PNG.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let file = create(path)?;
        let mut encoder = png::Encoder::new(BufWriter::new(file), self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(self.pixels.as_flattened())?;
            writer.finish()
        });
        written.map_err(|error| match error {
            png::EncodingError::IoError(source) => io("write", path)(source),
            other => {
                Error::Content { path: path.into(), problem: format!("cannot encode the picture ({other})") }
            }
        })
    }
}

/// Between two colors: `t` = 0 the first, 1 the second.
pub fn mix(a: Color, b: Color, t: f64) -> Color {
    let t = t.clamp(0.0, 1.0);
    [0, 1, 2].map(|c| (f64::from(a[c]) + t * (f64::from(b[c]) - f64::from(a[c]))).round() as u8)
}

/// Darker below 1, towards white above.
pub fn shade(color: Color, light: f64) -> Color {
    if light <= 1.0 { mix([0; 3], color, light) } else { mix(color, [255; 3], light - 1.0) }
}

fn bounds(a: [f64; 2], b: [f64; 2], radius: f64) -> [Range<f64>; 2] {
    [0, 1].map(|c| a[c].min(b[c]) - radius - 0.5..a[c].max(b[c]) + radius + 0.5)
}
