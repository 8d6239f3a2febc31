use super::work::Work;
use crate::labels::{BoundaryWork, DriveIndex, GridVelocity, Mass, OwnStep, Velocity, VelocityChange};
use engine::graph::task::{At, Body};
use physics::table::Table;
use simd::{LANES, Simd};

/// Particles of a driven region move as the scene prescribes, whatever the nodes say.
pub struct Drive {
    /// Velocity in time of each drive.
    pub drives: Vec<Table>,
}

engine::task! { Particles task Drive {
    requires old { index: DriveIndex, mass: Mass, velocity: Velocity }
    requires new { step: OwnStep }
    computes { work: BoundaryWork }
    modifies { grid_velocity: GridVelocity, change: VelocityChange }
}}

impl Body for Drive {
    #[inline(always)]
    fn run<S: Simd>(&self, _at: &At<'_>, mut io: Io<'_>) {
        let time = io.step[0].time + io.step[0].size;
        let mut work = Work::default();
        let grid = io.grid_velocity.iter_mut().zip(io.change.iter_mut());
        let particles = io.index.iter().zip(io.mass.iter()).zip(io.velocity.iter());
        for (((index, mass), v), (on_grid, dv)) in particles.zip(grid) {
            for lane in (0..LANES).filter(|&lane| index.0[lane] > 0.0) {
                let wanted = self.drives[index.0[lane] as usize - 1].at(time);
                let v: [f64; 3] = std::array::from_fn(|a| v[a].0[lane]);
                let mean = std::array::from_fn(|a| 0.5 * (v[a] + wanted[a]));
                work.add(mass.0[lane], mean, std::array::from_fn(|a| wanted[a] - v[a] - dv[a].0[lane]));
                for a in 0..3 {
                    on_grid[a].0[lane] = wanted[a];
                    dv[a].0[lane] = wanted[a] - v[a];
                }
            }
        }
        work.store(&mut io.work[0]);
    }
}
