//! Solids: whether a point lies inside, how far it is from the surface, and a box around them. All lengths in meters.
mod boxes;
mod distance;
pub mod mesh;

use mesh::Mesh;

/// A solid. Surfaces belong to it.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // what the fields mean is said at each solid
pub enum Solid {
    /// Axis-aligned box between two corners [m].
    Box { lower: [f64; 3], upper: [f64; 3] },
    /// Ball [m].
    Sphere { center: [f64; 3], radius: f64 },
    /// Frustum between two discs with centers `ends` and `radii` [m]; equal radii make a cylinder.
    Cone { ends: [[f64; 3]; 2], radii: [f64; 2] },
    /// All points within `radius` of the segment between `ends` [m].
    Capsule { ends: [[f64; 3]; 2], radius: f64 },
    /// All points behind the plane through `point` [m] with the outward unit vector `normal`.
    HalfSpace { point: [f64; 3], normal: [f64; 3] },
    /// What a closed surface of triangles bounds.
    Mesh(Mesh),
    /// What lies in any.
    Union(Vec<Solid>),
    /// What lies in all.
    Intersection(Vec<Solid>),
    /// What lies in the first and in none of the others.
    Difference(Box<Solid>, Vec<Solid>),
    /// The solid moved by a vector [m].
    Translate { by: [f64; 3], solid: Box<Solid> },
    /// The solid turned about `about` [m] by a rotation matrix, rows first.
    Rotate { rotation: [[f64; 3]; 3], about: [f64; 3], solid: Box<Solid> },
}

/// A box between two corners [m]; infinite where a solid is unbounded, lower above upper where it is empty.
pub type Bounds = ([f64; 3], [f64; 3]);

impl Solid {
    /// Whether the point [m] lies inside or on the surface.
    pub fn contains(&self, x: [f64; 3]) -> bool {
        match self {
            Solid::Box { lower, upper } => (0..3).all(|a| lower[a] <= x[a] && x[a] <= upper[a]),
            Solid::Sphere { center, radius } => within(sub(x, *center), *radius),
            Solid::Cone { ends, radii } => {
                let s = along(x, ends);
                let radius = radii[0] + s * (radii[1] - radii[0]);
                (0.0..=1.0).contains(&s) && within(sub(x, between(ends, s)), radius)
            }
            Solid::Capsule { ends, radius } => {
                within(sub(x, between(ends, along(x, ends).clamp(0.0, 1.0))), *radius)
            }
            Solid::HalfSpace { point, normal } => dot(sub(x, *point), *normal) <= 0.0,
            Solid::Mesh(mesh) => mesh.contains(x),
            Solid::Union(solids) => solids.iter().any(|solid| solid.contains(x)),
            Solid::Intersection(solids) => solids.iter().all(|solid| solid.contains(x)),
            Solid::Difference(solid, others) => {
                solid.contains(x) && !others.iter().any(|other| other.contains(x))
            }
            Solid::Translate { by, solid } => solid.contains(sub(x, *by)),
            Solid::Rotate { rotation, about, solid } => {
                let r = sub(x, *about);
                let back = |i: usize| (0..3).map(|j| rotation[j][i] * r[j]).sum::<f64>();
                solid.contains(std::array::from_fn(|i| about[i] + back(i)))
            }
        }
    }

    /// How far it reaches along three axes of its own [m]: turning does not change them. Those of its bounds for set operations.
    pub fn extents(&self) -> [f64; 3] {
        let length = |ends: &[[f64; 3]; 2]| dot(sub(ends[1], ends[0]), sub(ends[1], ends[0])).sqrt();
        match self {
            Solid::Cone { ends, radii } => {
                let across = 2.0 * radii[0].max(radii[1]);
                [across, across, length(ends)]
            }
            Solid::Capsule { ends, radius } => {
                let across = 2.0 * radius;
                [across, across, length(ends) + across]
            }
            Solid::Translate { solid, .. } | Solid::Rotate { solid, .. } => solid.extents(),
            _ => {
                let (lower, upper) = self.bounds();
                sub(upper, lower)
            }
        }
    }

    /// A box that holds the solid; the smallest one but for rotations and set operations.
    pub fn bounds(&self) -> Bounds {
        match self {
            Solid::Box { lower, upper } => (*lower, *upper),
            Solid::Sphere { center, radius } => around(*center, [*radius; 3]),
            Solid::Cone { ends, radii } => {
                let axis = sub(ends[1], ends[0]);
                let extent = |r: f64| axis.map(|a| r * (1.0 - a * a / dot(axis, axis)).max(0.0).sqrt());
                hull(around(ends[0], extent(radii[0])), around(ends[1], extent(radii[1])))
            }
            Solid::Capsule { ends, radius } => {
                hull(around(ends[0], [*radius; 3]), around(ends[1], [*radius; 3]))
            }
            Solid::HalfSpace { point, normal } => half_space_bounds(*point, *normal),
            Solid::Mesh(mesh) => mesh.bounds(),
            Solid::Union(solids) => solids.iter().map(Solid::bounds).fold(EMPTY, hull),
            Solid::Intersection(solids) => solids.iter().map(Solid::bounds).fold(EVERYTHING, overlap),
            Solid::Difference(solid, _) => solid.bounds(),
            Solid::Translate { by, solid } => {
                let (lower, upper) = solid.bounds();
                (add(lower, *by), add(upper, *by))
            }
            Solid::Rotate { rotation, about, solid } => rotated(solid.bounds(), rotation, *about),
        }
    }

    /// Whether the solid has finite bounds.
    pub fn is_bounded(&self) -> bool {
        let (lower, upper) = self.bounds();
        lower.iter().chain(&upper).all(|x| x.is_finite())
    }
}

const EVERYTHING: Bounds = ([f64::NEG_INFINITY; 3], [f64::INFINITY; 3]);
const EMPTY: Bounds = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);

fn within(r: [f64; 3], radius: f64) -> bool {
    dot(r, r) <= radius * radius
}

/// Where the point projects on the segment: 0 at its first end, 1 at its second.
fn along(x: [f64; 3], ends: &[[f64; 3]; 2]) -> f64 {
    let axis = sub(ends[1], ends[0]);
    dot(sub(x, ends[0]), axis) / dot(axis, axis)
}

fn between(ends: &[[f64; 3]; 2], s: f64) -> [f64; 3] {
    std::array::from_fn(|a| ends[0][a] + s * (ends[1][a] - ends[0][a]))
}

fn around(center: [f64; 3], extent: [f64; 3]) -> Bounds {
    (sub(center, extent), add(center, extent))
}

fn hull(a: Bounds, b: Bounds) -> Bounds {
    (std::array::from_fn(|i| a.0[i].min(b.0[i])), std::array::from_fn(|i| a.1[i].max(b.1[i])))
}

/// The box that two boxes share.
pub fn overlap(a: Bounds, b: Bounds) -> Bounds {
    (std::array::from_fn(|i| a.0[i].max(b.0[i])), std::array::from_fn(|i| a.1[i].min(b.1[i])))
}

/// A half-space ends only along an axis that its normal follows.
fn half_space_bounds(point: [f64; 3], normal: [f64; 3]) -> Bounds {
    let (mut lower, mut upper) = EVERYTHING;
    for a in 0..3 {
        let others = (0..3).filter(|&b| b != a).all(|b| normal[b] == 0.0);
        match others {
            true if normal[a] > 0.0 => upper[a] = point[a],
            true => lower[a] = point[a],
            false => {}
        }
    }
    (lower, upper)
}

fn rotated(bounds: Bounds, rotation: &[[f64; 3]; 3], about: [f64; 3]) -> Bounds {
    let (lower, upper) = bounds;
    if (0..3).any(|a| lower[a] > upper[a]) {
        return EMPTY;
    }
    if lower.iter().chain(&upper).any(|x| x.is_infinite()) {
        return EVERYTHING;
    }
    let corner = |c: usize| -> [f64; 3] {
        let corner = std::array::from_fn(|a| if c >> a & 1 == 0 { lower[a] } else { upper[a] });
        let r = sub(corner, about);
        std::array::from_fn(|i| about[i] + dot(rotation[i], r))
    };
    (0..8).map(corner).map(|x| (x, x)).fold(EMPTY, hull)
}

/// Rows of the matrix that turns vectors about a unit vector by an angle [rad], right-handed (Rodrigues).
pub fn rotation(axis: [f64; 3], angle: f64) -> [[f64; 3]; 3] {
    let (sin, cos) = angle.sin_cos();
    let unit = |j: usize| std::array::from_fn(|i| f64::from(u8::from(i == j)));
    let column = |j: usize| {
        let (e, turned) = (unit(j), cross(axis, unit(j)));
        std::array::from_fn::<_, 3, _>(|i| cos * e[i] + sin * turned[i] + (1.0 - cos) * axis[j] * axis[i])
    };
    let columns = [column(0), column(1), column(2)];
    std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]))
}

/// a + b
pub fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] + b[i])
}

/// a − b
pub fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

/// a · b
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The unit vector along `a`; `None` if it has no direction.
pub fn direction(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = a.iter().fold(0.0f64, |length, x| length.hypot(*x));
    (length > 0.0 && length.is_finite()).then(|| a.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Volume by counting the centers of small cubes over the bounds.
    fn volume(solid: &Solid) -> f64 {
        let (lower, upper) = solid.bounds();
        let n = 120;
        let h: [f64; 3] = std::array::from_fn(|a| (upper[a] - lower[a]) / n as f64);
        let at = |i: usize, a: usize| lower[a] + (i as f64 + 0.5) * h[a];
        let inside = (0..n * n * n)
            .filter(|i| solid.contains([at(i / (n * n), 0), at(i / n % n, 1), at(i % n, 2)]))
            .count();
        inside as f64 * h[0] * h[1] * h[2]
    }

    fn assert_volume(solid: Solid, exact: f64) {
        let counted = volume(&solid);
        assert!((counted / exact - 1.0).abs() < 5e-3, "{solid:?}: {counted}, not {exact}");
    }

    const ENDS: [[f64; 3]; 2] = [[0.1, 0.2, 0.3], [1.1, 2.2, 2.3]]; // 3 long

    #[test]
    fn volumes_are_those_of_the_closed_forms() {
        assert_volume(Solid::Box { lower: [0.0; 3], upper: [1.0, 2.0, 3.0] }, 6.0);
        assert_volume(Solid::Sphere { center: [1.0, 2.0, 3.0], radius: 2.0 }, 32.0 / 3.0 * PI);
        assert_volume(Solid::Cone { ends: ENDS, radii: [0.5, 0.5] }, 0.75 * PI);
        assert_volume(Solid::Cone { ends: ENDS, radii: [1.0, 0.5] }, 1.75 * PI);
        assert_volume(Solid::Capsule { ends: ENDS, radius: 0.5 }, (0.75 + 1.0 / 6.0) * PI);
    }

    #[test]
    fn sets_and_motions() {
        let ball = |x: f64| Solid::Sphere { center: [x, 0.0, 0.0], radius: 1.0 };
        let lens = 5.0 / 12.0 * PI; // two unit balls, centers 1 apart
        let one = 4.0 / 3.0 * PI;
        assert_volume(Solid::Union(vec![ball(0.0), ball(1.0)]), 2.0 * one - lens);
        assert_volume(Solid::Intersection(vec![ball(0.0), ball(1.0)]), lens);
        assert_volume(Solid::Difference(Box::new(ball(0.0)), vec![ball(1.0)]), one - lens);
        let cut = Solid::HalfSpace { point: [0.0; 3], normal: [0.0, 1.0, 0.0] };
        assert_volume(Solid::Intersection(vec![ball(0.0), cut]), one / 2.0);
        let slab = Solid::Box { lower: [0.0; 3], upper: [1.0, 2.0, 3.0] };
        let turned = Solid::Rotate {
            rotation: rotation([0.0, 0.6, 0.8], 0.7),
            about: [1.0; 3],
            solid: Box::new(Solid::Translate { by: [5.0, 0.0, 0.0], solid: Box::new(slab) }),
        };
        assert_volume(turned, 6.0);
    }

    #[test]
    fn a_rotation_is_right_handed() {
        let solid = Solid::Sphere { center: [1.0, 0.0, 0.0], radius: 0.1 };
        let rotation = rotation([0.0, 0.0, 1.0], PI / 2.0);
        let turned = Solid::Rotate { rotation, about: [0.0; 3], solid: Box::new(solid) };
        assert!(turned.contains([0.0, 1.0, 0.0]) && !turned.contains([0.0, -1.0, 0.0]));
    }

    #[test]
    fn half_spaces_are_unbounded() {
        let solid = Solid::HalfSpace { point: [0.0; 3], normal: [0.0, 1.0, 0.0] };
        assert!(!solid.is_bounded() && solid.contains([1e9, 0.0, 0.0]) && !solid.contains([0.0, 1e-9, 0.0]));
        assert_eq!(solid.bounds().1[1], 0.0);
    }
}
