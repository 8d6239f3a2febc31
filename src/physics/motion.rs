//! Rigid motions in time, and what a step sees of them: a chord.
use super::table::Table;

/// How a point moves in time.
#[derive(Clone, Debug, PartialEq)]
pub enum Course {
    /// Its velocity [m/s].
    Velocity(Table),
    /// Its displacement [m].
    Displacement(Table),
}

impl Course {
    /// A point at rest.
    pub fn rest() -> Self {
        Course::Velocity(Table::zero())
    }

    /// How far it moves from time `from` to time `to` [m].
    pub fn way(&self, from: f64, to: f64) -> [f64; 3] {
        match self {
            Course::Velocity(table) => table.integral(from, to),
            Course::Displacement(table) => {
                let (before, after) = (table.at(from), table.at(to));
                std::array::from_fn(|a| after[a] - before[a])
            }
        }
    }

    /// Its largest speed from time `from` to time `to` [m/s].
    pub fn fastest(&self, from: f64, to: f64) -> f64 {
        match self {
            Course::Velocity(table) => table.within(from, to).map(|(_, v)| length(v)).fold(0.0, f64::max),
            Course::Displacement(table) => {
                let rows: Vec<(f64, [f64; 3])> = table.within(from, to).collect();
                let speed = |pair: &[(f64, [f64; 3])]| {
                    let way = std::array::from_fn(|a| pair[1].1[a] - pair[0].1[a]);
                    let time = pair[1].0 - pair[0].0;
                    if time > 0.0 { length(way) / time } else { 0.0 }
                };
                rows.windows(2).map(speed).fold(0.0, f64::max)
            }
        }
    }
}

/// A rigid motion in time: its center moves, and it turns about that.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// How its center moves.
    pub course: Course,
    /// Angular velocity in time [rad/s].
    pub spin: Table,
    /// Where its center is at time 0 [m].
    pub center: [f64; 3],
}

impl Motion {
    /// What happens from time `from` to time `to` [s].
    pub fn chord(&self, from: f64, to: f64) -> Chord {
        let (before, way) = (self.course.way(0.0, from), self.course.way(from, to));
        let center: [f64; 3] = std::array::from_fn(|a| self.center[a] + before[a]);
        let rotation = rotation(self.spin.integral(from, to));
        Chord { center, way, rotation, duration: to - from }
    }

    /// The gradient of its velocity where points are at a time, after a chord of some duration: (1 − R⁻¹)/Δt, row by row [1/s]. Nothing
    /// has moved before time 0.
    pub fn gradient_before(&self, time: f64, duration: f64) -> [f64; 9] {
        let duration = duration.min(time);
        if duration <= 0.0 {
            return [0.0; 9];
        }
        let back = rotation(self.spin.integral(time - duration, time).map(|angle| -angle));
        std::array::from_fn(|n| (f64::from(u8::from(n % 4 == 0)) - back[n]) / duration)
    }

    /// The largest speed of its points within `radius` [m] of the center, from time `from` to time `to` [m/s].
    pub fn fastest(&self, from: f64, to: f64, radius: f64) -> f64 {
        self.course.fastest(from, to) + radius * self.fastest_turn(from, to)
    }

    /// The largest angular speed from time `from` to time `to` [rad/s].
    pub fn fastest_turn(&self, from: f64, to: f64) -> f64 {
        self.spin.within(from, to).map(|(_, spin)| length(spin)).fold(0.0, f64::max)
    }
}

/// A rigid motion over a step: every point goes straight to where it will be. Then 1 + Δt L is the rotation itself, and nothing is
/// strained.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chord {
    /// The center at the beginning [m].
    pub center: [f64; 3],
    /// How far it goes [m].
    pub way: [f64; 3],
    /// How it turns, row by row.
    pub rotation: [f64; 9],
    /// How long it takes [s].
    pub duration: f64,
}

impl Chord {
    /// Mean velocity of the point that is at `x` [m] at the beginning [m/s].
    #[inline]
    pub fn velocity(&self, x: [f64; 3]) -> [f64; 3] {
        let r: [f64; 3] = std::array::from_fn(|a| x[a] - self.center[a]);
        let turned = |a: usize| (0..3).map(|b| self.rotation[3 * a + b] * r[b]).sum::<f64>();
        std::array::from_fn(|a| (self.way[a] + turned(a) - r[a]) / self.duration)
    }
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The rotation by a vector of angles [rad] (Rodrigues), row by row: 1 + sin θ/θ W + (1 − cos θ)/θ² W².
pub fn rotation(angles: [f64; 3]) -> [f64; 9] {
    let theta = length(angles);
    let [x, y, z] = angles;
    let w = [0.0, -z, y, z, 0.0, -x, -y, x, 0.0];
    // sin θ/θ and (1 − cos θ)/θ² = ½ (sin ½θ / ½θ)²
    let sinc = |x: f64| if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x };
    let (a, b) = (sinc(theta), 0.5 * sinc(0.5 * theta).powi(2));
    std::array::from_fn(|n| {
        let (i, j) = (n / 3, n % 3);
        let squared = (0..3).map(|k| w[3 * i + k] * w[3 * k + j]).sum::<f64>();
        f64::from(u8::from(i == j)) + a * w[n] + b * squared
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_about_a_moving_center_takes_points_where_they_belong() {
        let spin = Table(vec![(0.0, [0.0, 0.0, 0.0]), (2.0, [0.0, 0.0, std::f64::consts::FRAC_PI_2])]);
        let course = Course::Displacement(Table(vec![(0.0, [0.0; 3]), (2.0, [6.0, 0.0, 2.0])]));
        let motion = Motion { course, spin, center: [1.0, 0.0, 0.0] };
        let mut x = [2.0, 0.0, 0.0];
        for n in 0..16 {
            let chord = motion.chord(f64::from(n) / 8.0, f64::from(n + 1) / 8.0);
            let v = chord.velocity(x);
            x = std::array::from_fn(|a| x[a] + v[a] / 8.0);
        }
        // ∫ω = π/2: from beside the center to above it
        let wanted = [7.0, 1.0, 2.0];
        assert!(x.iter().zip(wanted).all(|(x, wanted)| (x - wanted).abs() < 1e-14), "{x:?}");
        assert!((motion.fastest(1.0, 2.0, 2.0) - (10.0f64.sqrt() + std::f64::consts::PI)).abs() < 1e-14);
    }

    #[test]
    fn small_turns_are_rotations() {
        for theta in [0.0, 1e-9, 9e-5, 1.1e-4, 0.3, 3.0] {
            let r = rotation([0.48 * theta, 0.6 * theta, 0.64 * theta]);
            for (i, j) in [(0, 0), (0, 1), (1, 2), (2, 2)] {
                let product: f64 = (0..3).map(|k| r[3 * i + k] * r[3 * j + k]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 4e-16, "{theta} {i} {j}");
            }
            let trace = r[0] + r[4] + r[8];
            assert!((trace - 1.0 - 2.0 * f64::cos(theta)).abs() < 1e-15);
        }
    }
}
