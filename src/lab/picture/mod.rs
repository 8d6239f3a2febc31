//! Pictures of particles: sections as in the paper's figure 8, the exit as in figure 10, any field from any side.
mod canvas;
mod exit;
mod ink;
mod legend;
mod sheet;
mod span;
mod tools;
pub mod view;

pub use ink::{Coloring, Palette, Part};
pub use span::Span;
pub use view::{Cut, View};

use super::figure::colors::{MATERIALS, TOOL, shade};
use super::figure::{Color, Figure, Raster};
use super::wound::{scalars, spacing};
use crate::output::frame::Frame;
use canvas::Canvas;
use legend::Legend;
use scene::Scene;
use sheet::{Panel, Sheet, Window};
use std::collections::HashSet;

/// Radius of a particle in spacings: neighbors on a square lattice just cover what is behind them.
const BALL: f64 = 0.72;

/// What is to be drawn.
#[derive(Clone, Debug)]
pub struct Request {
    /// From where.
    pub view: View,
    /// What of it.
    pub cut: Cut,
    /// Whether it is the face of exit, of which the spray is not shown.
    pub exit: bool,
    /// What colors show: a row of panels each.
    pub colorings: Vec<Coloring>,
    /// Materials that are drawn; empty: all.
    pub only: Vec<usize>,
    /// Colors of failure.
    pub palette: Palette,
    /// From which number to which colors go; none: as particles have them.
    pub span: Option<[f64; 2]>,
    /// Width of the figure [mm].
    pub width: f64,
    /// Pixels an inch, of the particles in an SVG, too.
    pub dpi: f64,
}

impl Request {
    /// The section that tells most of a scene, colored by what its frames tell.
    pub fn section(scene: &Scene, coloring: Coloring) -> Self {
        let (view, cut) = view::section(scene);
        let (palette, width, dpi) = (Palette::default(), 160.0, 160.0);
        let only = Vec::new();
        Self { view, cut, exit: false, colorings: vec![coloring], only, palette, span: None, width, dpi }
    }

    /// The surface of exit of a shot; `None` if the scene is none.
    pub fn exit(scene: &Scene, coloring: Coloring) -> Option<Self> {
        let view = exit::view(scene.output.wound.as_ref()?);
        Some(Self { view, cut: Cut::None, exit: true, ..Self::section(scene, coloring) })
    }
}

/// A frame, with the first of its run, and the scene.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The frame.
    pub frame: &'a dyn Frame,
    /// The first one, which tells what is loose.
    pub first: Option<&'a dyn Frame>,
    /// The scene.
    pub scene: &'a Scene,
}

/// A particle that is drawn.
struct Ball {
    of: Of,
    /// Where it is on the page, from the origin: right and up [m].
    place: [f64; 2],
    /// How near it is to the viewer [m].
    near: f64,
    /// [m]
    radius: f64,
    light: f64,
}

/// What a ball shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Of {
    /// A particle, by its place in the frame.
    Particle(usize),
    /// A part of a tool without particles, of a material.
    Tool(usize),
}

impl Ball {
    fn particle(&self) -> Option<usize> {
        if let Of::Particle(index) = self.of { Some(index) } else { None }
    }
}

/// Frames, with what is seen of each and what to say of it.
pub struct Sight<'a> {
    subjects: &'a [Subject<'a>],
    seen: Vec<(Vec<Ball>, &'static str)>,
}

impl<'a> Sight<'a> {
    /// Looks at frames.
    pub fn of(request: &Request, subjects: &'a [Subject<'a>]) -> Self {
        Self { subjects, seen: subjects.iter().map(|subject| balls(request, *subject)).collect() }
    }
}

/// What all frames of a picture or a film have together: the box that is shown, and from where to where colors go.
#[derive(Clone, Debug)]
pub struct Survey {
    window: Option<Window>,
    tools: Option<Window>,
    spans: Vec<Span>,
}

impl Survey {
    /// Of no frame yet.
    pub fn new(request: &Request) -> Self {
        Self { window: None, tools: None, spans: vec![Span::NOTHING; request.colorings.len()] }
    }

    /// With more frames.
    pub fn add(&mut self, request: &Request, sight: &Sight<'_>) {
        for (subject, (balls, _)) in sight.subjects.iter().zip(&sight.seen) {
            self.add_frame(request, *subject, balls);
        }
    }

    fn add_frame(&mut self, request: &Request, subject: Subject<'_>, balls: &[Ball]) {
        for ball in balls {
            let window = if ball.particle().is_some() { &mut self.window } else { &mut self.tools };
            let window = window.get_or_insert(Window { low: ball.place, high: ball.place });
            *window = window.with(ball.place, ball.radius);
        }
        for (span, coloring) in self.spans.iter_mut().zip(&request.colorings) {
            let own = coloring.span(subject.frame, balls.iter().filter_map(Ball::particle));
            *span = match request.span {
                Some([low, high]) => Span { low, high, beyond: [own.low < low, own.high > high] },
                None => span.with(own),
            };
        }
    }

    /// Whether there is nothing to see.
    pub fn is_empty(&self) -> bool {
        self.window.is_none() && self.tools.is_none()
    }

    /// The box that is shown; that of the domain, if there is nothing.
    fn window(&self, request: &Request, scene: &Scene) -> Window {
        let domain = &scene.domain;
        let corner = |n: usize| {
            let end = |a: usize| if n >> a & 1 == 1 { domain.cells[a] as f64 * domain.cell } else { 0.0 };
            request.view.place([0, 1, 2].map(|a| domain.lower[a] + end(a)))
        };
        let window = match (self.window, self.tools) {
            (Some(window), Some(tools)) => Some(window.towards(tools)),
            (window, tools) => window.or(tools),
        };
        window.unwrap_or_else(|| {
            let first = Window { low: corner(0), high: corner(0) };
            (1..8).fold(first, |window, n| window.with(corner(n), 0.0))
        })
    }
}

/// Frames beside one another, a row of them for each coloring.
///
/// # Errors
/// If the figure is too narrow for its legend, or too large.
pub fn draw(request: &Request, subjects: &[Subject<'_>]) -> Result<Figure, String> {
    let (mut survey, sight) = (Survey::new(request), Sight::of(request, subjects));
    survey.add(request, &sight);
    draw_with(request, &survey, &sight)
}

/// The same in the window and with the colors of a survey.
///
/// # Errors
/// As [`draw`].
pub fn draw_with(request: &Request, survey: &Survey, sight: &Sight<'_>) -> Result<Figure, String> {
    let Sight { subjects, seen: shown } = sight;
    let Some(Subject { scene, .. }) = subjects.first() else { return Err("there is no frame".into()) };
    let window = survey.window(request, scene);
    let inked = |coloring, span| {
        subjects.iter().zip(shown).map(move |(it, (balls, _))| {
            let drawn: HashSet<usize> = balls.iter().filter_map(Ball::particle).collect();
            ink::ink(it.frame, it.scene, coloring, (span, request.palette), |i| drawn.contains(&i))
        })
    };
    let rows =
        request.colorings.iter().zip(&survey.spans).map(|(coloring, span)| inked(coloring, *span).unzip());
    let rows: Vec<(Vec<Vec<Color>>, Vec<Legend>)> = rows.collect();
    let legends: Vec<Option<Legend>> = rows.iter().map(|(_, legends)| legends.last().cloned()).collect();
    let times: Vec<f64> = subjects.iter().map(|subject| subject.frame.time()).collect();
    let mut sheet = Sheet::new(request, window, &legends, times.len())?;
    let rows = rows.iter().zip(&request.colorings).flat_map(|((colors, _), coloring)| {
        let tool = |material: usize| match coloring {
            Coloring::Material => MATERIALS[material % MATERIALS.len()],
            _ => TOOL,
        };
        let panels = colors.iter().zip(shown);
        panels.map(|(colors, (balls, _))| panel(&sheet.panel, balls, colors, tool)).collect::<Vec<_>>()
    });
    let panels = rows.collect();
    let levels = scene.output.wound.iter().flat_map(|wound| wound.surfaces.map(|at| (wound.axis, at)));
    sheet.panels(panels, &times, &levels.collect::<Vec<_>>());
    let title = if scene.title.is_empty() { &scene.name } else { &scene.title };
    let note = shown.last().map_or("", |(_, note)| *note);
    let note = if note.is_empty() { request.cut.words() } else { note.to_owned() };
    Ok(sheet.finish(title, &note, &times, legends))
}

/// The particles that are shown, and what to say of it.
fn balls(request: &Request, subject: Subject<'_>) -> (Vec<Ball>, &'static str) {
    let Subject { frame, first, scene } = subject;
    let wound = scene.output.wound.as_ref().filter(|_| request.exit);
    let lights = wound.map(|wound| exit::lights(frame, first, scene, wound));
    let sizes: Vec<f64> =
        (0..scene.materials.len()).map(|material| BALL * spacing(scene, material)).collect();
    let (materials, volume) = (frame.materials(), scalars(frame, "volume_ratio").unwrap_or_default());
    // what collapsed or blew up is still a particle that one can see
    let grown = |i: usize| {
        volume.get(i).filter(|j| j.is_finite()).map_or(1.0, |j| f64::from(*j).clamp(0.1, 8.0).cbrt())
    };
    let ball = |(index, x): (usize, [f32; 3])| {
        let x = x.map(f64::from);
        let light = lights.as_ref().map_or(1.0, |(lights, _)| lights[index]);
        let wanted = request.only.is_empty() || request.only.contains(&usize::from(materials[index]));
        let shown =
            wanted && light > 0.0 && x.iter().all(|x| x.is_finite()) && request.cut.shows(x, &request.view);
        let size = sizes.get(usize::from(materials[index])).or(sizes.first()).copied().unwrap_or(0.0);
        shown.then(|| Ball {
            of: Of::Particle(index),
            place: request.view.place(x),
            near: view::along(x, request.view.toward),
            radius: size * grown(index),
            light,
        })
    };
    let mut balls: Vec<Ball> = frame.positions().into_iter().enumerate().filter_map(ball).collect();
    let points = tools::points(scene, frame.time(), |x| request.cut.shows(x, &request.view));
    let wanted = |material: usize| request.only.is_empty() || request.only.contains(&material);
    let points = points.into_iter().filter(|(material, ..)| wanted(*material));
    balls.extend(points.map(|(material, x, half)| Ball {
        of: Of::Tool(material),
        place: request.view.place(x),
        near: view::along(x, request.view.toward),
        radius: 2.0 * BALL * half,
        light: 1.0,
    }));
    (balls, lights.map_or("", |(_, note)| note))
}

/// The balls of a frame as pixels, nearest last.
fn panel(panel: &Panel, balls: &[Ball], colors: &[Color], tool: impl Fn(usize) -> Color) -> Raster {
    let mut balls: Vec<&Ball> = balls.iter().collect();
    balls.sort_by(|a, b| a.near.total_cmp(&b.near));
    let mut canvas = Canvas::new(panel.pixels);
    for ball in balls {
        let radius = (ball.radius * panel.scale).max(0.9);
        let color = match ball.of {
            Of::Particle(index) => colors[index],
            Of::Tool(material) => tool(material),
        };
        let color = shade(color, ball.light);
        canvas.ball(panel.place(ball.place), ball.near * panel.scale, radius, color);
    }
    canvas.into_raster()
}
