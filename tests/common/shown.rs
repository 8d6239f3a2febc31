//! A scene with all that its graphs are shown with.
#![allow(dead_code)] // each test takes what it needs
use crate::common::{Overrides, problem};
use engine::graph::build::TaskGraph;
use engine::program::Program;
use scene::Scene;
use sinew::lab::diagram::{Chart, Diagram};
use sinew::lab::plan::{Plan, plan};
use sinew::simulation::rates::Cycle;
use sinew::simulation::{rates, step_program};

pub struct Shown {
    pub scene: Scene,
    pub program: Program,
    pub cycle: Cycle,
    pub plan: Plan,
}

pub fn shown(name: &str, overrides: Overrides<'_>, patches: [usize; 3], ranks: usize) -> Shown {
    let mut scene = problem(name, overrides);
    scene.run.patches = Some(scene::Patches::Grid(patches));
    let plan = plan(&scene, 1, ranks).unwrap_or_else(|e| panic!("{e}"));
    let program = step_program(&scene, patches.iter().product()).unwrap_or_else(|e| panic!("{e}"));
    let cycle = rates::at_rest(&scene);
    Shown { scene, program, cycle, plan }
}

impl Shown {
    pub fn diagram(&self, expanded: bool) -> Diagram<'_> {
        let make = if expanded { Diagram::expanded } else { Diagram::collapsed };
        make(self.graph(), &self.cycle, &self.plan.traffic, None)
    }

    pub fn chart(&self, expanded: bool) -> Chart<'_> {
        Chart::new(&self.program, &self.cycle, &self.plan.traffic, None, expanded)
    }

    pub fn graph(&self) -> &TaskGraph {
        self.program.main_graph()
    }
}
