//! Particles of a body: the points of a regular lattice, aligned with the cells, that lie in its solid.
mod filling;
mod numbering;

pub use filling::{Filling, Span, common, points_of, size};
pub use numbering::{Numbering, Pencils};

use crate::geometry::{Bounds, Solid, cross, dot, overlap};
use crate::{Body, Domain, FiberField, Scene};
use physics::faces::FaceCondition;
use std::ops::Range;

/// The particles of a body [m]: in each cell of the domain `n` points along each axis, at the cell's corner plus
/// (i + ½)/n of its edge. Cells come in the order of x, then y, then z (z fastest), and so do the points of a cell.
pub fn sample(scene: &Scene, body: &Body) -> impl Iterator<Item = [f64; 3]> {
    points(&scene.domain, body.particles_per_cell, &body.solid, inside(&scene.domain))
}

/// How many particles [`sample`] gives.
pub fn count(scene: &Scene, body: &Body) -> usize {
    let filling = Filling::of(scene, body);
    filling.count(filling.span()) as usize
}

/// Volume of one particle of the body [m³].
pub fn particle_volume(scene: &Scene, body: &Body) -> f64 {
    scene.domain.cell.powi(3) / body.particles_per_cell.iter().product::<usize>() as f64
}

/// Unit vector of the fibers at a point [m].
pub fn fiber_at(field: &FiberField, x: [f64; 3]) -> [f64; 3] {
    match *field {
        FiberField::Uniform(direction) => direction,
        FiberField::Turning { start, axis, from, to, angle } => {
            let (sin, cos) = (angle * (dot(axis, x) - from) / (to - from)).sin_cos();
            let side = cross(axis, start); // start is perpendicular to the axis
            std::array::from_fn(|i| cos * start[i] + sin * side[i])
        }
    }
}

/// Lattice points within `limits` that the solid contains. Cells are counted from the lower corner of the domain, but may
/// lie outside.
pub fn points(
    domain: &Domain,
    n: [usize; 3],
    solid: &Solid,
    limits: Bounds,
) -> impl Iterator<Item = [f64; 3]> {
    let Domain { lower, cell, .. } = *domain;
    let at = move |a: usize, c: i64, i: usize| lower[a] + (c as f64 + (i as f64 + 0.5) / n[a] as f64) * cell;
    let cell_points = move |c: [i64; 3]| {
        let each = move |i: usize| [i / (n[1] * n[2]), i / n[2] % n[1], i % n[2]];
        (0..n.iter().product()).map(move |i| std::array::from_fn(|a| at(a, c[a], each(i)[a])))
    };
    let cells = points_of(&cells(domain, overlap(solid.bounds(), limits)));
    cells.flat_map(cell_points).filter(|x| solid.contains(*x))
}

/// N₀: the faces of the particle at `x` [m] of a body (by its index) that no other of its material covers, as far as their sides (x−, x+, …)
/// count: what its area a = J F^(−T) N₀ is made of [m²].
pub fn exposed_area(scene: &Scene, body: usize, x: [f64; 3], sides: [bool; 6]) -> [f64; 3] {
    let it = &scene.bodies[body];
    let size = it.particles_per_cell.map(|n| scene.domain.cell / n as f64);
    let mut area = [0.0; 3];
    for face in (0..6).filter(|&face| sides[face]) {
        let (axis, sign) = (face / 2, if face % 2 == 1 { 1.0 } else { -1.0 });
        let mut beside = x;
        beside[axis] += sign * size[axis];
        if is_matter(scene, it.material, beside) {
            continue;
        }
        let across = size[(axis + 1) % 3] * size[(axis + 2) % 3];
        // with F = diag λ: N₀ = a λ / J
        let j: f64 = it.stretch.iter().product();
        area[axis] += sign * across * it.stretch[axis] / j;
    }
    area
}

/// Whether there is matter of a material, or its image beyond a face.
fn is_matter(scene: &Scene, material: usize, x: [f64; 3]) -> bool {
    let (lower, upper) = inside(&scene.domain);
    let beyond = (0..6).any(|face| {
        let axis = face / 2;
        let out = if face % 2 == 0 { x[axis] < lower[axis] } else { x[axis] > upper[axis] };
        out && scene.faces[face].image().is_some()
    });
    beyond || scene.bodies_of(material).any(|body| body.solid.contains(x))
}

/// The box of the domain, which the lattice does not leave.
pub fn inside(domain: &Domain) -> Bounds {
    let upper = |a: usize| domain.lower[a] + domain.cells[a] as f64 * domain.cell;
    (domain.lower, std::array::from_fn(upper))
}

/// Whether a box reaches a face of the domain (x−, x+, y−, …), within rounding.
pub fn reaches(domain: &Domain, (from, to): Bounds, face: usize) -> bool {
    let ((lower, upper), a) = (inside(domain), face / 2);
    let near = 1e-6 * domain.cell;
    if face.is_multiple_of(2) { from[a] <= lower[a] + near } else { to[a] >= upper[a] - near }
}

/// Cells that a box touches, along each axis; a box that ends on a face (within rounding) does not touch the next cell.
pub fn cells(domain: &Domain, (lower, upper): Bounds) -> [Range<i64>; 3] {
    const ROUNDING: f64 = 1e-6; // of a cell
    std::array::from_fn(|a| {
        let position = |x: f64| (x - domain.lower[a]) / domain.cell;
        (position(lower[a]) + ROUNDING).floor() as i64..(position(upper[a]) - ROUNDING).ceil() as i64
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    const DOMAIN: Domain = Domain { lower: [-1.0, 0.0, 2.0], cells: [4, 2, 3], cell: 0.5 };

    fn all(n: [usize; 3], solid: &Solid) -> Vec<[f64; 3]> {
        points(&DOMAIN, n, solid, inside(&DOMAIN)).collect()
    }

    #[test]
    fn a_full_domain_has_every_point_in_order() {
        let (lower, upper) = inside(&DOMAIN);
        let points = all([1, 2, 3], &Solid::Box { lower, upper });
        assert_eq!(points.len(), 4 * 2 * 3 * 6);
        let expected =
            [[-0.75, 0.125, 2.0 + 0.5 / 6.0], [-0.75, 0.125, 2.25], [-0.75, 0.125, 2.0 + 2.5 / 6.0]];
        for (point, expected) in points.iter().zip(expected) {
            assert!((0..3).all(|a| (point[a] - expected[a]).abs() < 1e-15), "{point:?}");
        }
        assert_eq!(points[3][1], 0.375); // then y inside the cell
        assert!((points[6][2] - (2.5 + 0.5 / 6.0)).abs() < 1e-15); // then the next cell along z
    }

    #[test]
    fn a_box_of_whole_cells_has_all_of_their_points() {
        let solid = Solid::Box { lower: [-0.5, 0.5, 2.0], upper: [0.5, 1.0, 3.0] };
        assert_eq!(all([2, 2, 2], &solid).len(), 2 * 2 * 8);
        assert_eq!(cells(&DOMAIN, solid.bounds()), [1..3, 1..2, 0..2]);
    }

    #[test]
    fn the_volume_of_a_ball_is_that_of_its_particles() {
        let domain = Domain { lower: [0.0; 3], cells: [20; 3], cell: 0.1 };
        let ball = Solid::Sphere { center: [1.0; 3], radius: 0.9 };
        let n = points(&domain, [4; 3], &ball, inside(&domain)).count();
        let volume = n as f64 * 0.1f64.powi(3) / 64.0;
        assert!((volume / (4.0 / 3.0 * PI * 0.9f64.powi(3)) - 1.0).abs() < 2e-3, "{volume}");
    }

    #[test]
    fn unbounded_solids_end_with_the_domain() {
        let solid = Solid::HalfSpace { point: [0.0, 0.5, 0.0], normal: [0.0, 1.0, 0.0] };
        assert_eq!(all([1; 3], &solid).len(), 4 * 3);
    }

    #[test]
    fn fibers_turn_right_handed_between_the_planes() {
        let field = FiberField::Turning {
            start: [1.0, 0.0, 0.0],
            axis: [0.0, 1.0, 0.0],
            from: 0.0,
            to: 2.0,
            angle: -PI,
        };
        let close = |a: [f64; 3], b: [f64; 3]| (0..3).all(|i| (a[i] - b[i]).abs() < 1e-15);
        assert!(close(fiber_at(&field, [5.0, 0.0, 0.0]), [1.0, 0.0, 0.0]));
        assert!(close(fiber_at(&field, [5.0, 1.0, 0.0]), [0.0, 0.0, 1.0])); // −90° about y
        assert!(close(fiber_at(&field, [5.0, 2.0, 0.0]), [-1.0, 0.0, 0.0]));
    }
}
