//! What becomes of particles that leave the level.
use engine::data::exact_sum::ExactSum;
use engine::data::shared::Shared;
use engine::data::warehouse::MaterialData;
use engine::exec::traveler::Traveler;
use engine::schema::Label;
use grid::Level;
use physics::contact::cross;
use scene::Scene;
use tasks::labels::{Mass, Position, Reactions, Velocity};
use tasks::reactions::{NUMBERS, Reaction};
use tasks::recipes::{Giver, Givers};

/// Position and velocity are mirrored at the faces of the level behind which a particle is; what the faces give it is booked.
pub fn mirror(
    scene: &Scene,
    level: &Level,
    particle: &mut Traveler,
    materials: &[MaterialData],
    shared: &mut Shared,
) {
    let (lower, upper) = (level.lower, level.upper());
    let mass = particle.numbers(materials, Mass::ID)[0];
    let givers = Givers::of(scene);
    let tiles: &mut [[ExactSum; NUMBERS]] = bytemuck::cast_slice_mut(shared.column_mut(Reactions::ID));
    for axis in 0..3 {
        let (x, low, high) = (particle.position[axis], lower[axis], upper[axis]);
        if x < low || x > high {
            let face = if x < low { low } else { high };
            let giver = Giver::Face(2 * axis + usize::from(x > high));
            particle.position[axis] = (2.0 * face - x).clamp(low, high);
            let v = &mut particle.numbers_mut(materials, Velocity::ID)[axis];
            let mut impulse = [0.0; 3];
            impulse[axis] = -2.0 * mass * *v;
            *v = -*v;
            if let Some(tile) = givers.tile(giver) {
                let torque = cross(particle.position, impulse);
                Reaction { impulse, torque, work: 0.0 }.store(&mut tiles[tile]);
            }
        }
    }
    let position = particle.position;
    particle.numbers_mut(materials, Position::ID).copy_from_slice(&position);
}
