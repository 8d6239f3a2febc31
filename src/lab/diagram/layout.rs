//! Where everything lies in a picture. Columns follow time; lanes run through all columns; boxes of a lane are stacked.
//!
//! Links between columns are nets: what leaves an item for one reason goes into the gutter behind its column on a line of
//! its own, and from there to its targets; past whole columns it goes along a track above all boxes, or below them if it only
//! keeps an order. So no line runs through a box.
use super::{Diagram, Kind, bytes};
use engine::graph::recipe::Why;
use std::collections::{BTreeMap, BTreeSet};

/// Width of an item.
pub const WIDTH: f64 = 150.0;
/// Room for arcs within a box.
const ARCS: f64 = 46.0;
const PAD: f64 = 8.0;
const TITLE: f64 = 18.0;
const GAP: f64 = 6.0;
/// Height of a line of text in an item.
pub const TEXT: f64 = 13.0;
const BETWEEN: f64 = 22.0;
/// Distance of parallel lines.
const PITCH: f64 = 5.0;
/// Room for the labels of links, where there are some.
const LABELS: f64 = 170.0;
/// Height of the label of a link.
const LABEL: f64 = 12.0;

/// A rectangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rect {
    /// Left edge.
    pub x: f64,
    /// Upper edge.
    pub y: f64,
    /// Width.
    pub w: f64,
    /// Height.
    pub h: f64,
}

/// Links from one item to another for one reason, and their way.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// The links.
    pub links: Vec<usize>,
    /// Why.
    pub why: Why,
    /// Corners of the way; two for an arc.
    pub points: Vec<(f64, f64)>,
    /// How far an arc goes out; 0: straight lines.
    pub bulge: f64,
    /// Whether its links are written along its end.
    pub labeled: bool,
}

/// A picture without ink.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// Width of the picture.
    pub width: f64,
    /// Height of the picture.
    pub height: f64,
    /// Items, as in the diagram.
    pub items: Vec<Rect>,
    /// Text of each item, line by line.
    pub texts: Vec<Vec<String>>,
    /// Boxes, as in the diagram.
    pub groups: Vec<Rect>,
    /// Lanes, as in the diagram.
    pub lanes: Vec<Rect>,
    /// Left edge of each column.
    pub columns: Vec<f64>,
    /// Links.
    pub routes: Vec<Route>,
}

/// A link's ends and reason.
type Bundle = (usize, usize, u8);

/// Lays a diagram out.
pub fn layout(diagram: &Diagram<'_>) -> Layout {
    let mut bundles: BTreeMap<Bundle, Vec<usize>> = BTreeMap::new();
    for (number, link) in diagram.links.iter().enumerate() {
        bundles.entry((link.from, link.to, link.why as u8)).or_default().push(number);
    }
    let mut plan = Planner { diagram, bundles, out: Layout::default(), gutters: Vec::new() };
    plan.texts();
    plan.stack();
    plan.spread();
    plan.route();
    plan.out
}

struct Planner<'a, 'b> {
    diagram: &'a Diagram<'b>,
    bundles: BTreeMap<Bundle, Vec<usize>>,
    out: Layout,
    /// Left edge and width of the gutter behind each column.
    gutters: Vec<(f64, f64)>,
}

/// A line of a gutter: of a net that leaves an item, or of one that comes down to a column.
type Line = (usize, u8);

impl Planner<'_, '_> {
    fn column(&self, item: usize) -> usize {
        self.diagram.items[item].column
    }

    /// Whether links to an item are labeled.
    fn labeled(&self, item: usize) -> bool {
        !self.diagram.expanded && !matches!(self.diagram.items[item].kind, Kind::Task(_))
    }

    fn texts(&mut self) {
        for item in &self.diagram.items {
            let mut lines = vec![item.name.clone()];
            if !matches!(item.kind, Kind::Task(_)) {
                lines[0] = item.name.split(' ').next().unwrap_or_default().to_owned();
                if let (Some(from), Some(to)) = (item.rank, item.to_rank) {
                    lines[0] += &format!(" {from} → {to}");
                }
                if !self.diagram.expanded {
                    lines.extend(item.labels.iter().map(|label| label.name().to_owned()));
                }
                let (count, size) = (item.messages.count, bytes(item.messages.bytes));
                lines.push(format!("{count} message{}, {size}", if count == 1 { "" } else { "s" }));
            }
            self.out.texts.push(lines);
        }
    }

    fn height(&self, item: usize) -> f64 {
        let own = 11.0 + TEXT * self.out.texts[item].len() as f64;
        if !self.labeled(item) {
            return own;
        }
        let links = self.bundles.iter().filter(|((_, to, _), _)| *to == item).map(|(_, links)| links.len());
        own.max(LABEL * (1 + links.sum::<usize>()) as f64)
    }

    /// Heights: items in boxes, boxes in lanes.
    fn stack(&mut self) {
        let diagram = self.diagram;
        let heights: Vec<f64> = (0..diagram.items.len()).map(|item| self.height(item)).collect();
        let title = |group: &super::Group| match group.stage {
            true => TITLE + 12.0 * (group.title.lines().count().max(1) - 1) as f64,
            false => 0.0,
        };
        let inner = |group: &super::Group| -> f64 {
            let items: f64 = group.items.iter().map(|&at| heights[at] + GAP).sum();
            if group.items.is_empty() {
                0.0
            } else {
                items - GAP + if group.stage { title(group) + 2.0 * PAD } else { 0.0 }
            }
        };
        let mut stacks: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        for group in diagram.groups.iter().filter(|group| !group.items.is_empty()) {
            let stack = stacks.entry((group.lane, group.column)).or_insert(-BETWEEN);
            *stack += inner(group) + BETWEEN;
        }
        let [data, order] = [false, true].map(|order| self.far(order) as f64);
        let mut y = 44.0 + PITCH * data;
        for lane in 0..diagram.lanes.len() {
            let column_heights = stacks.range((lane, 0)..(lane + 1, 0)).map(|(_, height)| *height);
            let height = column_heights.fold(0.0, f64::max);
            let above = if height > 0.0 && !diagram.lanes[lane].title.is_empty() { TITLE } else { 0.0 };
            let margin = if height > 0.0 { BETWEEN + above } else { 0.0 };
            self.out.lanes.push(Rect { x: 0.0, y, w: 0.0, h: height + margin });
            y += height + margin;
        }
        self.out.height = y + 16.0 + PITCH * order;
        self.out.items = vec![Rect::default(); diagram.items.len()];
        self.out.groups = vec![Rect::default(); diagram.groups.len()];
        let titled = |lane: usize| if diagram.lanes[lane].title.is_empty() { 0.0 } else { TITLE };
        let mut used: BTreeMap<(usize, usize), f64> = BTreeMap::new();
        for (number, group) in diagram.groups.iter().enumerate().filter(|(_, g)| !g.items.is_empty()) {
            let place = (group.lane, group.column);
            let lane = self.out.lanes[group.lane];
            let top = used.entry(place).or_insert(
                lane.y + titled(group.lane) + 0.5 * (lane.h - titled(group.lane) - stacks[&place]),
            );
            self.out.groups[number] = Rect { x: 0.0, y: *top, w: 0.0, h: inner(group) };
            let mut y = *top + if group.stage { title(group) + PAD } else { 0.0 };
            for &at in &group.items {
                self.out.items[at] = Rect { x: 0.0, y, w: WIDTH, h: heights[at] };
                y += heights[at] + GAP;
            }
            *top += inner(group) + BETWEEN;
        }
    }

    /// How many nets pass whole columns: those that carry data, or those that keep an order.
    fn far(&self, order: bool) -> usize {
        let far = self.bundles.keys().filter(|(from, to, why)| {
            self.column(*to) > self.column(*from) + 1 && (*why != Why::Flow as u8) == order
        });
        far.map(|(from, _, why)| (*from, *why)).collect::<BTreeSet<_>>().len()
    }

    /// The lines of each gutter, in order.
    fn lines(&self) -> Vec<Vec<Line>> {
        let mut lines = vec![BTreeSet::new(); self.diagram.columns.len()];
        for &(from, to, why) in self.bundles.keys() {
            let (a, b) = (self.column(from), self.column(to));
            if a < b {
                lines[a].insert((from, why));
                lines[b - 1].insert((from, why));
            }
        }
        lines.into_iter().map(|set| set.into_iter().collect()).collect()
    }

    /// Horizontal positions.
    fn spread(&mut self) {
        let lines = self.lines();
        let stage = |column: usize| self.diagram.groups.iter().any(|g| g.column == column && g.stage);
        let mut x = 20.0;
        for column in 0..self.diagram.columns.len() {
            let labels =
                (0..self.diagram.items.len()).any(|at| self.column(at) == column + 1 && self.labeled(at));
            let width = if stage(column) { WIDTH + 2.0 * PAD + ARCS } else { WIDTH };
            let inset = if stage(column) { PAD } else { 0.0 };
            for (group, rect) in self.diagram.groups.iter().zip(&mut self.out.groups) {
                if group.column == column {
                    (rect.x, rect.w) = (x, width);
                    group.items.iter().for_each(|&at| self.out.items[at].x = x + inset);
                }
            }
            self.out.columns.push(x);
            let gutter = (PITCH * (lines[column].len() + 1) as f64).min(320.0);
            self.gutters.push((x + width + 8.0, gutter));
            x += width + 8.0 + gutter + 22.0 + if labels { LABELS } else { 0.0 };
        }
        self.out.width = x;
        for lane in &mut self.out.lanes {
            (lane.x, lane.w) = (6.0, x - 12.0);
        }
    }

    /// Where a line of a gutter runs.
    fn line_x(&self, lines: &[Vec<Line>], gutter: usize, line: Line) -> f64 {
        let place = lines[gutter].iter().position(|&l| l == line).unwrap_or(0) + 1;
        let (left, width) = self.gutters[gutter];
        left + width * place as f64 / (lines[gutter].len() + 1) as f64
    }

    fn route(&mut self) {
        let lines = self.lines();
        let ports = self.ports();
        let leaving = self.leaving();
        let tracks = self.tracks();
        let bundles = std::mem::take(&mut self.bundles);
        for (&(from, to, why), links) in &bundles {
            let (source, target) = (self.out.items[from], self.out.items[to]);
            let reason = self.diagram.links[links[0]].why;
            let right = (source.x + source.w, leaving[&(from, why)]);
            let (a, b) = (self.column(from), self.column(to));
            let mut route =
                Route { links: links.clone(), why: reason, points: vec![right], bulge: 0.0, labeled: false };
            if a >= b {
                let apart = (source.y - target.y).abs() / (TEXT + 17.0);
                route.bulge = (10.0 + 7.0 * apart).min(ARCS + 8.0);
                route.points.push((target.x + target.w, target.y + 0.3 * target.h));
            } else {
                let end = (target.x, ports[&(from, to, why)]);
                let x = self.line_x(&lines, a, (from, why));
                route.points.push((x, right.1));
                if b > a + 1 {
                    let (y, down) = (tracks[&(from, why)], self.line_x(&lines, b - 1, (from, why)));
                    route.points.extend([(x, y), (down, y), (down, end.1)]);
                } else {
                    route.points.push((x, end.1));
                }
                route.points.push(end);
                route.labeled = self.labeled(to);
            }
            self.out.routes.push(route);
        }
    }

    /// Where links arrive: one below the other, in the order of their sources.
    fn ports(&self) -> BTreeMap<Bundle, f64> {
        let mut arriving: BTreeMap<usize, Vec<(Bundle, usize)>> = BTreeMap::new();
        for (&bundle, links) in &self.bundles {
            if self.column(bundle.0) < self.column(bundle.1) {
                let weight = if self.labeled(bundle.1) { links.len() } else { 1 };
                arriving.entry(bundle.1).or_default().push((bundle, weight));
            }
        }
        let mut ports = BTreeMap::new();
        for (item, mut list) in arriving {
            let rect = self.out.items[item];
            list.sort_by(|a, b| self.out.items[a.0.0].y.total_cmp(&self.out.items[b.0.0].y));
            let all: usize = list.iter().map(|(_, weight)| weight).sum();
            let mut before = 0;
            for (bundle, weight) in list {
                before += weight;
                ports.insert(bundle, rect.y + rect.h * (before as f64 - 0.1) / (all as f64 + 0.4));
            }
        }
        ports
    }

    /// Where nets leave items.
    fn leaving(&self) -> BTreeMap<Line, f64> {
        let mut leaving = BTreeMap::new();
        for &(from, _, why) in self.bundles.keys() {
            let rect = self.out.items[from];
            leaving.insert((from, why), rect.y + rect.h * [0.5, 0.7, 0.85][why as usize % 3]);
        }
        leaving
    }

    /// The tracks of nets that pass whole columns: data above, order below.
    fn tracks(&self) -> BTreeMap<Line, f64> {
        let mut tracks = BTreeMap::new();
        let (mut above, mut below) = (38.0, self.out.height - 8.0);
        for &(from, to, why) in self.bundles.keys().rev() {
            if self.column(to) > self.column(from) + 1 {
                tracks.entry((from, why)).or_insert_with(|| {
                    let track = if why == Why::Flow as u8 { &mut above } else { &mut below };
                    let y = *track;
                    *track += if why == Why::Flow as u8 { PITCH } else { -PITCH };
                    y
                });
            }
        }
        tracks
    }
}
