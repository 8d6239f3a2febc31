//! Forces on particles: parts of a total, tractions and pressures on the faces that they have on the surface.
use engine::data::rates::MaterialStep;
use physics::table::Table;

/// The forces of a scene; particles have their numbers (label `ForceIndex`: 1 + the index in this list).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forces(pub Vec<Pushes>);

/// What one of them does. Label `SurfaceArea` has the share of the particle (in its first number), or N₀: the area of its
/// undeformed faces on the surface, along their normals [m²].
#[derive(Clone, Debug, PartialEq)]
pub enum Pushes {
    /// F = t · share
    Total(Table),
    /// F = t |N₀|
    Traction(Table),
    /// F = −p J F^(−T) N₀ (Nanson)
    Pressure(Table),
    /// F = −p N₀
    DeadPressure(Table),
}

impl Forces {
    /// The mean force [N] on a particle in a step: `area` is its `SurfaceArea`, `f` its deformation gradient, row by row.
    pub fn of(&self, index: f64, step: &MaterialStep, area: [f64; 3], f: &[f64; 9]) -> [f64; 3] {
        let Some(pushes) = (index as usize).checked_sub(1).and_then(|index| self.0.get(index)) else {
            return [0.0; 3];
        };
        let mean = |table: &Table| match &table.0[..] {
            [(_, value)] => *value,
            _ => table.integral(step.time, step.time + step.size).map(|sum| sum / step.size),
        };
        match pushes {
            Pushes::Total(table) => mean(table).map(|total| total * area[0]),
            Pushes::Traction(table) => {
                let size = area.iter().map(|n| n * n).sum::<f64>().sqrt();
                mean(table).map(|traction| traction * size)
            }
            Pushes::Pressure(table) => {
                let p = mean(table)[0];
                cofactor_times(f, area).map(|n| -p * n)
            }
            Pushes::DeadPressure(table) => {
                let p = mean(table)[0];
                area.map(|n| -p * n)
            }
        }
    }
}

/// J F^(−T) n: where an area goes.
fn cofactor_times(f: &[f64; 9], n: [f64; 3]) -> [f64; 3] {
    let at = |i: usize, j: usize| f[3 * (i % 3) + j % 3];
    let cofactor =
        |i: usize, j: usize| at(i + 1, j + 1) * at(i + 2, j + 2) - at(i + 1, j + 2) * at(i + 2, j + 1);
    std::array::from_fn(|i| (0..3).map(|j| cofactor(i, j) * n[j]).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_go_along_by_nanson() {
        let f = [1.2, 0.3, -0.1, 0.05, 0.9, 0.2, 0.0, -0.15, 1.1];
        // a parallelogram of two edges, before and after
        let (a, b) = ([1.0, 2.0, -0.5], [0.3, -1.0, 0.8]);
        let go =
            |v: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| (0..3).map(|j| f[3 * i + j] * v[j]).sum()) };
        let cross = physics::contact::cross;
        let (found, wanted) = (cofactor_times(&f, cross(a, b)), cross(go(a), go(b)));
        assert!(found.iter().zip(wanted).all(|(x, y)| (x - y).abs() < 1e-14), "{found:?} {wanted:?}");
    }
}
