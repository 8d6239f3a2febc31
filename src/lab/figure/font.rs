//! Type: Inter, which is part of Sinew, so that a figure looks the same on every machine.
use super::{Color, POINT};
use std::sync::LazyLock;
use tiny_skia::PathBuilder;
use ttf_parser::{Face, OutlineBuilder};

/// Where a text is put.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// It begins there.
    Start,
    /// Its middle is there.
    Middle,
    /// It ends there.
    End,
}

/// How a text looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Type {
    /// Size [points].
    pub size: f64,
    /// Its color.
    pub color: Color,
    /// Whether it is semi-bold.
    pub bold: bool,
    /// Which part of it is where it is put.
    pub anchor: Anchor,
    /// Whether it runs upwards.
    pub upright: bool,
}

impl Type {
    /// Dark text of a size [points] that begins where it is put.
    pub const fn new(size: f64) -> Self {
        Self { size, color: [40, 44, 52], bold: false, anchor: Anchor::Start, upright: false }
    }

    /// The same, semi-bold.
    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// The same in another color.
    pub const fn color(self, color: Color) -> Self {
        Self { color, ..self }
    }

    /// The same, put elsewhere.
    pub const fn anchor(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// The same, upwards.
    pub const fn upright(self) -> Self {
        Self { upright: true, ..self }
    }

    /// From line to line [mm].
    pub fn line_height(&self) -> f64 {
        1.35 * self.size * POINT
    }

    /// How long a text is [mm].
    pub fn width(&self, text: &str) -> f64 {
        text.chars().map(|letter| self.face().advance(letter)).sum::<f64>() * self.size * POINT
    }

    fn face(&self) -> &'static Font {
        &FONTS[usize::from(self.bold)]
    }

    /// The outlines of a text that is put at a place [mm]. What the font does not have is blank.
    pub fn outlines(&self, text: &str, [x, y]: [f64; 2]) -> Option<tiny_skia::Path> {
        let before = match self.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -0.5 * self.width(text),
            Anchor::End => -self.width(text),
        };
        let Font(Some(face)) = self.face() else { return None };
        let size = self.size * POINT;
        let scale = size / f64::from(face.units_per_em());
        let mut pen =
            Pen { path: PathBuilder::new(), scale, at: [x, y], along: before, upright: self.upright };
        for letter in text.chars() {
            if let Some(glyph) = face.glyph_index(letter) {
                face.outline_glyph(glyph, &mut pen);
            }
            pen.along += size * self.face().advance(letter);
        }
        pen.path.finish()
    }

    /// A text in lines no longer than `room` [mm], cut between words, and in words that are longer.
    pub fn wrap(&self, text: &str, room: f64) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace().flat_map(|word| self.pieces(word, room)) {
            let word = word.as_str();
            match lines.last_mut() {
                Some(line) if self.width(line) + self.width(" ") + self.width(word) <= room => {
                    line.push(' ');
                    line.push_str(word);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }

    /// A word in pieces no longer than `room` [mm], of a letter at the least.
    fn pieces(&self, word: &str, room: f64) -> Vec<String> {
        let mut pieces = vec![String::new()];
        for letter in word.chars() {
            let last = pieces.len() - 1;
            let mut longer = pieces[last].clone();
            longer.push(letter);
            match self.width(&longer) > room && !pieces[last].is_empty() {
                true => pieces.push(letter.to_string()),
                false => pieces[last] = longer,
            }
        }
        pieces
    }
}

const FILES: [&[u8]; 2] =
    [include_bytes!("fonts/Inter-Regular.otf"), include_bytes!("fonts/Inter-SemiBold.otf")];

/// A font, if it can be read.
struct Font(Option<Face<'static>>);

/// Regular and semi-bold.
static FONTS: LazyLock<[Font; 2]> = LazyLock::new(|| FILES.map(|file| Font(Face::parse(file, 0).ok())));

impl Font {
    /// The width of a letter in parts of the size; half of it for what the font does not have.
    fn advance(&self, letter: char) -> f64 {
        let Some(face) = &self.0 else { return 0.5 };
        let units = face.glyph_index(letter).and_then(|glyph| face.glyph_hor_advance(glyph));
        units.map_or(0.5, |units| f64::from(units) / f64::from(face.units_per_em()))
    }
}

/// Draws letters from units of the font to a place.
struct Pen {
    path: PathBuilder,
    /// Of a unit of the font [mm].
    scale: f64,
    /// Where the text is put [mm].
    at: [f64; 2],
    /// How far along the text the letter begins [mm].
    along: f64,
    upright: bool,
}

impl Pen {
    fn place(&self, x: f32, y: f32) -> [f32; 2] {
        let (u, v) = (self.along + f64::from(x) * self.scale, f64::from(y) * self.scale);
        let [x, y] = if self.upright { [-v, -u] } else { [u, -v] };
        [(self.at[0] + x) as f32, (self.at[1] + y) as f32]
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.place(x, y);
        self.path.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.place(x, y);
        self.path.line_to(x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ([x1, y1], [x, y]) = (self.place(x1, y1), self.place(x, y));
        self.path.quad_to(x1, y1, x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ([x1, y1], [x2, y2], [x, y]) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }
    fn close(&mut self) {
        self.path.close();
    }
}

/// The name of the font, and what takes its place where it is not.
pub const FAMILY: &str = "Inter, 'Helvetica Neue', Helvetica, Arial, sans-serif";
