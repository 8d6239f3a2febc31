//! The page around the particles: title, time, panels, scale bar, directions and legends.
use super::Request;
use super::ink::Legend;
use super::view::View;
use crate::lab::figure::axis::{Axis, Scale, round_up, short};
use crate::lab::figure::{Anchor, Color, Figure, Mark, POINT, Raster, Type};

const MARGIN: f64 = 3.0;
/// Between panels, and before legends [mm].
const GAP: f64 = 3.0;
/// Below panels: scale bar and directions [mm].
const FOOT: f64 = 11.0;
/// A bar of colors [mm].
const BAR: [f64; 2] = [3.2, 38.0];
/// The widest that a legend gets [mm].
const WIDEST: f64 = 42.0;
const TITLE: Type = Type::new(9.0).bold();
const LABEL: Type = Type::new(8.0);
const SMALL: Type = Type::new(7.0).color(FAINT);
const TICK: Type = Type::new(7.0);
const FAINT: Color = [110, 116, 126];
const LINE: Color = [214, 218, 224];

/// A box of the page, right and up from the origin [m].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

impl Window {
    /// With a disc in it.
    pub fn with(self, at: [f64; 2], radius: f64) -> Self {
        let low = [0, 1].map(|a| self.low[a].min(at[a] - radius));
        Self { low, high: [0, 1].map(|a| self.high[a].max(at[a] + radius)) }
    }

    /// Larger towards another one, by a part of its own size at the most.
    pub fn towards(self, other: Self) -> Self {
        const PART: f64 = 0.35;
        let (size, mut window) = (self.size(), self);
        for a in 0..2 {
            window.low[a] = self.low[a].min(other.low[a]).max(self.low[a] - PART * size[a]);
            window.high[a] = self.high[a].max(other.high[a]).min(self.high[a] + PART * size[a]);
        }
        window
    }

    fn size(&self) -> [f64; 2] {
        [0, 1].map(|a| (self.high[a] - self.low[a]).max(1e-9))
    }
}

/// How a window is drawn as pixels.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Across and down.
    pub pixels: [usize; 2],
    /// Pixels a meter.
    pub scale: f64,
    window: Window,
}

impl Panel {
    /// Where a place on the page is [pixels].
    pub fn place(&self, at: [f64; 2]) -> [f64; 2] {
        [(at[0] - self.window.low[0]) * self.scale, (self.window.high[1] - at[1]) * self.scale]
    }
}

/// A page in the making.
pub struct Sheet {
    figure: Figure,
    pub panel: Panel,
    view: View,
    /// Width and height of a panel [mm].
    size: [f64; 2],
    /// Columns of panels.
    columns: usize,
    /// Width of the legends [mm].
    legends: f64,
    /// Height of a row: caption, panel, gap [mm].
    row: f64,
}

impl Sheet {
    /// A page for `columns` frames of a window, and rows with these legends.
    pub fn new(request: &Request, window: Window, legends: &[Option<Legend>], columns: usize) -> Self {
        let wide = legends.iter().flatten().map(width).fold(0.0, f64::max).min(WIDEST);
        let room = request.width - 2.0 * MARGIN - wide - columns as f64 * GAP;
        let each = (room / columns.max(1) as f64).max(10.0);
        let [across, up] = window.size();
        // no panel is taller than the page is wide, nor a row lower than its legend
        let scale = (each / across).min(0.95 * request.width / up);
        let size = [across * scale, up * scale];
        let caption = if columns > 1 { LABEL.line_height() } else { 0.0 };
        let least = legends.iter().flatten().map(height).fold(0.0, f64::max);
        let row = caption + size[1].max(least) + GAP;
        let dots = request.dpi / 25.4;
        let panel = Panel {
            pixels: size.map(|mm| (mm * dots).round().max(1.0) as usize),
            scale: scale * dots,
            window,
        };
        let figure = Figure::new([request.width, 0.0]);
        Self { figure, panel, view: request.view, size, columns, legends: wide, row }
    }

    fn corner(&self, n: usize) -> [f64; 2] {
        let [column, row] = [n % self.columns, n / self.columns];
        let caption = if self.columns > 1 { LABEL.line_height() } else { 0.0 };
        [MARGIN + column as f64 * (self.size[0] + GAP), caption + row as f64 * self.row]
    }

    /// Puts panels in rows, with their times where there are several, and dashed lines at planes across axes.
    pub fn panels(&mut self, panels: Vec<Raster>, times: &[f64], planes: &[(usize, f64)]) {
        for (n, raster) in panels.into_iter().enumerate() {
            let [x, y] = self.corner(n);
            if let (true, Some(time)) = (self.columns > 1, times.get(n % self.columns)) {
                self.figure.text([x, y - 0.3 * LABEL.line_height()], quantity(*time, &SECONDS), LABEL);
            }
            self.figure.marks.push(Mark::Image { at: [x, y], size: self.size, raster });
            self.figure.frame([x, y], [x + self.size[0], y + self.size[1]], LINE, 0.15);
            planes.iter().for_each(|&(axis, at)| self.level([x, y], axis, at));
        }
    }

    /// A dashed line at a plane that one sees edge on, across the page.
    fn level(&mut self, [x, y]: [f64; 2], axis: usize, at: f64) {
        let Window { low, high } = self.panel.window;
        let height = at * self.view.up[axis];
        if self.view.up[axis].abs() < 0.999 || !(low[1]..=high[1]).contains(&height) {
            return;
        }
        let down = y + (high[1] - height) / (high[1] - low[1]) * self.size[1];
        let points = vec![[x, down], [x + self.size[0], down]];
        self.figure.marks.push(Mark::Line { points, color: FAINT, width: 0.15, dashes: &[0.8, 0.8] });
    }

    /// Adds title, subtitle, time, scale bar, directions and legends.
    pub fn finish(mut self, title: &str, note: &str, times: &[f64], legends: Vec<Option<Legend>>) -> Figure {
        let right = MARGIN + self.columns as f64 * (self.size[0] + GAP);
        let rows = legends.len();
        for (n, legend) in legends.into_iter().enumerate() {
            let top = self.corner(n * self.columns)[1];
            if let Some(legend) = legend {
                draw(&mut self.figure, [right, top], self.legends, &legend);
            }
        }
        let foot = (rows as f64 - 1.0) * self.row + self.corner(0)[1] + self.size[1];
        let bottom = (rows as f64 * self.row).max(foot + FOOT);
        self.scale_bar(foot + 0.5 * FOOT);
        self.directions(foot + 0.5 * FOOT);
        self.figure.size[1] = bottom + MARGIN;
        let time = match times {
            [one] => format!("t = {}", quantity(*one, &SECONDS)),
            _ => String::new(),
        };
        let mut page = self.head(title, note, &time);
        let below = page.size[1];
        page.size[1] += self.figure.size[1];
        page.place(self.figure, [0.0, below]);
        page
    }

    /// Title, what is shown of it, and when.
    fn head(&self, title: &str, note: &str, time: &str) -> Figure {
        let width = self.figure.size[0];
        let room = width - 2.0 * MARGIN - LABEL.width(time) - GAP;
        let lines = TITLE.wrap(title, room);
        let mut head = Figure::new([width, 0.0]);
        head.text([width - MARGIN, MARGIN + 0.75 * TITLE.line_height()], time, LABEL.anchor(Anchor::End));
        let mut y = MARGIN;
        for line in lines {
            head.text([MARGIN, y + 0.75 * TITLE.line_height()], line, TITLE);
            y += TITLE.line_height();
        }
        for line in SMALL.wrap(note, width - 2.0 * MARGIN) {
            head.text([MARGIN, y + 0.75 * SMALL.line_height()], line, SMALL);
            y += SMALL.line_height();
        }
        head.size[1] = y + 1.5;
        head
    }

    fn scale_bar(&mut self, y: f64) {
        let meter = self.size[0] / self.panel.window.size()[0];
        let length = round_up(0.12 * self.panel.window.size()[0]);
        let [left, right] = [MARGIN, MARGIN + length * meter];
        self.figure.line(&[[left, y], [right, y]], LABEL.color, 0.4);
        for x in [left, right] {
            self.figure.line(&[[x, y - 0.8], [x, y + 0.8]], LABEL.color, 0.4);
        }
        let words = quantity(length, &[(1.0, "m"), (1e-3, "mm"), (1e-6, "µm")]);
        self.figure.text([right + 1.5, y + 0.35 * LABEL.size * POINT], words, LABEL);
    }

    fn directions(&mut self, y: f64) {
        let right = MARGIN + self.columns as f64 * (self.size[0] + GAP) - GAP;
        let origin = [right - 7.0, y + 1.5];
        for axis in 0..3 {
            let step = [self.view.right[axis], -self.view.up[axis]];
            let length = step[0].hypot(step[1]);
            if length < 0.2 {
                continue;
            }
            let end = |distance: f64| [origin[0] + distance * step[0], origin[1] + distance * step[1]];
            let tip = end(3.6);
            let ahead = step.map(|s| s / length);
            for side in [-1.0, 1.0] {
                let barb =
                    [0, 1].map(|a| tip[a] - 1.0 * ahead[a] + side * 0.6 * ahead[1 - a] * [1.0, -1.0][a]);
                self.figure.line(&[barb, tip], FAINT, 0.2);
            }
            self.figure.line(&[origin, tip], FAINT, 0.2);
            let at = [0, 1].map(|a| tip[a] + 1.6 * ahead[a]);
            let words = ["x", "y", "z"][axis];
            self.figure.text([at[0], at[1] + 0.35 * SMALL.size * POINT], words, SMALL.anchor(Anchor::Middle));
        }
    }
}

const SECONDS: [(f64, &str); 4] = [(1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns")];

/// A number in the first unit that it reaches, else in the last.
fn quantity(x: f64, units: &[(f64, &str)]) -> String {
    let reached = units.iter().find(|unit| x.abs() >= unit.0 * (1.0 - 1e-9));
    let &(size, name) = if x == 0.0 { &units[0] } else { reached.unwrap_or(&units[units.len() - 1]) };
    format!("{} {name}", short(x / size, 4))
}

/// The bar's ticks, with words.
fn ticks(span: &super::Span, scale: &Scale) -> Vec<(f64, String)> {
    Axis { from: span.low, to: span.high, log: false }.ticks(5, scale.one)
}

fn scale(legend: &Legend) -> Scale {
    match legend {
        Legend::Bar(_, span, what) => what.scale(span.low.abs().max(span.high.abs())),
        Legend::Kinds(_) => Scale::ONE,
    }
}

/// How wide a legend wants to be [mm].
fn width(legend: &Legend) -> f64 {
    match legend {
        Legend::Kinds(kinds) => 5.0 + kinds.iter().map(|(_, name)| LABEL.width(name)).fold(0.0, f64::max),
        Legend::Bar(_, span, what) => {
            let scale = scale(legend);
            let widest = ticks(span, &scale).iter().map(|(_, words)| TICK.width(words)).fold(0.0, f64::max);
            let words = what.label(scale);
            let longest = words.split_whitespace().map(|word| LABEL.width(word)).fold(0.0, f64::max);
            (BAR[0] + 1.5 + widest).max(longest).max(LABEL.width(&words).min(0.6 * WIDEST))
        }
    }
}

fn height(legend: &Legend) -> f64 {
    match legend {
        Legend::Kinds(kinds) => (kinds.len() + 1) as f64 * LABEL.line_height(),
        Legend::Bar(..) => BAR[1] + 3.0 * LABEL.line_height(),
    }
}

fn draw(figure: &mut Figure, [x, top]: [f64; 2], room: f64, legend: &Legend) {
    let row = LABEL.line_height();
    match legend {
        Legend::Kinds(kinds) => {
            let mut y = top;
            for (color, name) in kinds {
                figure.marks.push(Mark::Disc {
                    center: [x + 1.6, y + 0.5 * row],
                    radius: 1.3,
                    color: *color,
                });
                for line in LABEL.wrap(name, room - 5.0) {
                    figure.text([x + 4.5, y + 0.75 * row], line, LABEL);
                    y += row;
                }
            }
        }
        Legend::Bar(map, span, what) => {
            let scale = scale(legend);
            let mut y = top;
            for line in LABEL.wrap(&what.label(scale.clone()), room) {
                figure.text([x, y + 0.75 * row], line, LABEL);
                y += row;
            }
            y += 1.2;
            bar(figure, [x, y], span, |t| map.at(t), &ticks(span, &scale));
        }
    }
}

/// Colors from low at the bottom to high at the top, with an arrow where there are numbers beyond.
fn bar(
    figure: &mut Figure,
    [x, top]: [f64; 2],
    span: &super::Span,
    color: impl Fn(f64) -> Color,
    ticks: &[(f64, String)],
) {
    const STEPS: usize = 64;
    let [width, height] = BAR;
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
