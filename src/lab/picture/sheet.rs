//! The page around the particles: title, frame, scale bar, legend, directions.
use super::canvas::{Canvas, Color};
use super::font;
use super::ink::{LegendEntry, round_up};

const WIDTH: f64 = 1000.0;
const TALLEST: f64 = 1000.0;
const MARGIN: f64 = 28.0;
const TOP: f64 = 78.0;
const BOTTOM: f64 = 104.0;
const TEXT: Color = [40, 44, 52];
const FAINT: Color = [140, 146, 156];
const LINE: Color = [214, 218, 224];

/// How space maps to the page: which axes go right and up, and which way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Axis that goes right or left, and +1 if right.
    pub across: (usize, f64),
    /// Axis that goes up or down, and +1 if up.
    pub up: (usize, f64),
    /// Corners of the box that is shown [m].
    pub low: [f64; 3],
    /// The other corner [m].
    pub high: [f64; 3],
}

/// A page with a window, ready for particles.
pub struct Sheet {
    pub canvas: Canvas,
    window: Window,
    /// Pixels a meter.
    pub scale: f64,
    corner: [f64; 2],
    size: [f64; 2],
}

impl Sheet {
    pub fn new(window: Window) -> Self {
        let extent = [window.across.0, window.up.0].map(|a| (window.high[a] - window.low[a]).max(1e-12));
        let scale = ((WIDTH - 2.0 * MARGIN) / extent[0]).min(TALLEST / extent[1]);
        let size = extent.map(|e| e * scale);
        let height = TOP + size[1] + BOTTOM;
        let canvas = Canvas::new(WIDTH as usize, height.ceil() as usize);
        let mut sheet = Self { canvas, window, scale, corner: [0.5 * (WIDTH - size[0]), TOP], size };
        sheet.outline();
        sheet
    }

    /// Where a point is on the page [pixels].
    pub fn place(&self, x: [f64; 3]) -> [f64; 2] {
        let Window { across: (a, right), up: (b, upward), low, high } = self.window;
        let u = if right > 0.0 { x[a] - low[a] } else { high[a] - x[a] };
        let v = if upward > 0.0 { high[b] - x[b] } else { x[b] - low[b] };
        [self.corner[0] + u * self.scale, self.corner[1] + v * self.scale]
    }

    /// Whether a point is in the window.
    pub fn shows(&self, x: [f64; 3]) -> bool {
        [self.window.across.0, self.window.up.0]
            .iter()
            .all(|&a| self.window.low[a] <= x[a] && x[a] <= self.window.high[a])
    }

    /// A thin line across the window at a height along the upward axis [m].
    pub fn level(&mut self, at: f64) {
        let mut x = self.window.low;
        x[self.window.up.0] = at;
        let y = self.place(x)[1];
        let [left, right] = [self.corner[0], self.corner[0] + self.size[0]];
        let dash = 10.0;
        for k in 0..(self.size[0] / dash) as usize {
            let x = left + k as f64 * dash;
            self.canvas.stroke([x, y], [(x + 0.5 * dash).min(right), y], 0.5, FAINT);
        }
    }

    /// What the picture is, and when.
    pub fn title(&mut self, title: &str, subtitle: &str, time: f64) {
        let time = format!("t = {}", quantity(time, &[(1.0, "s"), (1e-3, "ms"), (1e-6, "µs")]));
        let right = WIDTH - MARGIN - font::width(&time, 15.0);
        let room = ((right - 2.0 * MARGIN) / font::width("x ", 15.0) * 1.8) as usize;
        let title = if title.chars().count() > room {
            title.chars().take(room.saturating_sub(3)).chain("...".chars()).collect()
        } else {
            title.to_string()
        };
        font::draw(&mut self.canvas, &title, [MARGIN, 20.0], 15.0, TEXT);
        font::draw(&mut self.canvas, &time, [right, 20.0], 15.0, TEXT);
        font::draw(&mut self.canvas, subtitle, [MARGIN, 48.0], 11.0, FAINT);
    }

    /// Scale bar, directions and what colors mean.
    pub fn legend(&mut self, entries: &[LegendEntry]) {
        let y = self.corner[1] + self.size[1] + 30.0;
        self.scale_bar(y);
        self.directions(y);
        let (mut x, y) = (MARGIN, y + 44.0);
        for entry in entries {
            x = match entry {
                LegendEntry::Ball(color, text) => {
                    self.canvas.ball([x + 8.0, y], 0.0, 8.0, *color);
                    self.label(text, [x + 22.0, y])
                }
                LegendEntry::Bar(color, top, what) => {
                    let left = self.label("0", [x, y]) + 8.0;
                    self.canvas.fill([left, y - 6.0], [left + 110.0, y + 6.0], color);
                    self.label(&format!("{} {what}", short(*top)), [left + 118.0, y])
                }
            } + 30.0;
        }
    }

    fn label(&mut self, text: &str, [x, y]: [f64; 2]) -> f64 {
        font::draw(&mut self.canvas, text, [x, y - 5.5], 11.0, TEXT);
        x + font::width(text, 11.0)
    }

    fn scale_bar(&mut self, y: f64) {
        let length = round_up(0.08 * self.size[0] / self.scale);
        let [left, right] = [MARGIN, MARGIN + length * self.scale];
        self.canvas.stroke([left, y], [right, y], 1.2, TEXT);
        for x in [left, right] {
            self.canvas.stroke([x, y - 5.0], [x, y + 5.0], 1.2, TEXT);
        }
        self.label(&quantity(length, &[(1.0, "m"), (1e-3, "mm"), (1e-6, "µm")]), [right + 12.0, y]);
    }

    fn directions(&mut self, y: f64) {
        let origin = [WIDTH - MARGIN - 46.0, y + 18.0];
        let Window { across, up, .. } = self.window;
        for (axis, step) in [(across.0, [across.1, 0.0]), (up.0, [0.0, -up.1])] {
            let tip = [0, 1].map(|a| origin[a] + 22.0 * step[a]);
            self.canvas.stroke(origin, tip, 1.0, FAINT);
            for side in [-1.0, 1.0] {
                let barb = [0, 1].map(|a| tip[a] - 6.0 * step[a] + side * 4.0 * step[1 - a]);
                self.canvas.stroke(barb, tip, 1.0, FAINT);
            }
            let name = ["x", "y", "z"][axis.min(2)];
            let at = [0, 1].map(|a| origin[a] + 34.0 * step[a]);
            font::draw(&mut self.canvas, name, [at[0] - 4.0, at[1] - 5.5], 11.0, FAINT);
        }
    }

    fn outline(&mut self) {
        let [left, top] = self.corner;
        let [right, bottom] = [left + self.size[0], top + self.size[1]];
        let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
        for k in 0..4 {
            self.canvas.stroke(corners[k], corners[(k + 1) % 4], 0.5, LINE);
        }
    }
}

/// A number in the first unit that it reaches, else in the last.
fn quantity(x: f64, units: &[(f64, &str)]) -> String {
    let reached = units.iter().find(|unit| x.abs() >= unit.0 * (1.0 - 1e-9));
    let &(size, name) = if x == 0.0 { &units[0] } else { reached.unwrap_or(&units[units.len() - 1]) };
    format!("{} {name}", short(x / size))
}

/// Four digits, without zeros at the end.
fn short(x: f64) -> String {
    let digits = if x == 0.0 { 0 } else { (3 - x.abs().log10().floor() as i32).clamp(0, 9) as usize };
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}
