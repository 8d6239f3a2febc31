//! The recipe: one explicit step of the material point method (USL), as an ordered list of tasks.
//!
//! The list is the algorithm. The graph derives the edges, drops what nobody needs and fuses neighbors; what the
//! scene does not ask for is not in the list.
use super::advance::Advance;
use super::boundary::Boundary;
use super::contact::Contact;
use super::contact_begin::ContactBegin;
use super::contact_flow::ContactFlow;
use super::contact_power::ContactPower;
use super::contact_scatter::ContactScatter;
use super::drive::Drive;
use super::gather::Gather;
use super::grid_power::GridPower;
use super::integrate::Integrate;
use super::load_power::LoadPower;
use super::loads::{LoadField, Loads};
use super::mass_flow::MassFlow;
use super::nodal_velocity::NodalVelocity;
use super::report::{ReportLaw, ReportMotion, ReportViscosity};
use super::rest::Rest;
use super::rigid::contact::RigidContact;
use super::rigid::flow::RigidFlow;
use super::rigid::follow::Follow;
use super::rigid::motion::RigidMotion;
use super::rigid::velocity::RigidVelocity;
use super::scatter::Scatter;
use super::signal_speed::SignalSpeed;
use super::stress::Stress;
use super::stress_flow::StressFlow;
use super::timestep_size::TimestepSize;
use super::viscosity::Viscosity;
use super::weights::Weights;
use crate::graph::recipe::{Entry, Recipe};
use crate::graph::task::Runnable;
use crate::input::scene::{Behavior, Rates, RigidMotion as Motion, Scene, ShapeFunction};
use crate::physics::contact::surface::SurfaceTable;
use crate::physics::faces::FaceCondition;
use crate::physics::lattice::Lattice;
use crate::physics::law::Law;
use crate::physics::materials::{AnyLaw, WithLaw};
use crate::physics::shape::gimp::Gimp;
use crate::physics::shape::linear::Linear;

/// One time step.
pub fn timestep(scene: &Scene) -> Recipe {
    let mut recipe = Builder::new(scene);
    recipe.timestep_size();
    for m in 0..scene.materials.len() {
        recipe.weights(m);
        match &scene.materials[m].behavior {
            Behavior::Deformable(_) => {
                recipe.add(m, "", MassFlow);
                recipe.add(m, "", StressFlow);
            }
            Behavior::Rigid(_) => recipe.add(m, "material", RigidFlow),
        }
        recipe.add(m, "", Scatter);
        if recipe.touches(m) {
            recipe.add(m, "contact", ContactFlow);
            recipe.add(m, "contact", ContactScatter);
        }
    }

    recipe.all("", NodalVelocity { least_mass: recipe.least_mass });
    recipe.rigid_velocity();
    recipe.contact_begin();
    recipe.contact();
    recipe.all("", Integrate { least_mass: recipe.least_mass });
    recipe.loads();
    recipe.rigid_velocity();
    recipe.contact();
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
                recipe.weights(m);
                recipe.add(m, "", Gather);
                recipe.stress(m, law);
                recipe.viscosity(m);
                recipe.drive(m);
                recipe.advance(m);
                recipe.add(m, "", SignalSpeed);
            }
            Behavior::Rigid(_) => recipe.follow(m),
        }
    }
    recipe.finish()
}

/// Before the first step: laws in the state that the scene gave, for the first step's size.
pub fn start(scene: &Scene) -> Recipe {
    let mut recipe = Builder::new(scene);
    for m in 0..scene.materials.len() {
        match &scene.materials[m].behavior {
            Behavior::Deformable(law) => {
                recipe.add(m, "", Rest);
                recipe.stress(m, law);
                recipe.add(m, "", SignalSpeed);
            }
            Behavior::Rigid(_) => recipe.follow(m),
        }
    }
    recipe.finish()
}

/// What history and summary report.
pub fn report(scene: &Scene) -> Recipe {
    let mut recipe = Builder::new(scene);
    for (m, material) in scene.materials.iter().enumerate() {
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
    TimestepSize {
        cfl: scene.run.cfl,
        cell: scene.domain.cell,
        most: f64::from(most),
        touches: (0..scene.materials.len()).map(touching).collect(),
        rigid: rigid(scene),
    }
}

fn rigid(scene: &Scene) -> Vec<bool> {
    scene.materials.iter().map(|m| matches!(m.behavior, Behavior::Rigid(_))).collect()
}

/// Particles' half-size in cells along each axis, for the shape function of `scene`; 0 for hats.
pub fn half_size(scene: &Scene, material: usize) -> [f64; 3] {
    match scene.run.shape {
        ShapeFunction::Linear => [0.0; 3],
        ShapeFunction::Gimp => spacing(scene, material).map(|s| 0.5 * s),
    }
}

/// Distance of a material's particles in cells along each axis.
fn spacing(scene: &Scene, material: usize) -> [f64; 3] {
    let body = scene.bodies.iter().find(|b| b.material == material);
    body.map_or([0.5; 3], |b| b.particles_per_cell.map(|n| 1.0 / n as f64))
}

/// Collects the lines of a recipe.
struct Builder<'a> {
    scene: &'a Scene,
    recipe: Recipe,
    rigid: Vec<bool>,
    lattice: Lattice,
    /// Far below the mass of any particle at any node that it touches noticeably.
    least_mass: f64,
}

impl<'a> Builder<'a> {
    fn new(scene: &'a Scene) -> Self {
        let materials = scene.materials.iter().map(|m| m.name.clone()).collect();
        let lightest = scene.materials.iter().map(|m| m.density).fold(f64::INFINITY, f64::min);
        Self {
            scene,
            recipe: Recipe { entries: Vec::new(), materials },
            rigid: rigid(scene),
            lattice: Lattice { lower: scene.domain.lower, cell: scene.domain.cell },
            least_mass: 1e-14 * lightest * scene.domain.cell.powi(3),
        }
    }

    fn finish(self) -> Recipe {
        self.recipe
    }

    fn push(&mut self, material: Option<usize>, because: &str, task: impl Runnable + 'static) {
        let because = because.to_owned();
        self.recipe.entries.push(Entry { task: Box::new(task), material, because });
    }

    fn add(&mut self, material: usize, because: &str, task: impl Runnable + 'static) {
        self.push(Some(material), because, task);
    }

    /// A task over the nodes of all materials, or once a step.
    fn all(&mut self, because: &str, task: impl Runnable + 'static) {
        self.push(None, because, task);
    }

    fn timestep_size(&mut self) {
        let because = if self.scene.run.rates == Rates::Common { "" } else { "run.rates" };
        self.all(because, timestep_size(self.scene));
    }

    fn inverse_cell(&self) -> f64 {
        1.0 / self.scene.domain.cell
    }

    fn touches(&self, material: usize) -> bool {
        self.scene.contacts.iter().any(|c| c.between.contains(&material))
    }

    fn weights(&mut self, material: usize) {
        let inverse_cell = self.inverse_cell();
        match self.scene.run.shape {
            ShapeFunction::Linear => self.add(material, "run.shape", Weights { shape: Linear, inverse_cell }),
            ShapeFunction::Gimp => {
                let shape = Gimp { half_size: half_size(self.scene, material) };
                self.add(material, "run.shape", Weights { shape, inverse_cell });
            }
        }
    }

    fn rigid_velocity(&mut self) {
        if self.rigid.contains(&true) {
            let task = RigidVelocity { lattice: self.lattice, rigid: self.rigid.clone() };
            self.all("material", task);
        }
    }

    fn contact_begin(&mut self) {
        if !self.scene.contacts.is_empty() {
            self.all("contact", ContactBegin);
        }
    }

    fn contact_power(&mut self) {
        if !self.scene.contacts.is_empty() {
            self.all("contact", ContactPower);
        }
    }

    fn contact(&mut self) {
        if self.scene.contacts.is_empty() {
            return;
        }
        let surfaces = (0..self.scene.materials.len()).map(|m| {
            let mean = |numbers: [f64; 3]| numbers.iter().sum::<f64>() / 3.0;
            SurfaceTable::new(0.5 * mean(spacing(self.scene, m)), mean(half_size(self.scene, m)))
        });
        let task = Contact {
            pairs: self.scene.contacts.clone(),
            lattice: self.lattice,
            least_mass: self.least_mass,
            rigid: self.rigid.clone(),
            surfaces: surfaces.collect(),
            symmetric: self.scene.faces.each_ref().map(|face| face.is_mirror()),
            cells: self.scene.domain.cells,
        };
        if self.rigid.contains(&true) {
            self.all("contact", RigidContact(task));
        } else {
            self.all("contact", task);
        }
    }

    /// What acts everywhere, if the scene has it.
    fn field(&self) -> Option<LoadField> {
        let (gravity, damping) = (self.scene.gravity, self.scene.damping);
        (gravity != [0.0; 3] || damping != 0.0).then_some(LoadField { gravity, damping })
    }

    fn loads(&mut self) {
        if let Some(field) = self.field() {
            let task = Loads { field, least_mass: self.least_mass, rigid: self.rigid.clone() };
            self.all("load", task);
        }
    }

    fn load_power(&mut self) {
        if let Some(field) = self.field() {
            let task = LoadPower { field, least_mass: self.least_mass, rigid: self.rigid.clone() };
            self.all("load", task);
        }
    }

    fn boundary(&mut self) {
        if self.scene.faces.iter().any(|f| f.acts()) {
            let task = Boundary {
                faces: self.scene.faces.clone(),
                cells: self.scene.domain.cells,
                rigid: self.rigid.clone(),
            };
            self.all("boundary", task);
        }
    }

    fn rigid_motion(&mut self) {
        let prescribed = self.scene.materials.iter().map(|m| match &m.behavior {
            Behavior::Rigid(Motion::Prescribed { velocity, .. }) => Some(velocity.clone()),
            _ => None,
        });
        let task = RigidMotion { prescribed: prescribed.collect(), gravity: self.scene.gravity };
        self.all("material", task);
    }

    fn stress(&mut self, material: usize, law: &AnyLaw) {
        law.visit(AddStress(self, material));
    }

    fn viscosity(&mut self, material: usize) {
        if let Some(law) = self.scene.run.viscosity {
            self.add(material, "run.viscosity", Viscosity { law, cell: self.scene.domain.cell });
        }
    }

    fn drive(&mut self, material: usize) {
        if self.scene.drives.iter().any(|d| d.material == material) {
            let drives = self.scene.drives.iter().map(|d| d.velocity.clone()).collect();
            self.add(material, "drive", Drive { drives });
        }
    }

    fn advance(&mut self, material: usize) {
        let (inverse_cell, half_size) = (self.inverse_cell(), half_size(self.scene, material));
        self.add(material, "", Advance { pic: self.scene.run.pic, inverse_cell, half_size });
    }

    fn follow(&mut self, material: usize) {
        let (inverse_cell, half_size) = (self.inverse_cell(), half_size(self.scene, material));
        self.add(material, "material", Follow { inverse_cell, half_size });
    }
}

struct AddStress<'a, 'b>(&'a mut Builder<'b>, usize);

impl WithLaw for AddStress<'_, '_> {
    type Output = ();
    fn with<L: Law>(self, law: L) {
        self.0.add(self.1, "material", Stress(law));
    }
}

struct AddReport<'a, 'b>(&'a mut Builder<'b>, usize);

impl WithLaw for AddReport<'_, '_> {
    type Output = ();
    fn with<L: Law>(self, law: L) {
        self.0.add(self.1, "output.history-every", ReportLaw(law));
    }
}
