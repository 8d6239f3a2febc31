//! Before the first step.
use super::builder::Builder;
use crate::rest::Rest;
use crate::signal_speed::SignalSpeed;
use engine::graph::recipe::Recipe;
use scene::{Behavior, Scene};

/// Laws in the state that the scene gave, for the first step's size.
pub fn start(scene: &Scene) -> Recipe {
    let mut recipe = Builder::new(scene);
    for m in 0..scene.materials.len() {
        match &scene.materials[m].behavior {
            Behavior::Deformable(law) => {
                recipe.add(m, "", Rest);
                recipe.stress(m, law);
                recipe.add(m, "", SignalSpeed);
            }
            Behavior::Rigid(_) if scene.materials[m].has_particles() => recipe.follow(m),
            Behavior::Rigid(_) => {}
        }
    }
    recipe.rigid_apart();
    recipe.finish()
}
