//! Where the pictures of graphs lie: one below another, in boxes of their loops. What passes between graphs leaves a box at
//! its lower left and goes along a track in the margin of the innermost loop around both to a line in the head of the other.
use super::Chart;
use super::flows::Flow;
use crate::lab::diagram::layout::{Layout, Rect};
use engine::graph::traffic::names;
use engine::program::{Delay, ProgramNode};

/// Around boxes, and between them.
const MARGIN: f64 = 12.0;
/// Height of a caption.
const CAPTION: f64 = 22.0;
/// Height of a line of the head of a graph.
const LINE: f64 = 13.0;
/// Distance of tracks.
const TRACK: f64 = 9.0;
/// Distance of lines that leave a box.
const OUT: f64 = 6.0;
/// Width of a letter of the head.
const LETTER: f64 = 5.6;
/// The least width of a picture, so that captions fit.
const LEAST: f64 = 420.0;

/// The box of a loop or of a graph.
pub(super) struct Frame {
    /// Where.
    pub(super) rect: Rect,
    /// Its caption.
    pub(super) caption: String,
    /// Whether it is that of a loop.
    pub(super) round: bool,
}

/// A flow with its way.
pub(super) struct Track {
    /// The flow, by number.
    pub(super) flow: usize,
    /// Corners.
    pub(super) points: Vec<(f64, f64)>,
    /// What it brings, line by line, with the place of the first.
    pub(super) text: (f64, f64, Vec<String>),
}

/// A picture of a program without ink.
#[derive(Default)]
pub(super) struct Sheet {
    /// Width of the picture.
    pub(super) width: f64,
    /// Height of the picture.
    pub(super) height: f64,
    /// Boxes, outer ones first.
    pub(super) frames: Vec<Frame>,
    /// Where the picture of each graph begins.
    pub(super) origins: Vec<(f64, f64)>,
    /// What passes between the graphs.
    pub(super) tracks: Vec<Track>,
}

/// Lays a program out whose graphs are laid out.
pub(super) fn place(chart: &Chart<'_>, flows: &[Flow], layouts: &[Layout]) -> Sheet {
    let mut placer =
        Placer { chart, flows, layouts, sheet: Sheet::default(), boxes: Vec::new(), margins: Vec::new() };
    let (w, h) = placer.nodes(&chart.program.nodes, (0.0, 0.0), None);
    (placer.sheet.width, placer.sheet.height) = (w.max(LEAST), h);
    placer.tracks();
    placer.sheet
}

struct Placer<'a, 'b> {
    chart: &'a Chart<'b>,
    flows: &'a [Flow],
    layouts: &'a [Layout],
    sheet: Sheet,
    /// The box of each graph, and the first line of its head.
    boxes: Vec<(Rect, f64)>,
    /// Loops (`None`: the program) with the left edge of their margin.
    margins: Vec<(Option<usize>, f64)>,
}

impl Placer<'_, '_> {
    fn shown(&self) -> impl Iterator<Item = (usize, &Flow)> {
        self.flows.iter().enumerate().filter(|(_, flow)| flow.delay != Delay::NextStep)
    }

    /// Flows that have their track in a loop.
    fn at_home(&self, home: Option<usize>) -> Vec<usize> {
        self.shown().filter(|(_, flow)| flow.home == home).map(|(number, _)| number).collect()
    }

    /// Places some parts of a loop, one below another; returns width and height with the margin around.
    fn nodes(&mut self, nodes: &[ProgramNode], (x, y): (f64, f64), home: Option<usize>) -> (f64, f64) {
        let left = x + MARGIN + TRACK * self.at_home(home).len() as f64;
        self.margins.push((home, x));
        let (mut width, mut below): (f64, f64) = (LEAST, y + MARGIN);
        for node in nodes {
            let (w, h) = match node {
                ProgramNode::Graph(_) => self.graph((left, below)),
                ProgramNode::Loop(it) => {
                    let number = self.sheet.frames.len();
                    let caption = it.title();
                    self.sheet.frames.push(Frame { rect: Rect::default(), caption, round: true });
                    let loops = self.sheet.frames.iter().filter(|frame| frame.round).count() - 1;
                    let (w, h) = self.nodes(&it.body, (left, below + CAPTION), Some(loops));
                    let rect = Rect { x: left, y: below, w, h: h + CAPTION };
                    self.sheet.frames[number].rect = rect;
                    (w, rect.h)
                }
            };
            (width, below) = (width.max(w), below + h + MARGIN);
        }
        (left - x + width + MARGIN, below - y)
    }

    /// Places a graph: caption, head, picture, and below it what leaves it. One that passes nothing on has no box if it is alone.
    fn graph(&mut self, (x, y): (f64, f64)) -> (f64, f64) {
        let number = self.boxes.len();
        let layout = &self.layouts[number];
        let w = layout.width.max(LEAST);
        let coming = self.shown().filter(|(_, flow)| flow.to == number);
        let lines: usize = coming.map(|(_, flow)| self.head(flow, w).len()).sum();
        let leaving = self.shown().filter(|(_, flow)| flow.from == number).count();
        let framed = self.chart.several() || leaving > 0;
        let caption = if framed { CAPTION } else { 0.0 };
        let head = if lines > 0 { LINE * lines as f64 + 6.0 } else { 0.0 };
        let rect = Rect { x, y, w, h: caption + head + layout.height + OUT * leaving as f64 };
        self.boxes.push((rect, y + caption + LINE));
        self.sheet.origins.push((x, y + caption + head));
        if framed {
            let caption = format!("graph {}", self.chart.name(number));
            self.sheet.frames.push(Frame { rect, caption, round: false });
        }
        (rect.w, rect.h)
    }

    /// What a flow brings, in lines that fit a width.
    fn head(&self, flow: &Flow, width: f64) -> Vec<String> {
        let from = self.chart.name(flow.from);
        let of = match (flow.delay, self.chart.several()) {
            (Delay::NextRound, true) => format!("from {from}, the round before:"),
            (Delay::NextRound, false) => "from the round before:".to_owned(),
            _ => format!("from {from}:"),
        };
        let most = ((width - 30.0) / LETTER) as usize;
        let mut lines = vec![of];
        for name in names(&flow.labels).split(' ') {
            let last = lines.len() - 1;
            if lines[last].len() + name.len() < most {
                lines[last] += &format!(" {name}");
            } else {
                lines.push(name.to_owned());
            }
        }
        lines
    }

    /// Ways of all flows.
    fn tracks(&mut self) {
        let mut left_of = vec![0; self.boxes.len()];
        let mut line_of = vec![0; self.boxes.len()];
        let mut tracks = Vec::new();
        for (number, flow) in self.shown() {
            let ((source, _), (target, first)) = (self.boxes[flow.from], self.boxes[flow.to]);
            let home = self.margins.iter().find(|(home, _)| *home == flow.home).map_or(0.0, |(_, x)| *x);
            let place = self.at_home(flow.home).iter().position(|&it| it == number).unwrap_or(0);
            let x = home + MARGIN + TRACK * (place as f64 - 0.2);
            left_of[flow.from] += 1;
            let from = source.y + source.h - OUT * left_of[flow.from] as f64;
            let to = first + LINE * line_of[flow.to] as f64;
            let lines = self.head(flow, target.w);
            line_of[flow.to] += lines.len();
            let points = vec![(source.x, from), (x, from), (x, to - 3.5), (target.x + 8.0, to - 3.5)];
            tracks.push(Track { flow: number, points, text: (target.x + 12.0, to, lines) });
        }
        self.sheet.tracks = tracks;
    }
}
