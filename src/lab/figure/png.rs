//! Figures as pixels: images, and all else over them.
use super::{Color, Figure, Mark, ink};

/// An image of pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Pixels across and down.
    pub size: [usize; 2],
    /// Row by row from the upper left; sRGB.
    pub pixels: Vec<Color>,
}

/// The most pixels that a figure may have: a poster of a square meter at 200 dpi. While it is drawn each takes some twenty bytes.
pub const MOST: f64 = 6.5e7;

impl Figure {
    /// Pixels across and down at so many an inch.
    ///
    /// # Errors
    /// If these are more than a picture can have.
    pub fn pixels(&self, dpi: f64) -> Result<[usize; 2], String> {
        let size = self.size.map(|mm| (mm / 25.4 * dpi).round().max(1.0));
        if size[0] * size[1] > MOST {
            let [w, h] = size;
            return Err(format!("{w} x {h} pixels are too many for a picture: ask for fewer dpi"));
        }
        Ok(size.map(|x| x as usize))
    }

    /// Draws the figure on white.
    ///
    /// # Errors
    /// If it is too large.
    pub fn rasterize(&self, dpi: f64) -> Result<Raster, String> {
        let [width, height] = self.pixels(dpi)?;
        let mut pixmap =
            tiny_skia::Pixmap::new(width as u32, height as u32).ok_or("no memory for the picture")?;
        pixmap.fill(tiny_skia::Color::WHITE);
        for mark in &self.marks {
            if let Mark::Image { at, size, raster } = mark {
                paint(&mut pixmap, at.map(|mm| mm / 25.4 * dpi), size.map(|mm| mm / 25.4 * dpi), raster);
            }
        }
        let [x, y] = [width as f64 / self.size[0], height as f64 / self.size[1]];
        let scale = tiny_skia::Transform::from_scale(x as f32, y as f32);
        self.marks.iter().for_each(|mark| ink::draw(&mut pixmap, mark, scale));
        let pixels = pixmap.pixels().iter().map(|p| [p.red(), p.green(), p.blue()]).collect();
        Ok(Raster { size: [width, height], pixels })
    }
}

/// Copies an image to a box of the picture, pixel by pixel where sizes agree.
fn paint(pixmap: &mut tiny_skia::Pixmap, at: [f64; 2], size: [f64; 2], raster: &Raster) {
    let (width, height) = (pixmap.width() as usize, pixmap.height() as usize);
    let [left, top] = at.map(|x| x.round().max(0.0) as usize);
    let [w, h] = size.map(|x| x.round().max(0.0) as usize);
    for y in 0..h.min(height.saturating_sub(top)) {
        for x in 0..w.min(width.saturating_sub(left)) {
            let from = [x * raster.size[0] / w, y * raster.size[1] / h];
            let [r, g, b] = raster.pixels[from[0] + raster.size[0] * from[1]];
            let color = tiny_skia::ColorU8::from_rgba(r, g, b, 255).premultiply();
            pixmap.pixels_mut()[left + x + width * (top + y)] = color;
        }
    }
}

impl Raster {
    /// White.
    pub fn new(size: [usize; 2]) -> Self {
        Self { size, pixels: vec![[255; 3]; size[0] * size[1]] }
    }

    /// As a PNG file that says how many pixels an inch has; 0: it does not.
    ///
    /// # Errors
    /// If it has no pixels.
    pub fn to_png(&self, dpi: f64) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let mut animation = Animation::begin(&mut bytes, self.size, dpi, None)?;
        animation.add(self)?;
        animation.end()?;
        Ok(bytes)
    }
}

/// A PNG that moves, in the making.
pub struct Animation<W: std::io::Write>(png::Writer<W>);

impl<W: std::io::Write> Animation<W> {
    /// Begins a picture, or a film of so many pictures and so many a second.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin(out: W, size: [usize; 2], dpi: f64, film: Option<(u32, u16)>) -> Result<Self, String> {
        let mut encoder = png::Encoder::new(out, size[0] as u32, size[1] as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        if dpi > 0.0 {
            let meter = (dpi / 0.0254).round() as u32;
            let unit = png::Unit::Meter;
            encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: meter, yppu: meter, unit }));
        }
        let say = |error: png::EncodingError| error.to_string();
        if let Some((frames, rate)) = film {
            encoder.set_animated(frames, 0).map_err(say)?;
            encoder.set_frame_delay(1, rate).map_err(say)?;
        }
        encoder.write_header().map(Self).map_err(say)
    }

    /// The next picture.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add(&mut self, raster: &Raster) -> Result<(), String> {
        self.0.write_image_data(raster.pixels.as_flattened()).map_err(|error| error.to_string())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn end(self) -> Result<(), String> {
        self.0.finish().map_err(|error| error.to_string())
    }
}
