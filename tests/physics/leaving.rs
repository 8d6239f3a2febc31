//! Particles that leave the domain: what the scene's policy does with them.

use crate::common::{add, minus, momentum, norm, scene, start};

/// A ball of free particles that flies through a corner of the domain.
const FLYING: &str = r#"
[domain]
lower = [-4, -4, -4]
upper = [4, 4, 4]
cell = 1
[material.gas]
law = "neo-hookean"
density = 1000
bulk-modulus = "1 kPa"
shear-modulus = "1 kPa"
[[body]]
name = "ball"
material = "gas"
shape = { sphere = { center = [1.5, 1.5, 0], radius = 2 } }
velocity = [40, 30, 0]
[run]
until = 1
steps = 60
leaving = "reflect"
"#;

#[test]
fn reflected_particles_stay_and_the_faces_take_their_momentum() {
    let mut simulation = start(scene(FLYING, &[]));
    let before = simulation.report().expect("one rank");
    while simulation.step().expect("nobody is lost") {}
    let after = simulation.report().expect("one rank");
    println!("{} reflections, impulse {:?}", after.reflected, after.boundary_impulse);
    assert!(after.reflected > 50 && after.deleted == 0);
    assert_eq!(after.materials[0].particles, before.materials[0].particles);
    assert!(
        after.materials[0].velocity()[0] < 0.9 * before.materials[0].velocity()[0],
        "the face pushes back"
    );
    let expected = add(momentum(&before), after.boundary_impulse);
    assert!(norm(minus(momentum(&after), expected)) < 1e-12 * norm(momentum(&before)));
    assert!(after.residual.abs() < 0.02 * before.energy().total(), "mirroring takes no energy");
}
