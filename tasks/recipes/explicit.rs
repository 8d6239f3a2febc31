//! One explicit step of the material point method (USL).
use super::bodies::{accelerations, pushes};
use super::builder::{Builder, rigid};
use super::tools::movers;
use crate::clock::AdvanceClock;
use crate::gather::Gather;
use crate::grid_power::GridPower;
use crate::integrate::Integrate;
use crate::labels::{RigidSolved, StepOver};
use crate::mass_flow::MassFlow;
use crate::nodal_velocity::NodalVelocity;
use crate::scatter::Scatter;
use crate::signal_speed::SignalSpeed;
use crate::stress_flow::StressFlow;
use crate::timestep_size::TimestepSize;
use engine::program::Script;
use engine::schema::Label;
use scene::{Behavior, Rates, Scene};

/// A step: ticks, until all materials are together again. At common rates it is one.
pub fn step(scene: &Scene) -> Vec<Script> {
    let most = match scene.run.rates {
        Rates::Common => 1,
        Rates::PerMaterial { most } => most.into(),
    };
    vec![Script::Loop { body: tick(scene), until: StepOver::ID, most }]
}

/// The most rounds of a search for the motion of free rigid bodies (see `crate::rigid::newton`): two or three are usual.
const ROUNDS: u64 = 150;

/// A tick: the step of the fastest material, and a part of the steps of slower ones. Where contact moves rigid bodies, their motion is
/// searched for in between.
fn tick(scene: &Scene) -> Vec<Script> {
    let mut recipe = Builder::new(scene);
    particles_to_nodes(&mut recipe);
    forces_on_nodes(&mut recipe);
    if !pushes(scene) {
        nodes_to_particles(&mut recipe);
        return vec![Script::Graph("tick", recipe.finish())];
    }
    recipe.drive_sum();
    let [mut round, mut rest] = [Builder::new(scene), Builder::new(scene)];
    round.rigid_round();
    nodes_to_particles(&mut rest);
    let search = vec![Script::Graph("search", round.finish())];
    vec![
        Script::Graph("tick", recipe.finish()),
        Script::Loop { body: search, until: RigidSolved::ID, most: ROUNDS },
        Script::Graph("rest of the tick", rest.finish()),
    ]
}

/// What particles give to nodes.
fn particles_to_nodes(recipe: &mut Builder<'_>) {
    recipe.timestep_size();
    recipe.rigid_plan();
    recipe.reflection();
    for m in recipe.scene.deformable() {
        recipe.weights(m);
        recipe.add(m, "", MassFlow);
        recipe.add(m, "", StressFlow);
        recipe.add(m, "", Scatter);
        recipe.force_scatter(m);
        recipe.drive_scatter(m);
        recipe.surfaces(m);
        recipe.fold(m);
    }
}

/// What moves nodes, but for free rigid bodies.
fn forces_on_nodes(recipe: &mut Builder<'_>) {
    if recipe.scene.deformable().next().is_none() {
        return;
    }
    recipe.all("", NodalVelocity { least_mass: recipe.least_mass });
    recipe.contact_begin();
    recipe.contact(true);
    recipe.all("", Integrate { least_mass: recipe.least_mass });
    recipe.loads();
    recipe.contact(false);
    recipe.tools();
    recipe.rigid_sites();
}

/// What free rigid bodies and conditions do to nodes, and how particles follow.
fn nodes_to_particles(recipe: &mut Builder<'_>) {
    if recipe.scene.deformable().next().is_some() {
        recipe.rigid_push();
        recipe.hold_bonds();
        recipe.drive_nodes();
        recipe.drive_bonds();
        recipe.boundary();
        recipe.local_damping();
        recipe.contact_power();
        recipe.load_power();
        recipe.all("", GridPower);
    }
    recipe.rigid_motion();
    recipe.rigid_apart();
    for m in 0..recipe.scene.materials.len() {
        match &recipe.scene.materials[m].behavior {
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
            Behavior::Rigid(_) if recipe.scene.materials[m].has_particles() => recipe.follow(m),
            Behavior::Rigid(_) => {}
        }
    }
    recipe.all("", AdvanceClock);
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
        pushes: accelerations(scene),
        rigid: rigid(scene),
    }
}
