//! Draws a program.
use super::Chart;
use super::flows::Flow;
use super::place::{Frame, Track, place};
use crate::lab::diagram::layout::{Layout, layout};
use crate::lab::diagram::svg::{STYLE, attributes, corners, escape, legend, title};
use engine::program::Delay;
use std::fmt::Write;

/// Room below the picture for what lines mean.
const LEGEND: f64 = 16.0;

impl Chart<'_> {
    /// A picture, as a file of its own.
    ///
    /// # Errors
    /// More items than a picture can show.
    pub fn to_svg(&self) -> Result<String, String> {
        self.drawable()?;
        let picture = self.draw("");
        Ok(format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{picture}\n"))
    }

    /// The picture; ids in it begin with `prefix`.
    pub(super) fn draw(&self, prefix: &str) -> String {
        let (flows, layouts) = (self.flows(), self.diagrams.iter().map(layout).collect::<Vec<Layout>>());
        let sheet = place(self, &flows, &layouts);
        let (w, h) = (sheet.width.ceil(), (sheet.height + LEGEND).ceil());
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\">\n\
<style>{STYLE}</style>\n<defs><marker id=\"{prefix}tip\" viewBox=\"0 0 8 8\" refX=\"7.5\" refY=\"4\" markerWidth=\"7\" \
markerHeight=\"7\" markerUnits=\"userSpaceOnUse\" orient=\"auto\"><path d=\"M0 0.5 8 4 0 7.5z\" fill=\"#555\"/></marker></defs>\n\
<rect class=\"paper\" width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\n"
        );
        sheet.frames.iter().for_each(|frame| draw_frame(frame, &mut out));
        let mut first = 0;
        for ((diagram, layout), (x, y)) in self.diagrams.iter().zip(&layouts).zip(&sheet.origins) {
            let _ = writeln!(out, "<g transform=\"translate({x:.1} {y:.1})\">");
            diagram.draw(layout, prefix, first, &mut out);
            out.push_str("</g>\n");
            first += diagram.links.len();
        }
        sheet.tracks.iter().for_each(|track| self.draw_track(track, &flows[track.flow], prefix, &mut out));
        let spans: Vec<&str> = self.diagrams.iter().map(|diagram| diagram.span()).collect();
        let same = spans.iter().all(|span| *span == spans[0]);
        let span = if same { spans[0] } else { "one run of each graph" };
        let _ = writeln!(
            out,
            "<text class=\"small legend\" x=\"12\" y=\"{:.1}\">{}</text>",
            h - 6.0,
            legend(span)
        );
        out.push_str("</svg>");
        out
    }

    fn draw_track(&self, track: &Track, flow: &Flow, prefix: &str, out: &mut String) {
        let class = if flow.delay == Delay::NextRound { "pass again" } else { "pass" };
        let numbers: Vec<String> = flow.passes.iter().map(ToString::to_string).collect();
        let (from, to) = (self.name(flow.from), self.name(flow.to));
        let _ = write!(
            out,
            "<g class=\"{class}\" data-passes=\"{}\">{}<path d=\"{}\" marker-end=\"url(#{prefix}tip)\"/>",
            numbers.join(" "),
            title(prefix, || format!("{from} to {to}, {}", flow.delay.name())),
            corners(&track.points)
        );
        let (x, y, lines) = &track.text;
        for (number, line) in lines.iter().enumerate() {
            let y = y + 13.0 * number as f64;
            let _ = write!(out, "<text class=\"small\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escape(line));
        }
        out.push_str("</g>\n");
    }
}

fn draw_frame(frame: &Frame, out: &mut String) {
    let class = if frame.round { "loop" } else { "graph" };
    let (x, y) = (frame.rect.x + 8.0, frame.rect.y + 15.0);
    let _ = writeln!(
        out,
        "<g class=\"{class}\"><rect {} rx=\"8\"/><text class=\"caption\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text></g>",
        attributes(&frame.rect),
        escape(&frame.caption)
    );
}
