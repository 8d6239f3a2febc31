//! Plots of lines as SVG: linear or logarithmic axes, a legend, nothing else.
use std::fmt::Write;

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
    pub axes: [String; 2],
    /// Which of them are logarithmic.
    pub log: [bool; 2],
    /// Whether each point has a mark.
    pub marks: bool,
    /// The lines.
    pub lines: Vec<Line>,
}

/// Colors that a color-blind person can tell apart (after P. Tol).
const COLORS: [&str; 7] = ["#3b76af", "#c4702b", "#2f8a4c", "#8d4a93", "#9b8a1c", "#2b8a99", "#555555"];
const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 440.0;
/// Left, right, top and bottom of the frame.
const FRAME: [f64; 4] = [70.0, 520.0, 40.0, 390.0];
const STYLE: &str = "text{font-family:sans-serif;font-size:12px;fill:#222}.grid{stroke:#ddd}.frame{fill:none;stroke:#888}\
polyline{fill:none;stroke-width:1.8}";

/// An axis: from and to, logarithmic or not.
#[derive(Clone, Copy)]
struct Axis {
    from: f64,
    to: f64,
    log: bool,
}

impl Axis {
    fn of(values: impl Iterator<Item = f64>, log: bool) -> Self {
        let ok = values.filter(|x| x.is_finite() && (!log || *x > 0.0));
        let (low, high) = ok.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
        match (low <= high, log) {
            (false, _) => Self { from: 1.0, to: 10.0, log },
            (true, true) => Self { from: low / 1.15, to: high * 1.15, log },
            (true, false) => {
                let (low, high) = (low.min(0.0), high.max(0.0));
                let room = 0.05 * (high - low).max(f64::MIN_POSITIVE);
                Self { from: if low < 0.0 { low - room } else { 0.0 }, to: high + room, log }
            }
        }
    }

    /// Where a value is, from 0 to 1.
    fn at(self, x: f64) -> f64 {
        match self.log {
            true => (x / self.from).ln() / (self.to / self.from).ln(),
            false => (x - self.from) / (self.to - self.from),
        }
    }

    fn ticks(self) -> Vec<f64> {
        if self.log {
            let decades = (self.to / self.from).log10();
            let steps: &[f64] = match decades {
                d if d > 4.0 => &[1.0],
                d if d > 1.5 => &[1.0, 3.0],
                _ => &[1.0, 2.0, 4.0, 6.0, 8.0],
            };
            let (first, last) = (self.from.log10().floor() as i32, self.to.log10().ceil() as i32);
            let all = (first..=last).flat_map(|e| steps.iter().map(move |s| s * 10f64.powi(e)));
            return all.filter(|x| (self.from..=self.to).contains(x)).collect();
        }
        let rough = (self.to - self.from) / 5.0;
        let unit = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|s| s * unit).find(|s| *s >= rough).unwrap_or(rough);
        let (first, last) = ((self.from / step).ceil() as i64, (self.to / step).floor() as i64);
        (first..=last).map(|n| n as f64 * step).collect()
    }
}

impl Plot {
    /// The plot as a file.
    pub fn to_svg(&self) -> String {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let x = Axis::of(points().map(|p| p[0]), self.log[0]);
        let y = Axis::of(points().map(|p| p[1]), self.log[1]);
        let [left, right, top, bottom] = FRAME;
        let px = |value: f64| left + x.at(value) * (right - left);
        let py = |value: f64| bottom - y.at(value) * (bottom - top);
        let mut out = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
             width=\"{WIDTH}\" height=\"{HEIGHT}\">\n<style>{STYLE}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        );
        self.grid(&mut out, (x, y), (&px, &py));
        for (n, line) in self.lines.iter().enumerate() {
            let color = COLORS[n % COLORS.len()];
            let is_shown = |p: &&[f64; 2]| (0..2).all(|a| p[a].is_finite() && (!self.log[a] || p[a] > 0.0));
            let shown = line.points.iter().filter(is_shown);
            let places: Vec<[f64; 2]> = shown.map(|p| [px(p[0]), py(p[1])]).collect();
            let marks: &[[f64; 2]] = if self.marks { &places } else { &[] };
            draw(&mut out, line, color, (&places, marks), top + 20.0 * n as f64);
        }
        out.push_str("</svg>\n");
        out
    }

    fn grid(
        &self,
        out: &mut String,
        (x, y): (Axis, Axis),
        (px, py): (&dyn Fn(f64) -> f64, &dyn Fn(f64) -> f64),
    ) {
        let [left, right, top, bottom] = FRAME;
        let mut line = |text: String| out.push_str(&(text + "\n"));
        for tick in x.ticks() {
            let at = px(tick);
            line(format!("<path class=\"grid\" d=\"M{at:.1} {top}V{bottom}\"/>"));
            let below = bottom + 16.0;
            line(format!("<text x=\"{at:.1}\" y=\"{below}\" text-anchor=\"middle\">{}</text>", short(tick)));
        }
        for tick in y.ticks() {
            let at = py(tick);
            line(format!("<path class=\"grid\" d=\"M{left} {at:.1}H{right}\"/>"));
            let (before, low) = (left - 6.0, at + 4.0);
            line(format!("<text x=\"{before}\" y=\"{low:.1}\" text-anchor=\"end\">{}</text>", short(tick)));
        }
        let (w, h, middle) = (right - left, bottom - top, 0.5 * (left + right));
        line(format!("<rect class=\"frame\" x=\"{left}\" y=\"{top}\" width=\"{w}\" height=\"{h}\"/>"));
        let [along, up] = &self.axes.each_ref().map(|text| escape(text));
        line(format!("<text x=\"{left}\" y=\"22\" font-weight=\"bold\">{}</text>", escape(&self.title)));
        line(format!("<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">{along}</text>", bottom + 38.0));
        let center = 0.5 * (top + bottom);
        line(format!(
            "<text transform=\"translate(18 {center}) rotate(-90)\" text-anchor=\"middle\">{up}</text>"
        ));
    }
}

/// A line with its marks and its place in the legend.
fn draw(
    out: &mut String,
    line: &Line,
    color: &str,
    (places, marks): (&[[f64; 2]], &[[f64; 2]]),
    legend: f64,
) {
    let path: Vec<String> = places.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(out, "<polyline points=\"{}\" stroke=\"{color}\"/>", path.join(" "));
    for [x, y] in marks {
        let _ = writeln!(out, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{color}\"/>");
    }
    let (from, to) = (FRAME[1] + 12.0, FRAME[1] + 32.0);
    let y = legend + 8.0;
    let _ = writeln!(out, "<polyline points=\"{from},{y} {to},{y}\" stroke=\"{color}\"/>");
    let _ = writeln!(out, "<text x=\"{}\" y=\"{}\">{}</text>", to + 6.0, y + 4.0, escape(&line.name));
}

fn short(x: f64) -> String {
    match x.abs() {
        a if a >= 1e5 || (a > 0.0 && a < 1e-3) => format!("{x:e}"),
        _ => format!("{}", (x * 1e6).round() / 1e6),
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_inside_the_frame_and_text_is_escaped() {
        let points = vec![[1.0, 1.0], [10.0, 0.5], [1e5, 0.25], [f64::NAN, 1.0]];
        let line = Line { name: "a < b".into(), points };
        let plot = Plot {
            title: "t".into(),
            axes: ["x".into(), "y".into()],
            log: [true, false],
            marks: true,
            lines: vec![line],
        };
        let svg = plot.to_svg();
        assert!(svg.contains("a &lt; b") && !svg.contains("NaN") && !svg.contains("inf"));
        assert_eq!(svg.matches("<circle").count(), 3);
        let value = |part: &str, key: &str| -> f64 {
            let (_, after) = part.split_once(&format!("{key}=\"")).expect("the key");
            after.split('"').next().expect("a number").parse().expect("a number")
        };
        for circle in svg.lines().filter(|line| line.starts_with("<circle")) {
            let (x, y) = (value(circle, "cx"), value(circle, "cy"));
            assert!((FRAME[0]..=FRAME[1]).contains(&x) && (FRAME[2]..=FRAME[3]).contains(&y), "{circle}");
        }
        let empty = Plot { lines: Vec::new(), ..plot };
        assert!(empty.to_svg().ends_with("</svg>\n"));
    }
}
