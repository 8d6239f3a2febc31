//! Tools are shapes without particles: pictures show balls that fill them where they are.
use scene::{Behavior, RigidMotion, Scene};
use std::array::from_fn;

/// Points that are tried for a tool: more would take longer than all particles of a frame.
const MOST: f64 = 2e6;

/// Points in the tools that have no particles, within the domain at a time [s]: the material of each, and half the distance between
/// them [m].
pub fn points(scene: &Scene, time: f64, shows: impl Fn([f64; 3]) -> bool) -> Vec<(usize, [f64; 3], f64)> {
    let mut points = Vec::new();
    for (number, material) in scene.materials.iter().enumerate() {
        let Behavior::Rigid(RigidMotion::Prescribed { course, spin, center, visible: false }) =
            &material.behavior
        else {
            continue;
        };
        let shape = scene.shape(number);
        let center = center.unwrap_or_else(|| tasks::recipes::middle(&shape));
        let (way, angles) = (course.way(0.0, time), spin.integral(0.0, time));
        // back to where it was at the start
        let back = physics::motion::rotation(angles.map(|angle| -angle));
        let start = |x: [f64; 3]| -> [f64; 3] {
            let r: [f64; 3] = from_fn(|a| x[a] - way[a] - center[a]);
            from_fn(|i| center[i] + (0..3).map(|j| back[3 * i + j] * r[j]).sum::<f64>())
        };
        let domain = &scene.domain;
        let size = domain.cells.map(|cells| cells as f64 * domain.cell);
        let volume: f64 = size.iter().product();
        let step = (0.5 * domain.cell).max((volume / MOST).cbrt());
        let counts = size.map(|length| (length / step).ceil() as usize);
        for i in 0..counts[0] {
            for j in 0..counts[1] {
                for k in 0..counts[2] {
                    let at: [f64; 3] = from_fn(|a| domain.lower[a] + ([i, j, k][a] as f64 + 0.5) * step);
                    if shows(at) && shape.contains(start(at)) {
                        points.push((number, at, 0.5 * step));
                    }
                }
            }
        }
    }
    points
}
