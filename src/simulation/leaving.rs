//! What becomes of particles that leave the level.
use engine::data::exact_sum::ExactSum;
use engine::data::shared::Shared;
use engine::data::warehouse::MaterialData;
use engine::exec::traveler::Traveler;
use engine::schema::Label;
use grid::Level;
use tasks::labels::{BoundaryWork, Mass, Position, Velocity};

/// Position and velocity are mirrored at the faces of the level behind which a particle is; what the faces give it is booked.
pub fn mirror(level: &Level, particle: &mut Traveler, materials: &[MaterialData], shared: &mut Shared) {
    let (lower, upper) = (level.lower, level.upper());
    let mass = particle.numbers(materials, Mass::ID)[0];
    let sums: &mut [ExactSum] = bytemuck::cast_slice_mut(shared.column_mut(BoundaryWork::ID));
    for axis in 0..3 {
        let (x, low, high) = (particle.position[axis], lower[axis], upper[axis]);
        if x < low || x > high {
            let face = if x < low { low } else { high };
            particle.position[axis] = (2.0 * face - x).clamp(low, high);
            let v = &mut particle.numbers_mut(materials, Velocity::ID)[axis];
            sums[1 + axis].add(-2.0 * mass * *v);
            *v = -*v;
        }
    }
    let position = particle.position;
    particle.numbers_mut(materials, Position::ID).copy_from_slice(&position);
}
