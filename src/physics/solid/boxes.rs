//! Whether a whole box lies inside of a solid, or outside: what spares to ask for each of its points.
use super::{Bounds, Solid, dot, sub};

/// How far rounding may move a distance, against the lengths from which it is made.
const ROUNDING: f64 = 1e-9;

impl Solid {
    /// Whether all points of a box lie inside (`Some(true)`) or none (`Some(false)`), as [`Solid::contains`] says of each of them;
    /// `None` if that cannot be told.
    pub fn holds(&self, (lower, upper): Bounds) -> Option<bool> {
        match self {
            // comparisons, and sums of what grows with a coordinate, keep their order when they are rounded
            Solid::Box { lower: from, upper: to } => {
                let inside = (0..3).all(|a| from[a] <= lower[a] && upper[a] <= to[a]);
                let outside = (0..3).any(|a| upper[a] < from[a] || to[a] < lower[a]);
                if inside { Some(true) } else { outside.then_some(false) }
            }
            Solid::Sphere { center, radius } => {
                let ends = [sub(lower, *center), sub(upper, *center)];
                let far = [0, 1, 2].map(|a| ends[0][a].abs().max(ends[1][a].abs()));
                let near = [0, 1, 2].map(|a| ends[0][a].max(-ends[1][a]).max(0.0));
                let square = radius * radius;
                if dot(far, far) <= square { Some(true) } else { (dot(near, near) > square).then_some(false) }
            }
            Solid::HalfSpace { point, normal } => {
                let corner = |out: bool| -> [f64; 3] {
                    std::array::from_fn(|a| if (normal[a] > 0.0) == out { upper[a] } else { lower[a] })
                };
                let above = |corner: [f64; 3]| dot(sub(corner, *point), *normal);
                if above(corner(true)) <= 0.0 {
                    Some(true)
                } else {
                    (above(corner(false)) > 0.0).then_some(false)
                }
            }
            Solid::Cone { .. } | Solid::Capsule { .. } | Solid::Mesh(_) => self.holds_ball((lower, upper)),
            Solid::Union(solids) => {
                let mut all = solids.iter().map(|solid| solid.holds((lower, upper)));
                any_or_all(&mut all, true)
            }
            Solid::Intersection(solids) => {
                let mut all = solids.iter().map(|solid| solid.holds((lower, upper)));
                any_or_all(&mut all, false)
            }
            Solid::Difference(solid, others) => {
                let rest = others.iter().map(|other| other.holds((lower, upper)).map(|inside| !inside));
                any_or_all(&mut std::iter::once(solid.holds((lower, upper))).chain(rest), false)
            }
            Solid::Translate { by, solid } => solid.holds((sub(lower, *by), sub(upper, *by))),
            Solid::Rotate { rotation, about, solid } => {
                let (middle, half) = halves((lower, upper));
                let r = sub(middle, *about);
                let back = |i: usize| (0..3).map(|j| rotation[j][i] * r[j]).sum::<f64>();
                let middle: [f64; 3] = std::array::from_fn(|i| about[i] + back(i));
                let slack = ROUNDING * (largest(r) + largest(*about));
                let half: [f64; 3] = std::array::from_fn(|i| {
                    (0..3).map(|j| rotation[j][i].abs() * half[j]).sum::<f64>() * (1.0 + ROUNDING) + slack
                });
                let corner = |sign: f64| std::array::from_fn(|a| middle[a] + sign * half[a]);
                solid.holds((corner(-1.0), corner(1.0)))
            }
        }
    }

    /// The same from the distance of the middle: the ball around the box does not reach the surface.
    fn holds_ball(&self, all: Bounds) -> Option<bool> {
        let (middle, half) = halves(all);
        let ((from, to), radius) = (self.bounds(), dot(half, half).sqrt());
        if (0..3).any(|a| all.1[a] < from[a] - radius || to[a] + radius < all.0[a]) {
            return Some(false);
        }
        let distance = self.distance(middle).0;
        let lengths = radius + distance.abs() + largest(middle) + largest(from) + largest(to);
        (distance.abs() > radius + ROUNDING * lengths).then_some(distance < 0.0)
    }
}

/// `Some(one)` if any of them is that, and the opposite if all are.
fn any_or_all(all: &mut impl Iterator<Item = Option<bool>>, one: bool) -> Option<bool> {
    let mut known = true;
    for each in all {
        match each {
            Some(it) if it == one => return Some(one),
            Some(_) => {}
            None => known = false,
        }
    }
    known.then_some(!one)
}

fn halves((lower, upper): Bounds) -> ([f64; 3], [f64; 3]) {
    (
        std::array::from_fn(|a| 0.5 * (lower[a] + upper[a])),
        std::array::from_fn(|a| 0.5 * (upper[a] - lower[a])),
    )
}

fn largest(x: [f64; 3]) -> f64 {
    x.iter().fold(0.0, |most, x| most.max(x.abs()))
}
