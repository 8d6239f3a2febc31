//! What history and summary report.
use super::builder::Builder;
use crate::report::{ReportLaw, ReportMotion, ReportViscosity};
use engine::graph::recipe::Recipe;
use physics::law::Law;
use physics::materials::WithLaw;
use scene::{Behavior, Scene};

/// Sums over the particles of each material.
pub fn report(scene: &Scene) -> Recipe {
    let mut recipe = Builder::new(scene);
    for (m, material) in scene.materials.iter().enumerate().filter(|(_, m)| !m.is_tool()) {
        recipe.add(m, "output.history-every", ReportMotion);
        if let Behavior::Deformable(law) = &material.behavior {
            law.visit(AddReport(&mut recipe, m));
            if scene.run.viscosity.is_some() {
                recipe.add(m, "run.viscosity", ReportViscosity);
            }
        }
    }
    recipe.finish()
}

struct AddReport<'a, 'b>(&'a mut Builder<'b>, usize);

impl WithLaw for AddReport<'_, '_> {
    type Output = ();
    fn with<L: Law>(self, law: L) {
        self.0.add(self.1, "output.history-every", ReportLaw(law));
    }
}
