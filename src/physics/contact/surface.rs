//! Where the surface of a material lies near a node, from what the node knows of it.
//!
//! A material's center of mass at a node, x̄ = Σ S m x / Σ S m, moves with its surface: a body that ends at
//! distance s before the node (s < 0: beyond it) has its center at distance ξ(s). The relation is that of a regular
//! lattice of particles with a plane surface half a spacing beyond the outermost ones; it does not depend on
//! density. Its inverse gives s, and two materials touch when their distances add up to nothing.

/// Entries of the table of ξ.
const ENTRIES: usize = 129;
/// The table covers s in [−LIMIT, LIMIT] cells.
const LIMIT: f64 = 1.25;

/// The relation ξ(s) for particles of one half-size.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceTable {
    /// ξ at equidistant s, increasing.
    centers: Vec<f64>,
    /// From particle to particle [cells].
    spacing: f64,
}

impl SurfaceTable {
    /// The table for particles of half-size `r` cells that act on nodes by uniform GIMP (`r_shape` = r) or by hats
    /// (`r_shape` = 0).
    pub fn new(r: f64, r_shape: f64) -> Self {
        let centers = (0..ENTRIES).map(|i| center(Self::distance(i), r, r_shape));
        let mut highest = f64::NEG_INFINITY;
        // rounding aside, ξ increases; the inverse needs it strictly so
        let centers = centers.enumerate().map(|(i, c)| {
            highest = c.max(highest + 1e-9 * (i as f64 + 1.0));
            highest
        });
        Self { centers: centers.collect(), spacing: 2.0 * r }
    }

    /// From particle to particle [cells].
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    fn distance(entry: usize) -> f64 {
        -LIMIT + 2.0 * LIMIT * entry as f64 / (ENTRIES - 1) as f64
    }

    /// Distance s [cells] from the surface to the node, for a center of mass at distance `center` [cells] before
    /// the node. Clamped to ±1.25 cells.
    pub fn surface(&self, center: f64) -> f64 {
        let next = self.centers.partition_point(|&c| c < center);
        if next == 0 || next == ENTRIES {
            return if next == 0 { -LIMIT } else { LIMIT };
        }
        let (low, high) = (self.centers[next - 1], self.centers[next]);
        let part = (center - low) / (high - low);
        Self::distance(next - 1) + part * 2.0 * LIMIT / (ENTRIES - 1) as f64
    }
}

/// ξ(s): particles at distances s + r, s + 3r, … before the node.
fn center(s: f64, r: f64, r_shape: f64) -> f64 {
    let (mut mass, mut moment) = (0.0, 0.0);
    let mut d = s + r;
    while d < 1.0 + r_shape {
        let weight = hat(d.abs(), r_shape);
        mass += weight;
        moment += weight * d;
        d += 2.0 * r;
    }
    // a surface out of reach: beyond all that can be seen
    if mass > 0.0 { moment / mass } else { 1.0 + r_shape + s }
}

/// The uGIMP weight at distance d of a particle of half-size r (r = 0: the hat).
fn hat(d: f64, r: f64) -> f64 {
    if d < r {
        1.0 - (d * d + r * r) / (2.0 * r)
    } else if d <= 1.0 - r {
        1.0 - d
    } else if d < 1.0 + r {
        (1.0 + r - d).powi(2) / (4.0 * r)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surfaces_of_lattices_are_found_where_they_are() {
        for (r, shape) in [(0.25, 0.25), (0.25, 0.0), (0.125, 0.125)] {
            let table = SurfaceTable::new(r, shape);
            for i in -9..=9 {
                let s = f64::from(i) * 0.1;
                let found = table.surface(center(s, r, shape));
                // a node that no particle beyond the surface could reach sees only that it is deep inside
                let deep = s < r - 1.0 - shape;
                let right = if deep { found <= s } else { (found - s).abs() < 0.03 };
                assert!(right, "r {r} shape {shape} s {s} found {found}");
            }
        }
    }
}
