//! Signed distances of solids.
use super::{Solid, add, between, direction, dot, sub};

/// Distance from the surface [m], negative inside, and its gradient: the unit normal that points out.
pub type Distance = (f64, [f64; 3]);

impl Solid {
    /// Signed distance from the surface.
    ///
    /// Exact for boxes, balls, cones, cylinders, capsules, half-spaces and meshes, moved and turned ones too. Of unions it is exact outside, of
    /// intersections and differences inside; on the other side it is a bound: the surface is at least so far, and just so far
    /// wherever the nearest point of it belongs to one of the solids alone.
    pub fn distance(&self, x: [f64; 3]) -> Distance {
        match self {
            Solid::Box { lower, upper } => of_box(x, *lower, *upper),
            Solid::Sphere { center, radius } => from_point(x, *center, *radius, [0.0, 0.0, 1.0]),
            Solid::Cone { ends, radii } => of_cone(x, ends, *radii),
            Solid::Capsule { ends, radius } => {
                let axis = sub(ends[1], ends[0]);
                let s = super::along(x, ends).clamp(0.0, 1.0);
                from_point(x, between(ends, s), *radius, across(axis))
            }
            Solid::HalfSpace { point, normal } => (dot(sub(x, *point), *normal), *normal),
            Solid::Mesh(mesh) => mesh.distance(x),
            Solid::Union(solids) => {
                let all = solids.iter().map(|solid| solid.distance(x));
                all.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, [0.0; 3]))
            }
            Solid::Intersection(solids) => largest(solids.iter().map(|solid| solid.distance(x))),
            Solid::Difference(solid, others) => {
                let outside = others.iter().map(|other| {
                    let (distance, normal) = other.distance(x);
                    (-distance, normal.map(|n| -n))
                });
                largest(std::iter::once(solid.distance(x)).chain(outside))
            }
            Solid::Translate { by, solid } => solid.distance(sub(x, *by)),
            Solid::Rotate { rotation, about, solid } => {
                let r = sub(x, *about);
                let back = |i: usize| (0..3).map(|j| rotation[j][i] * r[j]).sum::<f64>();
                let (distance, normal) = solid.distance(add(*about, std::array::from_fn(back)));
                (distance, std::array::from_fn(|i| dot(rotation[i], normal)))
            }
        }
    }
}

fn largest(all: impl Iterator<Item = Distance>) -> Distance {
    all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::NEG_INFINITY, [0.0; 3]))
}

/// Distance from a ball; `any`: a normal for its center.
fn from_point(x: [f64; 3], center: [f64; 3], radius: f64, any: [f64; 3]) -> Distance {
    let r = sub(x, center);
    (dot(r, r).sqrt() - radius, direction(r).unwrap_or(any))
}

/// A unit vector across another vector.
fn across(axis: [f64; 3]) -> [f64; 3] {
    let least = (0..3).min_by(|&a, &b| axis[a].abs().total_cmp(&axis[b].abs())).unwrap_or(0);
    let other = std::array::from_fn(|a| if a == least { 1.0 } else { 0.0 });
    direction(super::cross(axis, other)).unwrap_or([0.0, 0.0, 1.0])
}

fn of_box(x: [f64; 3], lower: [f64; 3], upper: [f64; 3]) -> Distance {
    let half: [f64; 3] = std::array::from_fn(|a| 0.5 * (upper[a] - lower[a]));
    let r: [f64; 3] = std::array::from_fn(|a| x[a] - 0.5 * (upper[a] + lower[a]));
    let beyond: [f64; 3] = std::array::from_fn(|a| r[a].abs() - half[a]);
    let outside = beyond.map(|b| b.max(0.0));
    let length = dot(outside, outside).sqrt();
    if length > 0.0 {
        return (length, std::array::from_fn(|a| outside[a] / length * r[a].signum()));
    }
    let nearest = (0..3).max_by(|&a, &b| beyond[a].total_cmp(&beyond[b])).unwrap_or(0);
    (beyond[nearest], std::array::from_fn(|a| if a == nearest { r[a].signum() } else { 0.0 }))
}

/// In the plane of axis and point: the distance from the outline of half the section, which has an edge for each disc and the
/// side.
fn of_cone(x: [f64; 3], ends: &[[f64; 3]; 2], radii: [f64; 2]) -> Distance {
    let axis = sub(ends[1], ends[0]);
    let length = dot(axis, axis).sqrt();
    let along = axis.map(|a| a / length);
    let r = sub(x, ends[0]);
    let z = dot(r, along);
    let radial: [f64; 3] = std::array::from_fn(|a| r[a] - z * along[a]);
    let out = direction(radial).unwrap_or_else(|| across(axis));
    let p = [dot(radial, out), z];
    let edges = [
        [[0.0, 0.0], [radii[0], 0.0]],
        [[radii[0], 0.0], [radii[1], length]],
        [[radii[1], length], [0.0, length]],
    ];
    let mut nearest = (f64::INFINITY, [0.0; 2], 0);
    for (n, [a, b]) in edges.into_iter().enumerate() {
        let (edge, from) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let square = edge[0] * edge[0] + edge[1] * edge[1];
        let s = if square > 0.0 { (from[0] * edge[0] + from[1] * edge[1]) / square } else { 0.0 };
        let away = [0, 1].map(|i| from[i] - s.clamp(0.0, 1.0) * edge[i]);
        let distance = away[0].hypot(away[1]);
        if distance < nearest.0 {
            nearest = (distance, away, n);
        }
    }
    let (distance, away, edge) = nearest;
    let slope = [length, radii[0] - radii[1]].map(|c| c / length.hypot(radii[0] - radii[1]));
    let normal = [[0.0, -1.0], slope, [0.0, 1.0]][edge];
    let inside = p[1] >= 0.0 && p[1] <= length && p[0] <= radii[0] + p[1] / length * (radii[1] - radii[0]);
    let sign = if inside { -1.0 } else { 1.0 };
    let [across, up] = if distance > 1e-12 * length { away.map(|a| sign * a / distance) } else { normal };
    (sign * distance, std::array::from_fn(|a| across * out[a] + up * along[a]))
}

#[cfg(test)]
mod tests {
    use super::super::rotation;
    use super::*;

    /// Numbers in [-1, 1) that are the same in every run (SplitMix64).
    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (*seed ^ *seed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ z >> 31) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn solids() -> Vec<(Solid, bool)> {
        let ends = [[0.1, -0.2, -0.4], [0.3, 0.4, 0.5]];
        let slab = Solid::Box { lower: [-0.5, -0.4, -0.1], upper: [0.3, 0.2, 0.4] };
        let ball = Solid::Sphere { center: [0.2, 0.1, -0.1], radius: 0.4 };
        let turned = Solid::Rotate {
            rotation: rotation([0.0, 0.6, 0.8], 0.7),
            about: [0.3; 3],
            solid: Box::new(Solid::Translate { by: [0.1, 0.0, -0.2], solid: Box::new(slab.clone()) }),
        };
        vec![
            (Solid::HalfSpace { point: [0.1; 3], normal: [0.0, 0.6, 0.8] }, true),
            (Solid::Cone { ends, radii: [0.3, 0.3] }, true),
            (Solid::Cone { ends, radii: [0.4, 0.1] }, true),
            (Solid::Cone { ends, radii: [0.0, 0.5] }, true),
            (Solid::Capsule { ends, radius: 0.25 }, true),
            (turned, true),
            (Solid::Union(vec![slab.clone(), ball.clone()]), false),
            (Solid::Intersection(vec![slab.clone(), ball.clone()]), false),
            (Solid::Difference(Box::new(slab.clone()), vec![ball.clone()]), false),
            (slab, true),
            (ball, true),
        ]
    }

    #[test]
    fn the_sign_says_where_a_point_is_and_the_gradient_where_the_surface_is() {
        let mut seed = 7;
        for (solid, exact) in solids() {
            for _ in 0..2000 {
                let x = [0; 3].map(|_| random(&mut seed));
                let (distance, normal) = solid.distance(x);
                assert_eq!(distance < 0.0, solid.contains(x), "{solid:?} {x:?}");
                assert!((dot(normal, normal) - 1.0).abs() < 1e-12, "{solid:?} {x:?} {normal:?}");
                // nothing of the surface is nearer: a ball of this radius lies on one side
                let side = [0; 3].map(|_| random(&mut seed));
                let reach = 0.999 * distance.abs() / dot(side, side).sqrt();
                let other: [f64; 3] = std::array::from_fn(|a| x[a] + reach * side[a]);
                assert_eq!(solid.contains(other), distance < 0.0, "{solid:?} {x:?}");
                if exact {
                    let foot: [f64; 3] = std::array::from_fn(|a| x[a] - distance * normal[a]);
                    assert!(solid.distance(foot).0.abs() < 1e-12, "{solid:?} {x:?}");
                }
            }
        }
    }

    #[test]
    fn what_a_solid_says_of_a_box_it_says_of_every_point_in_it() {
        let mut seed = 11;
        let mut told = [0; 2];
        for (solid, _) in solids() {
            let mut here = [0; 2];
            for _ in 0..20_000 {
                let middle = [0; 3].map(|_| random(&mut seed));
                let size = 0.3 * random(&mut seed).abs();
                let half = [0; 3].map(|_| size * random(&mut seed).abs());
                let corner = |sign: f64| std::array::from_fn(|a| middle[a] + sign * half[a]);
                let (lower, upper): ([f64; 3], [f64; 3]) = (corner(-1.0), corner(1.0));
                let Some(inside) = solid.holds((lower, upper)) else { continue };
                here[usize::from(inside)] += 1;
                let corners = (0..8)
                    .map(|c| std::array::from_fn(|a| if c >> a & 1 == 0 { lower[a] } else { upper[a] }));
                let within =
                    (0..20).map(|_| std::array::from_fn(|a| middle[a] + half[a] * random(&mut seed)));
                for x in corners.chain(within.collect::<Vec<[f64; 3]>>()) {
                    assert_eq!(solid.contains(x), inside, "{solid:?} {lower:?} {upper:?} {x:?}");
                }
            }
            assert!(here.iter().all(|&n| n > 20), "{solid:?} {here:?}");
            (0..2).for_each(|n| told[n] += here[n]);
        }
        // most boxes lie on one side
        assert!(told[0] + told[1] > 11 * 10_000, "{told:?}");
    }
}
