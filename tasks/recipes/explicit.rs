//! One explicit step of the material point method (USL).
use super::builder::{Builder, rigid};
use super::tools::movers;
use crate::clock::AdvanceClock;
use crate::gather::Gather;
use crate::grid_power::GridPower;
use crate::integrate::Integrate;
use crate::labels::StepOver;
use crate::mass_flow::MassFlow;
use crate::nodal_velocity::NodalVelocity;
use crate::rigid::flow::RigidFlow;
use crate::scatter::Scatter;
use crate::signal_speed::SignalSpeed;
use crate::stress_flow::StressFlow;
use crate::timestep_size::TimestepSize;
use engine::graph::recipe::Recipe;
use engine::program::Script;
use engine::schema::Label;
use scene::{Behavior, Rates, Scene};

/// A step: ticks, until all materials are together again. At common rates it is one.
pub fn step(scene: &Scene) -> Vec<Script> {
    let most = match scene.run.rates {
        Rates::Common => 1,
        Rates::PerMaterial { most } => most.into(),
    };
    vec![Script::Loop { body: vec![Script::Graph("tick", tick(scene))], until: StepOver::ID, most }]
}

/// A tick: the step of the fastest material, and a part of the steps of slower ones.
pub fn tick(scene: &Scene) -> Recipe {
    let mut recipe = Builder::new(scene);
    recipe.timestep_size();
    recipe.rigid_plan();
    recipe.reflection();
    for m in (0..scene.materials.len()).filter(|&m| !scene.materials[m].is_tool()) {
        recipe.weights(m);
        match &scene.materials[m].behavior {
            Behavior::Deformable(_) => {
                recipe.add(m, "", MassFlow);
                recipe.add(m, "", StressFlow);
            }
            Behavior::Rigid(_) => recipe.add(m, "material", RigidFlow),
        }
        recipe.add(m, "", Scatter);
        recipe.force_scatter(m);
        recipe.drive_scatter(m);
        recipe.surfaces(m);
        recipe.fold(m);
    }

    recipe.all("", NodalVelocity { least_mass: recipe.least_mass });
    recipe.rigid_velocity();
    recipe.contact_begin();
    recipe.contact(true);
    recipe.all("", Integrate { least_mass: recipe.least_mass });
    recipe.loads();
    recipe.rigid_velocity();
    recipe.contact(false);
    recipe.tools();
    recipe.drive_nodes();
    recipe.boundary();
    recipe.contact_power();
    recipe.load_power();
    recipe.all("", GridPower { rigid: recipe.rigid.clone() });
    if recipe.rigid.contains(&true) {
        recipe.rigid_motion();
    }

    for m in 0..scene.materials.len() {
        match &scene.materials[m].behavior {
            Behavior::Deformable(law) => {
                recipe.mirror(m);
                recipe.weights(m);
                recipe.break_bond(m);
                recipe.add(m, "", Gather);
                recipe.force_power(m);
                recipe.stress(m, law);
                recipe.viscosity(m);
                recipe.drive(m);
                recipe.advance(m);
                recipe.add(m, "", SignalSpeed);
            }
            Behavior::Rigid(_) if scene.materials[m].has_particles() => recipe.follow(m),
            Behavior::Rigid(_) => {}
        }
    }
    recipe.all("", AdvanceClock);
    recipe.finish()
}

/// What decides about the steps of the materials.
pub fn timestep_size(scene: &Scene) -> TimestepSize {
    let touching = |m: usize| {
        let pairs = scene.contacts.iter().map(|c| c.between);
        pairs.filter(|pair| pair.contains(&m)).map(|[a, b]| if a == m { b } else { a }).collect()
    };
    let most = match scene.run.rates {
        Rates::Common => 1,
        Rates::PerMaterial { most } => most,
    };
    let falls = |m: &scene::Material| !m.is_tool();
    TimestepSize {
        cfl: scene.run.cfl,
        cell: scene.domain.cell,
        most: f64::from(most),
        touches: (0..scene.materials.len()).map(touching).collect(),
        movers: movers(scene),
        gravity: scene.loads.gravity.clone(),
        falls: scene.materials.iter().map(falls).collect(),
        rigid: rigid(scene),
    }
}
