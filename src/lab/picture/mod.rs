//! Pictures of particles: the section along the tract as in the paper's figure 8, the exit as in figure 10.
mod canvas;
mod font;
mod ink;
mod sheet;

pub use canvas::{Canvas, Color};
pub use ink::Coloring;

use super::wound::{attached, lateral, spacing, tissue};
use crate::output::frame::Frame;
use canvas::shade;
use ink::Ink;
use scene::Scene;
use sheet::{Sheet, Window};

/// Radius of a particle in spacings: neighbors on a square lattice just cover what is behind them.
const BALL: f64 = 0.72;

/// A section one cell thick. In the scene of a shot: along the flight, through the point of entry, flight downwards;
/// else across the thinnest axis of the domain, through its middle.
pub fn section(frame: &dyn Frame, scene: &Scene, coloring: Coloring) -> Canvas {
    let domain = &scene.domain;
    let low = domain.lower;
    let high = [0, 1, 2].map(|a| low[a] + domain.cells[a] as f64 * domain.cell);
    let thinnest = (0..3).rev().min_by_key(|&a| domain.cells[a]).unwrap_or(2);
    let (normal, plane, window) = match &scene.output.wound {
        Some(wound) => {
            let [across, normal] = lateral(wound.axis);
            let window = Window { across: (across, 1.0), up: (wound.axis, -wound.direction), low, high };
            (normal, wound.center[1], window)
        }
        None => {
            let [across, up] = lateral(thinnest);
            let window = Window { across: (across, 1.0), up: (up, 1.0), low, high };
            (thinnest, 0.5 * (low[thinnest] + high[thinnest]), window)
        }
    };
    let mut sheet = Sheet::new(window);
    for &surface in scene.output.wound.iter().flat_map(|wound| &wound.surfaces) {
        sheet.level(surface);
    }
    let half = 0.5 * domain.cell;
    let pick = |x: [f64; 3]| ((x[normal] - plane).abs() <= half).then_some((x[normal], 1.0));
    let axis = ["x", "y", "z"][normal];
    let subtitle = format!("section at {axis} = {:.2} mm, {:.2} mm thick", 1e3 * plane, 2e3 * half);
    draw(&mut sheet, frame, scene, coloring, |_, x| pick(x));
    finish(sheet, frame, scene, &subtitle)
}

/// The surface of exit, seen against the flight; tissue inside the tract is darker, loose spray and a projectile
/// that has left are not shown. Needs the first frame to know what is loose. `None` if the scene is no shot.
pub fn exit_face(
    frame: &dyn Frame,
    first: Option<&dyn Frame>,
    scene: &Scene,
    coloring: Coloring,
) -> Option<Canvas> {
    let wound = scene.output.wound.as_ref()?;
    let domain = &scene.domain;
    let low = domain.lower;
    let high = [0, 1, 2].map(|a| low[a] + domain.cells[a] as f64 * domain.cell);
    let [across, up] = lateral(wound.axis);
    // The page's right, its up and the way to the viewer are right-handed.
    let hand = if wound.axis == 1 { -wound.direction } else { wound.direction };
    let mut sheet = Sheet::new(Window { across: (across, hand), up: (up, 1.0), low, high });

    let thickness = (wound.surfaces[1] - wound.surfaces[0]).abs();
    let target = tissue(wound, first, frame);
    let reach = thickness.max(20.0 * spacing(scene, wound.target));
    let mut shown = attached(&target, 2.0 * spacing(scene, wound.target), reach).into_iter();
    let materials = frame.materials();
    let depth = |x: [f64; 3]| wound.direction * (x[wound.axis] - wound.surfaces[0]);
    let positions = frame.positions();
    let projectile = |&i: &usize| usize::from(materials[i]) == wound.projectile;
    let tail = (0..positions.len()).filter(projectile).map(|i| depth(positions[i].map(f64::from)));
    let left = tail.fold(f64::INFINITY, f64::min) > thickness;
    draw(&mut sheet, frame, scene, coloring, |i, x| {
        let material = usize::from(materials[i]);
        // One answer a target particle, in the order of the frame.
        let visible =
            if material == wound.target { shown.next()? } else { material != wound.projectile || !left };
        let inside = ((thickness - depth(x)) / thickness).clamp(0.0, 1.0);
        visible.then_some((depth(x), 1.0 - 0.62 * inside))
    });
    let note = if left {
        "exit face, seen against the flight; spray and projectile hidden"
    } else {
        "exit face, seen against the flight; spray hidden"
    };
    Some(finish(sheet, frame, scene, note))
}

/// Draws the particles for which `pick(index, position)` gives nearness to the viewer [m] and light, nearest last.
fn draw(
    sheet: &mut Sheet,
    frame: &dyn Frame,
    scene: &Scene,
    coloring: Coloring,
    mut pick: impl FnMut(usize, [f64; 3]) -> Option<(f64, f64)>,
) {
    let ink = Ink::new(frame, scene, coloring);
    let materials = frame.materials();
    let radii: Vec<f64> = (0..scene.materials.len().max(1))
        .map(|material| (BALL * spacing(scene, material) * sheet.scale).max(0.9))
        .collect();
    let mut picked: Vec<_> = frame
        .positions()
        .iter()
        .enumerate()
        .filter_map(|(i, x)| {
            let x = x.map(f64::from);
            let (nearness, light) = pick(i, x)?;
            sheet.shows(x).then_some((nearness, i, x, light))
        })
        .collect();
    picked.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (near, i, x, light) in picked {
        let radius = radii.get(usize::from(materials[i])).copied().unwrap_or(radii[0]);
        let center = sheet.place(x);
        sheet.canvas.ball(center, near * sheet.scale, radius, shade(ink.colors[i], light));
    }
    sheet.legend(&ink.legend);
}

fn finish(mut sheet: Sheet, frame: &dyn Frame, scene: &Scene, subtitle: &str) -> Canvas {
    let title = if scene.title.is_empty() { &scene.name } else { &scene.title };
    sheet.title(title, subtitle, frame.time());
    sheet.canvas
}
