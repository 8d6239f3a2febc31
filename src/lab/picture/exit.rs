//! The surface of exit, as in the paper's figure 10.
use super::view::{View, unit};
use crate::lab::wound::{attached, lateral, spacing, tissue};
use crate::output::frame::Frame;
use scene::{Scene, Wound};

/// Seen against the flight.
pub fn view(wound: &Wound) -> View {
    let [_, up] = lateral(wound.axis);
    View::new(unit(wound.axis, wound.direction), unit(up, 1.0))
}

/// How much light each particle has, in the order of the frame: tissue inside the tract less, loose spray and a projectile
/// that has left none, which are not shown. And what to say of it. The first frame tells what is loose.
pub fn lights(
    frame: &dyn Frame,
    first: Option<&dyn Frame>,
    scene: &Scene,
    wound: &Wound,
) -> (Vec<f64>, &'static str) {
    let thickness = (wound.surfaces[1] - wound.surfaces[0]).abs();
    let target = tissue(wound, first, frame);
    let reach = thickness.max(20.0 * spacing(scene, wound.target));
    let mut shown = attached(&target, 2.0 * spacing(scene, wound.target), reach).into_iter();
    let materials = frame.materials();
    let depth = |x: [f64; 3]| wound.direction * (x[wound.axis] - wound.surfaces[0]);
    let positions: Vec<[f64; 3]> = frame.positions().into_iter().map(|x| x.map(f64::from)).collect();
    let projectile = |&i: &usize| usize::from(materials[i]) == wound.projectile;
    let tail = (0..positions.len()).filter(projectile).map(|i| depth(positions[i]));
    let left = tail.fold(f64::INFINITY, f64::min) > thickness;
    let light = |(i, x): (usize, &[f64; 3])| {
        let material = usize::from(materials[i]);
        // one answer a target particle, in the order of the frame
        let visible = match material == wound.target {
            true => shown.next().unwrap_or(false),
            false => material != wound.projectile || !left,
        };
        let inside = ((thickness - depth(*x)) / thickness).clamp(0.0, 1.0);
        if visible { 1.0 - 0.62 * inside } else { 0.0 }
    };
    let lights = positions.iter().enumerate().map(light).collect();
    let note = match left {
        true => "exit face, seen against the flight; spray and projectile hidden",
        false => "exit face, seen against the flight; spray hidden",
    };
    (lights, note)
}
