//! Draws a diagram.
use super::layout::{Layout, Rect, Route, TEXT};
use super::{Diagram, Kind, Link, bytes, json::word, time, words};
use engine::graph::recipe::Why;
use std::fmt::Write;

/// Colors of materials: fill and line (a palette that color-blind people can tell apart, after P. Tol).
const MATERIALS: [(&str, &str); 6] = [
    ("#e8f1fb", "#3b76af"),
    ("#fdf0e3", "#c4702b"),
    ("#e9f6ec", "#2f8a4c"),
    ("#f5e9f5", "#8d4a93"),
    ("#fbf7da", "#9b8a1c"),
    ("#e6f5f7", "#2b8a99"),
];
/// Colors of what belongs to all materials.
const SHARED: (&str, &str) = ("#f2f2f2", "#555555");
/// Color of the critical path.
const CRITICAL: &str = "#c0392b";

/// How it looks, without what depends on materials.
pub(super) const STYLE: &str = "text{font-family:sans-serif;font-size:12px;fill:#222}.small{font-size:10px;fill:#555}\
.label{font-size:9.5px;fill:#333}.lane{fill:none;stroke:#999;\
stroke-dasharray:6 4}.band{fill:#fafafa;stroke:#ccc}.stage{fill:#fff;stroke-width:1.2}.item rect,.item path{stroke-width:1}\
.link path{fill:none;stroke-width:1.2}.link.war path,.link.waw path{stroke-dasharray:4 3;opacity:.55}\
.link.waw path{stroke-dasharray:1 3}.critical rect,.critical path{stroke-width:2.6;stroke:#c0392b}\
.link.critical path{opacity:1}.caption{font-weight:bold;fill:#3b5b8c}.loop rect{fill:none;stroke:#3b5b8c;stroke-width:1.6}\
.graph rect{fill:none;stroke:#999}.pass path{fill:none;stroke:#3b5b8c;stroke-width:1.2}.pass.again path{stroke-dasharray:5 3}\
.pass text{fill:#3b5b8c}";

/// What lines mean, and numbers, which are about `span`.
pub(super) fn legend(span: &str) -> String {
    format!(
        "solid: data; dashed: overwrites what was read; dotted: overwrites what was written; red: critical path; numbers: time \
of {span}; @n: layers of ghosts; blue: from graph to graph; blue, dashed: to the next round"
    )
}

impl Diagram<'_> {
    /// Draws the graph; ids begin with `prefix`, and its links are numbered from `first` on.
    pub(super) fn draw(&self, layout: &Layout, prefix: &str, first: usize, out: &mut String) {
        self.draw_lanes(layout, out);
        for (column, x) in self.columns.iter().zip(&layout.columns) {
            let _ = writeln!(out, "<text class=\"small\" x=\"{x:.1}\" y=\"16\">{}</text>", escape(column));
        }
        for (group, rect) in
            self.groups.iter().zip(&layout.groups).filter(|(g, _)| g.stage && !g.items.is_empty())
        {
            let material = self.items[group.items[0]].material;
            let ((_, line), tint) = (color(material), tint(material));
            let _ = writeln!(
                out,
                "<rect class=\"stage {tint}\" {} rx=\"6\" stroke=\"{line}\"/>",
                attributes(rect)
            );
            for (number, line) in group.title.lines().enumerate() {
                let (x, y) = (rect.x + 8.0, rect.y + 15.0 + 12.0 * number as f64);
                let _ =
                    writeln!(out, "<text class=\"small\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escape(line));
            }
        }
        layout.routes.iter().for_each(|route| self.draw_route(route, prefix, first, out));
        (0..self.items.len()).for_each(|at| self.draw_item(at, layout, prefix, out));
    }

    /// What every tick has, or the patches of ranks.
    fn draw_lanes(&self, layout: &Layout, out: &mut String) {
        let shown = self.lanes.iter().zip(&layout.lanes).filter(|(_, rect)| rect.h > 0.0);
        for (lane, rect) in shown.filter(|(lane, _)| !lane.title.is_empty()) {
            let class = if self.expanded { "band" } else { "lane" };
            let _ = writeln!(out, "<rect class=\"{class}\" {}/>", attributes(rect));
            let title = match lane.rank {
                Some(rank) if !lane.title.starts_with("rank") => format!("{} on rank {rank}", lane.title),
                _ => lane.title.clone(),
            };
            let _ = writeln!(
                out,
                "<text class=\"small\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                rect.x + 8.0,
                rect.y + 12.0,
                escape(&title)
            );
        }
    }

    fn draw_item(&self, at: usize, layout: &Layout, prefix: &str, out: &mut String) {
        let (item, rect) = (&self.items[at], &layout.items[at]);
        let (fill, line) = match item.kind {
            Kind::Task(_) => color(item.material),
            Kind::Halo(_) => ("#fff3d6", "#b7791f"),
            Kind::Reduction(_) => ("#efe6fa", "#6b46c1"),
            Kind::Relocation => ("#dff5ee", "#23775a"),
        };
        let critical = if item.critical { " critical" } else { "" };
        let _ = write!(
            out,
            "<g class=\"item {} {}{critical}\" id=\"{prefix}{}\">{}",
            word(item.kind),
            tint(item.material),
            item.id,
            title(prefix, || self.tip(at))
        );
        let round = if matches!(item.kind, Kind::Task(_)) { 3.0 } else { 10.0 };
        let _ = write!(out, "<rect {} rx=\"{round}\" fill=\"{fill}\" stroke=\"{line}\"/>", attributes(rect));
        let lines = &layout.texts[at];
        let first = rect.y + 0.5 * (rect.h - TEXT * lines.len() as f64) + 10.0;
        for (number, text) in lines.iter().enumerate() {
            let class = if number > 0 { " class=\"small\"" } else { "" };
            let y = first + TEXT * number as f64;
            let _ =
                write!(out, "<text{class} x=\"{:.1}\" y=\"{y:.1}\">{}</text>", rect.x + 8.0, escape(text));
        }
        if matches!(item.kind, Kind::Task(_)) && item.cost > 0.0 {
            let _ = write!(
                out,
                "<text class=\"small cost\" text-anchor=\"end\" x=\"{:.1}\" y=\"{first:.1}\">{}</text>",
                rect.x + rect.w - 5.0,
                time(item.cost)
            );
        }
        out.push_str("</g>\n");
    }

    fn tip(&self, at: usize) -> String {
        let item = &self.items[at];
        let how = item.source.word();
        let mut tip = format!("{}\n{}\n{} {how}", self.title(item), self.about(item), time(item.cost));
        if let Kind::Task(node) = item.kind {
            for access in self.graph.graph[node].declaration.access {
                let (label, mode) = (access.label, words::mode(access));
                tip += &format!("\n{mode}: {} [{}], {}", label.name(), label.unit(), label.meaning());
                if access.ghost > 0 {
                    tip += &format!(", {}", words::ghosts(access.ghost));
                }
            }
        }
        tip
    }

    fn draw_route(&self, route: &Route, prefix: &str, number: usize, out: &mut String) {
        let links = || route.links.iter().map(|&at| &self.links[at]);
        let Some(first) = links().next() else { return };
        let critical = links().any(|link| link.critical);
        let (class, mut stroke) = match route.why {
            Why::Flow => ("flow", color(first.material).1),
            Why::WriteAfterRead => ("war", "#888888"),
            Why::WriteAfterWrite => ("waw", "#888888"),
        };
        let mark = if critical { " critical" } else { "" };
        if critical {
            stroke = CRITICAL;
        }
        let numbers: Vec<String> = route.links.iter().map(|at| (number + at).to_string()).collect();
        let tips = || links().map(|link| self.describe(link)).collect::<Vec<String>>();
        let (from, to) = (&self.items[first.from], &self.items[first.to]);
        let _ = writeln!(
            out,
            "<g class=\"link {class} {}{mark}\" data-from=\"{prefix}{}\" data-to=\"{prefix}{}\" data-links=\"{}\">{}<path d=\"{}\" stroke=\"{stroke}\" marker-end=\"url(#{prefix}tip)\"/>{}</g>",
            tint(first.material),
            from.id,
            to.id,
            numbers.join(" "),
            title(prefix, || format!("{} to {}\n{}", self.title(from), self.title(to), tips().join("\n"))),
            way(route),
            self.labels(route)
        );
    }

    /// The texts along the end of a route, one a link.
    fn labels(&self, route: &Route) -> String {
        let Some(&(x, y)) = route.points.last().filter(|_| route.labeled) else { return String::new() };
        let count = route.links.len();
        let texts = route.links.iter().enumerate().map(|(number, &at)| {
            let link = &self.links[at];
            let y = y - 3.0 - 11.0 * (count - 1 - number) as f64;
            let text = format!(
                "{}{} {} {}",
                link.label.name(),
                if link.ghost > 0 { format!("@{}", link.ghost) } else { String::new() },
                self.material(link.material),
                if link.bytes > 0 { bytes(link.bytes) } else { String::new() }
            );
            let text = escape(text.trim());
            format!(
                "<text class=\"label\" text-anchor=\"end\" x=\"{:.1}\" y=\"{y:.1}\">{text}</text>",
                x - 8.0
            )
        });
        texts.collect()
    }

    /// A link in a line.
    pub(super) fn describe(&self, link: &Link) -> String {
        let ghost = if link.ghost > 0 { format!(" with {} ghost layers", link.ghost) } else { String::new() };
        let of = link.material.map_or(String::new(), |m| format!(" of {}", self.graph.recipe.materials[m]));
        let size = if link.bytes > 0 { format!(", {}", bytes(link.bytes)) } else { String::new() };
        format!("{}: {}{of}{ghost}{size}", link.why.name(), link.label.name())
    }
}

/// The class of a material's color.
fn tint(material: Option<usize>) -> String {
    material.map_or("shared".to_owned(), |m| format!("m{}", m % MATERIALS.len()))
}

/// What a picture says where it is pointed at; a page, whose ids have a prefix, has better means.
pub(super) fn title(prefix: &str, text: impl Fn() -> String) -> String {
    if prefix.is_empty() { format!("<title>{}</title>", escape(&text())) } else { String::new() }
}

fn color(material: Option<usize>) -> (&'static str, &'static str) {
    material.map_or(SHARED, |m| MATERIALS[m % MATERIALS.len()])
}

pub(super) fn attributes(rect: &Rect) -> String {
    let Rect { x, y, w, h } = rect;
    format!("x=\"{x:.1}\" y=\"{y:.1}\" width=\"{w:.1}\" height=\"{h:.1}\"")
}

/// The way of a route: straight, or an arc.
fn way(route: &Route) -> String {
    let points = &route.points;
    if let ([(x0, y0), (x1, y1)], true) = (&points[..], route.bulge > 0.0) {
        let b = route.bulge;
        return format!("M{x0:.1} {y0:.1}C{:.1} {y0:.1} {:.1} {y1:.1} {x1:.1} {y1:.1}", x0 + b, x1 + b);
    }
    corners(points)
}

/// A path with slightly rounded corners.
pub(super) fn corners(points: &[(f64, f64)]) -> String {
    let mut way = String::new();
    for (number, &(x, y)) in points.iter().enumerate() {
        let corner = points.get(number + 1).filter(|_| number > 0);
        let _ = match (number, corner) {
            (0, _) => write!(way, "M{x:.1} {y:.1}"),
            (_, Some(&next)) => {
                let ((ax, ay), (bx, by)) = (toward((x, y), points[number - 1]), toward((x, y), next));
                write!(way, "L{ax:.1} {ay:.1}Q{x:.1} {y:.1} {bx:.1} {by:.1}")
            }
            _ => write!(way, "L{x:.1} {y:.1}"),
        };
    }
    way
}

/// A point up to three units from `a` on the way to `b`.
fn toward(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length = dx.hypot(dy).max(1e-9);
    let part = (3.0 / length).min(0.5);
    (a.0 + part * dx, a.1 + part * dy)
}

/// Text as XML wants it.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
