//! From where one looks, and what is cut away.
use crate::lab::wound::lateral;
use scene::{Body, Scene};

/// A direction to look from: without perspective.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// What is to the right on the page: a unit vector.
    pub right: [f64; 3],
    /// What is up.
    pub up: [f64; 3],
    /// What is towards the viewer.
    pub toward: [f64; 3],
}

/// Along an axis, or against it.
pub(super) fn unit(axis: usize, sign: f64) -> [f64; 3] {
    let mut v = [0.0; 3];
    v[axis] = sign;
    v
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The component of a vector along another one of length 1.
pub fn along(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

impl View {
    /// From where `toward` points, with `up` up; both of length 1, and not parallel.
    pub(super) fn new(toward: [f64; 3], up: [f64; 3]) -> Self {
        let right = cross(up, toward);
        let length = along(right, right).sqrt();
        let right = right.map(|x| x / length);
        Self { right, up: cross(toward, right), toward }
    }

    /// Along an axis, from its positive side (`sign` 1) or its negative one (-1): z is up, and y where one looks along z.
    pub fn of_axis(axis: usize, sign: f64) -> Self {
        Self::new(unit(axis, sign), unit(if axis == 2 { 1 } else { 2 }, 1.0))
    }

    /// From the corner where all three axes come towards the viewer, y to the back.
    pub fn corner() -> Self {
        let third = 1.0 / 3f64.sqrt();
        Self::new([third, -third, third], unit(2, 1.0))
    }

    /// By its name: `+x`, `-x` and so on, or `corner`.
    pub fn named(name: &str) -> Option<Self> {
        if name == "corner" {
            return Some(Self::corner());
        }
        let (sign, axis) = match name.strip_prefix('-') {
            Some(axis) => (-1.0, axis),
            None => (1.0, name.strip_prefix('+').unwrap_or(name)),
        };
        Some(Self::of_axis(["x", "y", "z"].iter().position(|a| *a == axis)?, sign))
    }

    /// A section of the paper's figure 8: the flight goes down the page.
    pub fn of_shot(axis: usize, direction: f64) -> Self {
        let [across, normal] = lateral(axis);
        let (right, up) = (unit(across, 1.0), unit(axis, -direction));
        let toward = cross(right, up);
        // the section is the same from both sides: the one whose right is the axis itself
        debug_assert!(toward[normal].abs() > 0.5);
        Self { right, up, toward }
    }

    /// Where a point is on the page, from the origin [m]: right and up.
    pub fn place(&self, x: [f64; 3]) -> [f64; 2] {
        [along(x, self.right), along(x, self.up)]
    }
}

/// What is shown of all particles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// All.
    None,
    /// A slice: across which axis, where [m], and half its thickness [m].
    Slice(usize, f64, f64),
    /// What is behind a plane, for who looks: across which axis, and where [m].
    Behind(usize, f64),
}

impl Cut {
    /// Whether a particle is shown.
    pub fn shows(&self, x: [f64; 3], view: &View) -> bool {
        match *self {
            Cut::None => true,
            Cut::Slice(axis, at, half) => (x[axis] - at).abs() <= half,
            Cut::Behind(axis, at) => (x[axis] - at) * view.toward[axis].signum() <= 0.0,
        }
    }

    /// In words.
    pub fn words(&self) -> String {
        let mm = |x: f64| crate::lab::figure::axis::short(1e3 * x, 4);
        let name = |axis: usize| ["x", "y", "z"][axis];
        match *self {
            Cut::None => String::new(),
            Cut::Slice(axis, at, half) => {
                format!("section at {} = {} mm, {} mm thick", name(axis), mm(at), mm(2.0 * half))
            }
            Cut::Behind(axis, at) => format!("cut at {} = {} mm", name(axis), mm(at)),
        }
    }
}

/// The section that tells most of a scene: along the flight of a shot, through the point of entry; else through the middle of the body
/// that begins fastest, along its way; else across the thinnest axis of the domain, through its middle.
pub fn section(scene: &Scene) -> (View, Cut) {
    let domain = &scene.domain;
    let half = 0.5 * domain.cell;
    if let Some(wound) = &scene.output.wound {
        let [_, normal] = lateral(wound.axis);
        return (View::of_shot(wound.axis, wound.direction), Cut::Slice(normal, wound.center[1], half));
    }
    let speed = |body: &Body| along(body.velocity, body.velocity).sqrt();
    let fastest =
        scene.bodies.iter().max_by(|a, b| speed(a).total_cmp(&speed(b))).filter(|body| speed(body) > 0.0);
    // what flies along an axis is not cut across it
    let flies = |a: usize| fastest.is_some_and(|body| body.velocity[a].abs() > 0.5 * speed(body));
    let axes = (0..3).rev().filter(|&a| !flies(a));
    let thinnest = axes.min_by_key(|&a| domain.cells[a]).unwrap_or(2);
    let center = fastest.map(|body| {
        let (lower, upper) = body.solid.bounds();
        0.5 * (lower[thinnest] + upper[thinnest])
    });
    let (low, high) = (domain.lower[thinnest], 2.0 * middle(scene, thinnest) - domain.lower[thinnest]);
    let at = center.filter(|at| (low..high).contains(at)).unwrap_or_else(|| middle(scene, thinnest));
    (across(thinnest), Cut::Slice(thinnest, at, half))
}

/// A section across an axis, with the first of the others to the right.
pub fn across(axis: usize) -> View {
    View::of_axis(axis, if axis == 1 { -1.0 } else { 1.0 })
}

/// The middle of the domain along an axis [m].
pub fn middle(scene: &Scene, axis: usize) -> f64 {
    let domain = &scene.domain;
    domain.lower[axis] + 0.5 * domain.cells[axis] as f64 * domain.cell
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_right_handed_and_have_names() {
        let names = ["+x", "-x", "+y", "-y", "+z", "-z", "x", "corner"];
        for view in
            names.map(|name| View::named(name).expect("a view")).into_iter().chain([View::of_shot(1, -1.0)])
        {
            let View { right, up, toward } = view;
            let apart = (0..3).map(|i| (cross(right, up)[i] - toward[i]).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-12 && (along(up, up) - 1.0).abs() < 1e-12, "{view:?}");
        }
        assert_eq!((View::named("w"), View::named("+")), (None, None));
        // from above: x to the right, y up; from the front: x to the right, z up
        assert_eq!(View::of_axis(2, 1.0).place([1.0, 2.0, 3.0]), [1.0, 2.0]);
        assert_eq!(View::of_axis(1, -1.0).place([1.0, 2.0, 3.0]), [1.0, 3.0]);
        let corner = View::corner();
        assert!(corner.right[0] > 0.5 && corner.up[2] > 0.5);
    }

    #[test]
    fn what_is_before_the_plane_is_cut_away() {
        let (above, below) = (View::of_axis(2, 1.0), View::of_axis(2, -1.0));
        let cut = Cut::Behind(2, 1.0);
        assert!(cut.shows([0.0, 0.0, 0.5], &above) && !cut.shows([0.0, 0.0, 1.5], &above));
        assert!(!cut.shows([0.0, 0.0, 0.5], &below) && cut.shows([0.0, 0.0, 1.5], &below));
        assert!(Cut::Slice(0, 1e-3, 1e-3).words().contains("x = 1 mm, 2 mm thick"));
    }
}
