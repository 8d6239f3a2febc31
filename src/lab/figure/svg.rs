//! Figures as SVG.
use super::{Anchor, Figure, Mark, Type, font};
use base64::Engine;
use std::fmt::Write;

impl Figure {
    /// The figure as a file, with its images in it.
    ///
    /// # Errors
    /// If an image cannot be encoded.
    pub fn to_svg(&self) -> Result<String, String> {
        let [width, height] = self.size.map(short);
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"{}\" stroke-linejoin=\"round\">\n",
            font::FAMILY
        );
        for mark in &self.marks {
            match mark {
                Mark::Image { at, size, raster } => {
                    let png = base64::engine::general_purpose::STANDARD.encode(raster.to_png(0.0)?);
                    let ([x, y], [w, h]) = (at.map(short), size.map(short));
                    let _ = writeln!(
                        out,
                        "<image x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" preserveAspectRatio=\"none\" \
                         href=\"data:image/png;base64,{png}\"/>"
                    );
                }
                other => write_mark(&mut out, other),
            }
        }
        out.push_str("</svg>\n");
        Ok(out)
    }
}

fn write_mark(out: &mut String, mark: &Mark) {
    let hex = |[r, g, b]: super::Color| format!("#{r:02x}{g:02x}{b:02x}");
    let _ = match mark {
        Mark::Line { points, color, width, dashes } => {
            let dashes = match dashes {
                [] => String::new(),
                some => format!(" stroke-dasharray=\"{}\"", joined(some.iter().map(|d| short(*d)))),
            };
            let (points, color, width) = (places(points), hex(*color), short(*width));
            writeln!(
                out,
                "<polyline points=\"{points}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\"{dashes}/>"
            )
        }
        Mark::Area { points, color } => {
            writeln!(out, "<polygon points=\"{}\" fill=\"{}\"/>", places(points), hex(*color))
        }
        Mark::Disc { center: [x, y], radius, color } => {
            let [x, y, radius] = [*x, *y, *radius].map(short);
            writeln!(out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{}\"/>", hex(*color))
        }
        Mark::Text { at, text, font } => write_text(out, *at, text, font),
        Mark::Image { .. } => Ok(()),
    };
}

fn write_text(out: &mut String, at: [f64; 2], text: &str, font: &Type) -> std::fmt::Result {
    let [x, y] = at.map(short);
    let place = match font.upright {
        true => format!("transform=\"translate({x} {y}) rotate(-90)\""),
        false => format!("x=\"{x}\" y=\"{y}\""),
    };
    let anchor = match font.anchor {
        Anchor::Start => "",
        Anchor::Middle => " text-anchor=\"middle\"",
        Anchor::End => " text-anchor=\"end\"",
    };
    let weight = if font.bold { " font-weight=\"600\"" } else { "" };
    let [r, g, b] = font.color;
    let (size, text) = (short(font.size * super::POINT), escape(text));
    writeln!(
        out,
        "<text {place} font-size=\"{size}\"{weight}{anchor} fill=\"#{r:02x}{g:02x}{b:02x}\">{text}</text>"
    )
}

fn places(points: &[[f64; 2]]) -> String {
    joined(points.iter().map(|p| format!("{},{}", short(p[0]), short(p[1]))))
}

fn joined(words: impl Iterator<Item = String>) -> String {
    words.collect::<Vec<_>>().join(" ")
}

/// Microns are enough.
fn short(x: f64) -> String {
    let text = format!("{x:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A text of XML; control characters, which XML cannot say, are left out.
fn escape(text: &str) -> String {
    let plain: String = text.chars().filter(|c| !c.is_control()).collect();
    plain.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
