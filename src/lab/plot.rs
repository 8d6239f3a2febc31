//! Plots of lines: linear or logarithmic axes, a legend, nothing else.
use super::figure::axis::{Axis, Quantity, Scale, fits};
use super::figure::{Anchor, Color, Figure, Mark, Type, colors};

/// A line of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// What the legend says.
    pub name: String,
    /// Points, in order of x.
    pub points: Vec<[f64; 2]>,
}

/// A plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Above it.
    pub title: String,
    /// Along x and y.
    pub axes: [Quantity; 2],
    /// Which of them are logarithmic.
    pub log: [bool; 2],
    /// Whether each point has a mark.
    pub marks: bool,
    /// The lines.
    pub lines: Vec<Line>,
}

const TITLE: Type = Type::new(9.0).bold();
const LABEL: Type = Type::new(8.0);
const TICK: Type = Type::new(7.0).color([70, 76, 86]);
const GRID: Color = [228, 231, 235];
const FRAME: Color = [140, 146, 156];
/// Widths of lines [mm].
const THIN: f64 = 0.15;
const THICK: f64 = 0.45;
const MARGIN: f64 = 3.0;
/// Height of the frame over its width.
const SHAPE: f64 = 0.6;
/// Lines beyond the number of colors are dashed.
const DASHES: [&[f64]; 3] = [&[], &[1.8, 1.0], &[0.5, 0.8]];
/// Length of a line in the legend [mm].
const SAMPLE: f64 = 6.0;
/// The narrowest figure [mm].
pub const NARROWEST: f64 = 40.0;

/// The frame of a plot on its figure, and what is in it.
struct Frame {
    low: [f64; 2],
    high: [f64; 2],
    axes: [Axis; 2],
}

impl Frame {
    fn place(&self, p: [f64; 2]) -> [f64; 2] {
        let [u, v] = [self.axes[0].at(p[0]), self.axes[1].at(p[1])];
        [self.low[0] + u * (self.high[0] - self.low[0]), self.high[1] - v * (self.high[1] - self.low[1])]
    }
}

impl Plot {
    /// The plot, `width` millimeters wide.
    pub fn draw(&self, width: f64) -> Figure {
        let width = width.max(NARROWEST);
        let points = || self.lines.iter().flat_map(|line| self.shown(line));
        let axes = [0, 1].map(|a| Axis::of(points().map(|p| p[a]), self.log[a], a == 1));
        let scales = [0, 1].map(|a| match self.log[a] {
            true => Scale::ONE,
            false => self.axes[a].scale(axes[a].from.abs().max(axes[a].to.abs())),
        });
        let ticks =
            [0, 1].map(|a| axes[a].ticks(if a == 0 { (width / 18.0) as usize } else { 6 }, scales[a].one));
        let widest = ticks[1].iter().map(|(_, words)| TICK.width(words)).fold(0.0, f64::max);
        let title = TITLE.wrap(&self.title, width - 2.0 * MARGIN);
        let legend = self.legend(width - 2.0 * MARGIN);
        let right = width - MARGIN - 2.0;
        let labels = [0, 1].map(|a| self.axes[a].label(scales[a].clone()));
        // a name that is longer than the frame is high stands above it
        let beside = MARGIN + LABEL.line_height() + 1.0 + widest + 1.2;
        let above = LABEL.width(&labels[1]) > SHAPE * (right - beside);
        let left = if above { MARGIN + widest + 1.2 } else { beside };
        let head = title.len() as f64 * TITLE.line_height() + legend.size[1];
        let top = MARGIN + head + 1.0 + if above { LABEL.line_height() } else { 0.0 };
        let bottom = top + SHAPE * (right - left).max(10.0);
        let frame = Frame { low: [left, top], high: [right, bottom], axes };
        let below = bottom + 1.2 + TICK.line_height() + LABEL.line_height();
        let mut figure = Figure::new([width, below + MARGIN]);
        for (n, words) in title.iter().enumerate() {
            figure.text([MARGIN, MARGIN + (n as f64 + 0.75) * TITLE.line_height()], words, TITLE);
        }
        figure.place(legend, [MARGIN, MARGIN + title.len() as f64 * TITLE.line_height() + 0.5]);
        self.axes(&mut figure, &frame, ticks);
        let [along, up] = labels;
        let below = bottom + 1.2 + TICK.line_height() + 0.75 * LABEL.line_height();
        figure.text([0.5 * (left + right), below], along, LABEL.anchor(Anchor::Middle));
        match above {
            true => figure.text([MARGIN, top - 0.4 * LABEL.line_height()], up, LABEL),
            false => {
                let at = [MARGIN + 0.75 * LABEL.line_height(), 0.5 * (top + bottom)];
                figure.text(at, up, LABEL.anchor(Anchor::Middle).upright());
            }
        }
        self.lines.iter().enumerate().for_each(|(n, line)| self.line(&mut figure, &frame, line, n));
        figure
    }

    /// The points of a line that axes can show.
    pub fn shown<'a>(&self, line: &'a Line) -> impl Iterator<Item = &'a [f64; 2]> {
        let log = self.log;
        line.points.iter().filter(move |p| (0..2).all(|a| fits(p[a], log[a])))
    }

    fn axes(&self, figure: &mut Figure, frame: &Frame, [along, up]: [Vec<(f64, String)>; 2]) {
        let ([left, top], [right, bottom]) = (frame.low, frame.high);
        let grid = |words: &str| if words.is_empty() { 0.5 * THIN } else { THIN };
        for (x, words) in along {
            let at = frame.place([x, frame.axes[1].from])[0];
            figure.line(&[[at, top], [at, bottom]], GRID, grid(&words));
            figure.text([at, bottom + TICK.line_height()], words, TICK.anchor(Anchor::Middle));
        }
        for (y, words) in up {
            let at = frame.place([frame.axes[0].from, y])[1];
            figure.line(&[[left, at], [right, at]], GRID, grid(&words));
            figure.text(
                [left - 1.2, at + 0.35 * TICK.size * super::figure::POINT],
                words,
                TICK.anchor(Anchor::End),
            );
        }
        for a in 0..2 {
            // where zero is
            if !frame.axes[a].log && frame.axes[a].from < 0.0 && frame.axes[a].to > 0.0 {
                let ends = [frame.axes[1 - a].from, frame.axes[1 - a].to];
                let line = ends.map(|end| frame.place(if a == 0 { [0.0, end] } else { [end, 0.0] }));
                figure.line(&line, FRAME, THIN);
            }
        }
        figure.frame(frame.low, frame.high, FRAME, 1.5 * THIN);
    }

    fn line(&self, figure: &mut Figure, frame: &Frame, line: &Line, n: usize) {
        let (color, dashes) = style(n);
        // rows of a history in which other columns alone have numbers are no gaps
        let points: Vec<[f64; 2]> = self.shown(line).map(|p| frame.place(*p)).collect();
        // of a point alone no line can be seen
        if self.marks || points.len() == 1 {
            figure.marks.extend(points.iter().map(|&center| Mark::Disc { center, radius: 0.8, color }));
        }
        figure.marks.push(Mark::Line { points, color, width: THICK, dashes });
    }

    /// Names of the lines in rows above the frame; none of a single line that axis or title name.
    fn legend(&self, room: f64) -> Figure {
        let mut figure = Figure::new([room, 0.0]);
        let named = |line: &Line| self.axes[1].words == line.name || self.title == line.name;
        if self.lines.len() < 2 && self.lines.iter().all(named) {
            return figure;
        }
        let row = LABEL.line_height();
        let (mut x, mut y) = (0.0, 0.0);
        for (n, line) in self.lines.iter().enumerate() {
            let (color, dashes) = style(n);
            let width = SAMPLE + 1.5 + LABEL.width(&line.name) + 4.0;
            if x > 0.0 && x + width > room {
                (x, y) = (0.0, y + row);
            }
            let points = vec![[x, y + 0.55 * row], [x + SAMPLE, y + 0.55 * row]];
            figure.marks.push(Mark::Line { points, color, width: THICK, dashes });
            figure.text([x + SAMPLE + 1.5, y + 0.78 * row], &line.name, LABEL);
            x += width;
        }
        figure.size[1] = y + row + 1.0;
        figure
    }
}

/// Color and dashes of a line.
fn style(n: usize) -> (Color, &'static [f64]) {
    (colors::LINES[n % colors::LINES.len()], DASHES[n / colors::LINES.len() % DASHES.len()])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot() -> Plot {
        let points = vec![[1.0, 1.0], [10.0, 0.5], [1e5, 0.25], [f64::NAN, 1.0]];
        let line = |name: &str| Line { name: name.into(), points: points.clone() };
        Plot {
            title: "a title that is much longer than the figure is wide: it goes on in lines of its own"
                .into(),
            axes: ["workers", "efficiency"].map(Quantity::plain),
            log: [true, false],
            marks: true,
            lines: vec![line("a < b"), line("second")],
        }
    }

    #[test]
    fn all_that_is_drawn_lies_on_the_figure() {
        for width in [10.0, 85.0, 170.0] {
            let figure = plot().draw(width);
            let [w, h] = figure.size;
            let inside = |p: &[f64; 2]| (0.0..=w).contains(&p[0]) && (0.0..=h).contains(&p[1]);
            for mark in &figure.marks {
                match mark {
                    Mark::Line { points, .. } => assert!(points.iter().all(inside), "{points:?}"),
                    Mark::Disc { center, .. } => assert!(inside(center)),
                    Mark::Text { at, text, font } => {
                        let end = font.width(text)
                            * match font.anchor {
                                Anchor::Start => 1.0,
                                Anchor::Middle => 0.5,
                                Anchor::End => 0.0,
                            };
                        assert!(
                            inside(at) && (font.upright || at[0] + end <= w + 0.01),
                            "{text} at {at:?} of {w}"
                        );
                    }
                    _ => {}
                }
            }
            let discs = figure.marks.iter().filter(|mark| matches!(mark, Mark::Disc { .. }));
            assert_eq!(discs.count(), 6, "no mark where there is no number");
        }
    }

    #[test]
    fn text_is_cut_between_words_and_only_then_in_them() {
        let font = Type::new(8.0);
        let text = "short words and aWordThatIsMuchLongerThanTheRoomThatThereIs, then some";
        let lines = font.wrap(text, 20.0);
        assert!(lines.iter().all(|line| font.width(line) <= 20.0), "{lines:?}");
        assert_eq!(lines.concat().replace(' ', ""), text.replace(' ', ""));
        assert_eq!(font.wrap("one two", 1e3), ["one two"]);
        assert_eq!(font.wrap("ab", 0.1), ["a", "b"]);
    }

    #[test]
    fn names_are_text_and_pixels_show_the_lines() -> Result<(), String> {
        let figure = plot().draw(85.0);
        let svg = figure.to_svg()?;
        assert!(svg.contains("a &lt; b") && !svg.contains("NaN") && !svg.contains("inf"));
        assert!(roxmltree::Document::parse(&svg).is_ok());
        let raster = figure.rasterize(150.0)?;
        assert_eq!(raster.size, figure.pixels(150.0)?);
        let near = |p: &Color, q: Color| p.iter().zip(q).all(|(a, b)| a.abs_diff(b) < 12);
        for color in &colors::LINES[..2] {
            assert!(raster.pixels.iter().filter(|p| near(p, *color)).count() > 50, "{color:?}");
        }
        let empty = Plot { lines: Vec::new(), ..plot() };
        assert!(empty.draw(85.0).to_svg()?.ends_with("</svg>\n"));
        Ok(())
    }
}
