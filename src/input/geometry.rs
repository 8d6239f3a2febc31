//! Solids as signed-distance-like functions.
/// A solid. (First form: the reader fills it.)
#[derive(Clone, Debug, PartialEq)]
pub enum Solid {
    /// Ball.
    Sphere {
        /// Center [m].
        center: [f64; 3],
        /// Radius [m].
        radius: f64,
    },
    /// Axis-aligned box.
    Box {
        /// Lower corner [m].
        lower: [f64; 3],
        /// Upper corner [m].
        upper: [f64; 3],
    },
}

impl Solid {
    /// Whether the point lies inside (or on the surface).
    pub fn contains(&self, x: [f64; 3]) -> bool {
        match self {
            Solid::Sphere { center, radius } => {
                (0..3).map(|a| (x[a] - center[a]).powi(2)).sum::<f64>() <= radius * radius
            }
            Solid::Box { lower, upper } => (0..3).all(|a| lower[a] <= x[a] && x[a] <= upper[a]),
        }
    }

    /// A box that holds the solid; infinite where the solid is unbounded.
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        match self {
            Solid::Sphere { center, radius } => (center.map(|c| c - radius), center.map(|c| c + radius)),
            Solid::Box { lower, upper } => (*lower, *upper),
        }
    }
}
