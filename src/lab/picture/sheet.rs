//! The page around the particles: title, time, panels, scale bar, directions and legends.
use super::Request;
use super::legend::{self, Legend};
use super::view::View;
use crate::lab::figure::axis::{SECONDS, in_unit, round_up, short, unit_of};
use crate::lab::figure::{Anchor, Color, Figure, MOST, Mark, POINT, Raster, Type};

const MARGIN: f64 = 3.0;
/// Between panels, and before legends [mm].
const GAP: f64 = 3.0;
/// Below panels: scale bar and directions [mm].
const FOOT: f64 = 11.0;
/// Digits of times and lengths.
const DIGITS: i32 = 4;
/// The narrowest that a panel gets [mm].
const NARROWEST: f64 = 18.0;
const TITLE: Type = Type::new(9.0).bold();
const LABEL: Type = Type::new(8.0);
const SMALL: Type = Type::new(7.0).color(FAINT);
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
    /// Rows of panels of each coloring.
    rows: usize,
    /// Panels of each coloring.
    frames: usize,
    /// Width of the legends [mm].
    legends: f64,
    /// Height of a row: caption, panel, gap [mm].
    row: f64,
    /// Height of the rows of a coloring, beside its legend [mm].
    block: f64,
}

impl Sheet {
    /// A page for `frames` frames of a window, and rows with these legends.
    ///
    /// # Errors
    /// If it is too narrow, or has more pixels than a picture can have.
    pub fn new(
        request: &Request,
        window: Window,
        legends: &[Option<Legend>],
        frames: usize,
    ) -> Result<Self, String> {
        let wide = legends.iter().flatten().map(Legend::width).fold(0.0, f64::max).min(legend::WIDEST);
        let room = request.width - 2.0 * MARGIN - wide;
        // as many beside one another as can be looked at, the same number in each row as far as that goes
        let most = ((room / (NARROWEST + GAP)) as usize).max(1);
        let rows = frames.max(1).div_ceil(most);
        let columns = frames.max(1).div_ceil(rows);
        let each = room / columns as f64 - GAP;
        if each < NARROWEST {
            let least = (NARROWEST + GAP + 2.0 * MARGIN + wide).ceil();
            return Err(format!("with its legend this picture is at least {least} mm wide"));
        }
        let [across, up] = window.size();
        // no panel is taller than the page is wide, nor the rows of a coloring lower than its legend
        let scale = (each / across).min(0.95 * request.width / up);
        let size = [across * scale, up * scale];
        let caption = if frames > 1 { LABEL.line_height() } else { 0.0 };
        let least = legends
            .iter()
            .flatten()
            .map(|legend| legend.height(rows as f64 * (caption + size[1] + GAP)))
            .fold(0.0, f64::max);
        let row = caption + size[1] + GAP;
        let block = (rows as f64 * row).max(caption + least);
        let dots = request.dpi / 25.4;
        let pixels: f64 = size.iter().map(|mm| mm * dots).product();
        if pixels * (frames * legends.len().max(1)) as f64 > MOST {
            let [w, h] = size.map(|mm| (mm * dots).round());
            return Err(format!(
                "{frames} frames of {w} x {h} pixels are too many for a picture: ask for fewer dpi"
            ));
        }
        let panel = Panel {
            pixels: size.map(|mm| (mm * dots).round().max(1.0) as usize),
            scale: scale * dots,
            window,
        };
        let figure = Figure::new([request.width, 0.0]);
        Ok(Self { figure, panel, view: request.view, size, columns, rows, frames, legends: wide, row, block })
    }

    /// Where the panel of a frame is, of the row of a coloring.
    fn corner(&self, coloring: usize, frame: usize) -> [f64; 2] {
        let [column, row] = [frame % self.columns, frame / self.columns];
        let caption = if self.frames > 1 { LABEL.line_height() } else { 0.0 };
        let top = caption + coloring as f64 * self.block + row as f64 * self.row;
        [MARGIN + column as f64 * (self.size[0] + GAP), top]
    }

    /// Puts panels in rows, with their times where there are several, and dashed lines at planes across axes.
    pub fn panels(&mut self, panels: Vec<Raster>, times: &[f64], planes: &[(usize, f64)]) {
        let unit = unit_of(times.iter().copied().fold(0.0, f64::max), &SECONDS, DIGITS);
        for (n, raster) in panels.into_iter().enumerate() {
            let (coloring, frame) = (n / self.frames, n % self.frames);
            let [x, y] = self.corner(coloring, frame);
            if let (true, Some(time)) = (self.frames > 1, times.get(frame)) {
                let words = format!("{} {}", short(time / unit.0, DIGITS), unit.1);
                self.figure.text([x, y - 0.3 * LABEL.line_height()], words, LABEL);
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
        let colorings = legends.len();
        for (n, legend) in legends.into_iter().enumerate() {
            let top = self.corner(n, 0)[1];
            if let Some(legend) = legend {
                let beside = self.rows as f64 * self.row;
                legend.draw(&mut self.figure, [right, top], [self.legends, beside]);
            }
        }
        let foot = self.corner(colorings.saturating_sub(1), self.columns * (self.rows - 1))[1] + self.size[1];
        let bottom = (colorings as f64 * self.block).max(foot + FOOT);
        self.scale_bar(foot + 0.5 * FOOT);
        self.directions(foot + 0.5 * FOOT);
        self.figure.size[1] = bottom + MARGIN;
        let time = match times {
            [one] => format!("t = {}", in_unit(*one, &SECONDS, DIGITS)),
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
        // pictures of a film are of one size, whatever the time: it has the room of the longest one
        let longest = if time.is_empty() { 0.0 } else { LABEL.width("t = 0.0000 ms") };
        let room = width - 2.0 * MARGIN - longest.max(LABEL.width(time)) - GAP;
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
        let words = in_unit(length, &[(1.0, "m"), (1e-3, "mm"), (1e-6, "µm")], DIGITS);
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
