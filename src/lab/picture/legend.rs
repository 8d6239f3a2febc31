//! What colors mean, beside the panels.
use super::span::Span;
use crate::lab::figure::axis::{Axis, Quantity, Scale};
use crate::lab::figure::colors::Map;
use crate::lab::figure::{Color, Figure, Mark, POINT, Type};

/// Width of a bar of colors [mm].
const BAR: f64 = 3.2;
/// The lowest and the highest bar [mm].
const HEIGHTS: [f64; 2] = [16.0, 38.0];
/// The widest that a legend gets [mm].
pub const WIDEST: f64 = 42.0;
const LABEL: Type = Type::new(8.0);
const TICK: Type = Type::new(7.0);
const FAINT: Color = [110, 116, 126];

/// A color and what has it.
pub type Named = (Color, String);

/// What a legend says.
#[derive(Clone, Debug)]
pub enum Legend {
    /// Colors, and what each means.
    Kinds(Vec<Named>),
    /// Colors of numbers: which, from where to where, and of what; and what has no number.
    Bar(Map, Span, Quantity, Vec<Named>),
}

impl Legend {
    fn scale(&self) -> Scale {
        match self {
            Legend::Bar(_, span, what, _) => what.scale(span.low.abs().max(span.high.abs())),
            Legend::Kinds(_) => Scale::ONE,
        }
    }

    /// How wide it wants to be [mm].
    pub fn width(&self) -> f64 {
        let named =
            |kinds: &[Named]| kinds.iter().map(|(_, name)| 5.0 + LABEL.width(name)).fold(0.0, f64::max);
        match self {
            Legend::Kinds(kinds) => named(kinds),
            Legend::Bar(_, span, what, others) => {
                let scale = self.scale();
                let widest =
                    ticks(span, &scale).iter().map(|(_, words)| TICK.width(words)).fold(0.0, f64::max);
                let words = what.label(scale);
                let longest =
                    words.split_whitespace().map(|word| LABEL.width(word)).fold(named(others), f64::max);
                (BAR + 1.5 + widest).max(longest).max(LABEL.width(&words).min(0.6 * WIDEST))
            }
        }
    }

    /// How high it is beside something so high [mm].
    pub fn height(&self, beside: f64) -> f64 {
        match self {
            Legend::Kinds(kinds) => (kinds.len() + 1) as f64 * LABEL.line_height(),
            Legend::Bar(..) => self.bar(beside) + self.around(),
        }
    }

    /// What is above and below the bar [mm]: two lines of words, and names.
    fn around(&self) -> f64 {
        let names = if let Legend::Bar(_, _, _, others) = self { others.len() } else { 0 };
        (names as f64 + 3.0) * LABEL.line_height()
    }

    fn bar(&self, beside: f64) -> f64 {
        (beside - self.around()).clamp(HEIGHTS[0], HEIGHTS[1])
    }

    /// Draws it from its upper left corner, `room` wide and beside something so high [mm].
    pub fn draw(&self, figure: &mut Figure, [x, top]: [f64; 2], [room, beside]: [f64; 2]) {
        let row = LABEL.line_height();
        match self {
            Legend::Kinds(kinds) => names(figure, [x, top], room, kinds),
            Legend::Bar(map, span, what, others) => {
                let scale = self.scale();
                let mut y = top;
                for line in LABEL.wrap(&what.label(scale.clone()), room) {
                    figure.text([x, y + 0.75 * row], line, LABEL);
                    y += row;
                }
                y += 1.2;
                let height = self.bar(beside);
                bar(figure, ([x, y], height), span, |t| map.at(t), &ticks(span, &scale));
                names(figure, [x, y + height + 0.8 * row], room, others);
            }
        }
    }
}

/// The bar's ticks, with words.
fn ticks(span: &Span, scale: &Scale) -> Vec<(f64, String)> {
    Axis { from: span.low, to: span.high, log: false }.ticks(5, scale.one)
}

/// Colors with their names.
fn names(figure: &mut Figure, [x, mut y]: [f64; 2], room: f64, kinds: &[Named]) {
    let row = LABEL.line_height();
    for (color, name) in kinds {
        figure.marks.push(Mark::Disc { center: [x + 1.6, y + 0.5 * row], radius: 1.3, color: *color });
        for line in LABEL.wrap(name, room - 5.0) {
            figure.text([x + 4.5, y + 0.75 * row], line, LABEL);
            y += row;
        }
    }
}

/// Colors from low at the bottom to high at the top, with an arrow where there are numbers beyond.
fn bar(
    figure: &mut Figure,
    ([x, top], height): ([f64; 2], f64),
    span: &Span,
    color: impl Fn(f64) -> Color,
    ticks: &[(f64, String)],
) {
    const STEPS: usize = 64;
    let width = BAR;
    let y = |t: f64| top + (1.0 - t) * height;
    for n in 0..STEPS {
        let [from, to] = [n, n + 1].map(|n| n as f64 / STEPS as f64);
        // no seams
        let overlap = if n + 1 < STEPS { 0.1 } else { 0.0 };
        figure.fill([x, y(to) - overlap], [x + width, y(from)], color(0.5 * (from + to)));
    }
    for (end, t, sign) in [(0, 0.0, 1.0), (1, 1.0, -1.0)] {
        if span.beyond[end] {
            let (base, tip) = (y(t), y(t) + 2.0 * sign);
            let points = vec![[x, base], [x + width, base], [x + 0.5 * width, tip]];
            figure.marks.push(Mark::Area { points, color: color(t) });
        }
    }
    for (value, words) in ticks {
        let at = y((value - span.low) / (span.high - span.low));
        figure.line(&[[x + width, at], [x + width + 0.8, at]], FAINT, 0.2);
        figure.text([x + width + 1.5, at + 0.35 * TICK.size * POINT], words, TICK);
    }
}
