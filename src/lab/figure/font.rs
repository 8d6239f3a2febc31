//! Type: Inter, which is part of Sinew, so that a figure looks the same on every machine.
use super::{Color, POINT};
use resvg::usvg::fontdb;
use std::sync::{Arc, LazyLock};

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
        let advances = if self.bold { &FONTS.advances[1] } else { &FONTS.advances[0] };
        let units: f64 = text.chars().map(advances).sum();
        units * self.size * POINT
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

type Advance = Box<dyn Fn(char) -> f64 + Send + Sync>;

struct Fonts {
    database: Arc<fontdb::Database>,
    /// Widths of letters in parts of the size: regular and semi-bold.
    advances: [Advance; 2],
}

static FONTS: LazyLock<Fonts> = LazyLock::new(|| {
    let mut database = fontdb::Database::new();
    FILES.iter().for_each(|file| database.load_font_data(file.to_vec()));
    Fonts { database: Arc::new(database), advances: FILES.map(advance) }
});

/// The widths of a font's letters; half a square for what it does not have.
fn advance(file: &'static [u8]) -> Advance {
    let Ok(face) = ttf_parser::Face::parse(file, 0) else { return Box::new(|_| 0.5) };
    let scale = 1.0 / f64::from(face.units_per_em());
    Box::new(move |letter| {
        let units = face.glyph_index(letter).and_then(|glyph| face.glyph_hor_advance(glyph));
        units.map_or(0.5, |units| f64::from(units) * scale)
    })
}

/// All fonts that figures use.
pub fn database() -> Arc<fontdb::Database> {
    FONTS.database.clone()
}

/// The name of the font, and what takes its place where it is not.
pub const FAMILY: &str = "Inter, 'Helvetica Neue', Helvetica, Arial, sans-serif";
