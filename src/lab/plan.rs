//! What a scene would exchange and cost, from the scene alone: no step is taken and no particle data are stored.
use crate::simulation::start::place_bodies;
use crate::simulation::{layout, populate, step_program};
use engine::data::layout::ParticleLayout;
use engine::data::warehouse::Warehouse;
use engine::exec::Serial;
use engine::exec::ranks::Alone;
use engine::exec::traffic;
use engine::graph::error::GraphError;
use engine::graph::traffic::Traffic;
use engine::program::Program;
use engine::schema::{Label, LabelId};
use grid::{Decomposition, Partition};
use scene::{Material, Scene, sampling};
use std::collections::BTreeMap;
use tasks::labels::{self, SCHEMA};
use tasks::recipes;

/// A scene cut into patches, and these given to ranks as a run would.
pub struct Plan {
    /// The patches.
    pub decomposition: Decomposition,
    /// Their ranks, seen from rank 0.
    pub partition: Partition,
    /// What travels in a tick in which all materials act, at the start.
    pub traffic: Traffic,
}

/// Plans a run of `scene` on `ranks` ranks: on the patches that it asks for, or on about
/// `wanted`.
///
/// # Errors
/// Patches that do not fit the level, fewer patches than ranks, or no ranks.
pub fn plan(scene: &Scene, wanted: usize, ranks: usize) -> Result<Plan, String> {
    if ranks == 0 {
        return Err("0 ranks cannot run anything: give --ranks 1 or more".to_owned());
    }
    let (decomposition, costs) = layout::decompose(scene, wanted, ranks)?;
    let warehouse = outline(scene, decomposition.clone());
    let partition = Partition::by_cost(&decomposition, &costs, 0, ranks)?;
    let mut traffic = traffic::count(&warehouse, &partition);
    let history = |m: &Material| m.declared().history.len() as u64;
    let materials = scene.materials.iter().enumerate();
    traffic.of_material = materials.map(|(m, it)| ((labels::History::ID, m), history(it))).collect();
    Ok(Plan { decomposition, partition, traffic })
}

/// The program of a step of `scene`, with all that is to be refused in it.
pub fn inspect(scene: &Scene, patches: usize) -> (Program, Vec<GraphError>) {
    match step_program(scene, patches) {
        Ok(program) => (program, Vec::new()),
        // nothing is pruned, so that all of it shows
        Err(_) => {
            let all: Vec<LabelId> = SCHEMA.labels().collect();
            Program::inspect("step", recipes::step(scene), &all, patches)
        }
    }
}

/// Labels that the reports of a run read.
pub fn read_by_reports(scene: &Scene) -> Vec<LabelId> {
    let entries = recipes::report(scene).entries;
    let accesses = entries.iter().flat_map(|entry| entry.task.declaration().access);
    accesses.filter(|access| access.mode.reads()).map(|access| access.label).collect()
}

/// The blocks of the scene's start with their extents, neighbors and nodes, and particles without any label.
pub fn outline(scene: &Scene, decomposition: Decomposition) -> Warehouse {
    let partition = Partition::alone(decomposition.patches.len());
    let nothing = |_| ParticleLayout::new(&SCHEMA, [], BTreeMap::new());
    let tiles = recipes::tiles(scene);
    let mut warehouse = populate::empty(scene, decomposition, partition, nothing, [], &tiles);
    // one rank is never gone
    let _ = place_bodies(scene, &mut warehouse, &mut Alone);
    for body in scene.bodies.iter().filter(|body| scene.materials[body.material].has_particles()) {
        for x in sampling::sample(scene, body) {
            // a body that leaves the level is refused by the run; here the rest of it counts
            let _ = warehouse.insert(body.material, x, &[]);
        }
    }
    warehouse.activate(&Serial);
    warehouse
}
