//! The lines of recipes, as a scene asks for them.
use super::givers::{Giver, Givers};
use super::tools::meets_tools;
use crate::advance::Advance;
use crate::boundary::Boundary;
use crate::drive::Drive;
use crate::drive_nodes::DriveNodes;
use crate::drive_scatter::DriveScatter;
use crate::drive_sum::DriveSum;
use crate::drives::{DriveMotion, Drives};
use crate::fold::Fold;
use crate::fold_surfaces::FoldSurfaces;
use crate::fold_tools::FoldTools;
use crate::force_power::ForcePower;
use crate::force_scatter::ForceScatter;
use crate::forces::{Forces, Pushes};
use crate::images::Images;
use crate::labels::{Reactions, SCHEMA};
use crate::load_power::LoadPower;
use crate::loads::{LoadField, Loads};
use crate::local_damping::LocalDamping;
use crate::mirror::Mirror;
use crate::pic::Pic;
use crate::reflection::Reflection;
use crate::rigid::follow::Follow;
use crate::stress::Stress;
use crate::viscosity::Viscosity;
use crate::weights::Weights;
use engine::data::extent::Bases;
use engine::data::fields::Fields;
use engine::graph::recipe::Recipe;
use engine::graph::task::Runnable;
use engine::schema::{Label, Tiles};
use grid::Lattice;
use physics::faces::FaceCondition;
use physics::law::Law;
use physics::materials::{AnyLaw, WithLaw};
use scene::{ForceKind, Leaving, Rates, Scene, ShapeFunction};
use shapes::gimp::Gimp;
use shapes::linear::Linear;

/// Collects the lines of a recipe.
pub(super) struct Builder<'a> {
    pub(super) scene: &'a Scene,
    recipe: Recipe,
    pub(super) lattice: Lattice,
    pub(super) givers: Givers,
    /// Far below the mass of any particle at any node that it touches noticeably.
    pub(super) least_mass: f64,
}

impl<'a> Builder<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        let materials = scene.materials.iter().map(|m| m.name.clone()).collect();
        let lightest = scene.materials.iter().map(|m| m.density).fold(f64::INFINITY, f64::min);
        let (givers, mut recipe) = (Givers::of(scene), Recipe::new(&SCHEMA, materials));
        recipe.tiles = tiles(scene);
        Self {
            scene,
            recipe,
            givers,
            lattice: Lattice { lower: scene.domain.lower, cell: scene.domain.cell },
            least_mass: 1e-14 * lightest * scene.domain.cell.powi(3),
        }
    }

    pub(super) fn finish(self) -> Recipe {
        self.recipe
    }

    pub(super) fn add(&mut self, material: usize, because: &str, task: impl Runnable + 'static) {
        self.recipe.add(material, because, task);
    }

    /// A task over the nodes of all materials, or once a step.
    pub(super) fn all(&mut self, because: &str, task: impl Runnable + 'static) {
        self.recipe.all(because, task);
    }

    pub(super) fn timestep_size(&mut self) {
        let because = if self.scene.run.rates == Rates::Common { "" } else { "run.rates" };
        self.all(because, super::timestep_size(self.scene));
    }

    pub(super) fn reflection(&mut self) {
        if self.scene.run.leaving == Leaving::Reflect {
            self.all("run.leaving", Reflection);
        }
    }

    fn inverse_cell(&self) -> f64 {
        1.0 / self.scene.domain.cell
    }

    fn bases(&self, material: usize) -> Bases {
        Bases { inverse_cell: self.inverse_cell(), half_size: half_size(self.scene, material) }
    }

    pub(super) fn weights(&mut self, material: usize) {
        let inverse_cell = self.inverse_cell();
        match self.scene.run.shape {
            ShapeFunction::Linear => self.add(material, "run.shape", Weights { shape: Linear, inverse_cell }),
            ShapeFunction::Gimp => {
                let shape = Gimp { half_size: half_size(self.scene, material) };
                self.add(material, "run.shape", Weights { shape, inverse_cell });
            }
        }
    }

    /// The faces beyond which matter goes on.
    fn images(&self) -> Images {
        let faces = self.scene.faces.each_ref().map(|face| face.image());
        Images { faces, cells: self.scene.domain.cells }
    }

    /// The tiles of `Reactions` of the faces; 0 for those that do nothing.
    fn tiles_of_faces(&self) -> [usize; 6] {
        [0, 1, 2, 3, 4, 5].map(|face| self.givers.tile(Giver::Face(face)).unwrap_or(0))
    }

    pub(super) fn fold(&mut self, material: usize) {
        let (images, tiles, lattice) = (self.images(), self.tiles_of_faces(), self.lattice);
        let tools = meets_tools(self.scene, material);
        if images.is_empty() {
            return;
        }
        let pic = self.pic();
        self.add(material, "boundary", Fold { images: images.clone(), tiles, lattice, pic });
        if self.touches(material) {
            self.add(material, "boundary", FoldSurfaces { images: images.clone(), lattice });
        }
        if tools {
            self.add(material, "boundary", FoldTools { images, lattice });
        }
    }

    pub(super) fn mirror(&mut self, material: usize) {
        let images = self.images();
        if !images.is_empty() {
            self.add(material, "boundary", Mirror { images });
        }
    }

    pub(super) fn load_field(&self) -> LoadField {
        let scene::Loads { gravity, damping, .. } = self.scene.loads.clone();
        LoadField { gravity, damping }
    }

    pub(super) fn loads(&mut self) {
        if self.scene.loads.act_on_all() {
            self.all("load", Loads { field: self.load_field(), least_mass: self.least_mass });
        }
    }

    pub(super) fn load_power(&mut self) {
        if self.scene.loads.act_on_all() {
            let tile = self.givers.tile(Giver::Loads).unwrap_or(0);
            self.all("load", LoadPower { tile, lattice: self.lattice });
        }
    }

    pub(super) fn local_damping(&mut self) {
        let share = self.scene.loads.local_damping;
        if share > 0.0 {
            let tile = self.givers.tile(Giver::Loads).unwrap_or(0);
            self.all("load", LocalDamping { share, tile, lattice: self.lattice });
        }
    }

    pub(super) fn boundary(&mut self) {
        if self.scene.faces.iter().any(|f| f.acts()) {
            let task = Boundary {
                faces: self.scene.faces.clone(),
                tiles: self.tiles_of_faces(),
                lattice: self.lattice,
                cells: self.scene.domain.cells,
            };
            self.all("boundary", task);
        }
    }

    pub(super) fn stress(&mut self, material: usize, law: &AnyLaw) {
        law.visit(AddStress(self, material));
    }

    pub(super) fn viscosity(&mut self, material: usize) {
        if let Some(law) = self.scene.run.viscosity {
            self.add(material, "run.viscosity", Viscosity { law, cell: self.scene.domain.cell });
        }
    }

    /// What acts on particles of a material, if anything does.
    fn forces(&self, material: usize) -> Option<Forces> {
        let one = |it: &scene::Force| match it.kind.clone() {
            ForceKind::Total(table) => Pushes::Total(table),
            ForceKind::Traction(table) => Pushes::Traction(table),
            ForceKind::Pressure(table) => Pushes::Pressure(table),
            ForceKind::DeadPressure(table) => Pushes::DeadPressure(table),
        };
        let pushed = self.scene.forces.iter().any(|it| it.material == material);
        pushed.then(|| Forces(self.scene.forces.iter().map(one).collect()))
    }

    pub(super) fn force_scatter(&mut self, material: usize) {
        if let Some(forces) = self.forces(material) {
            self.add(material, "force", ForceScatter { forces });
        }
    }

    pub(super) fn force_power(&mut self, material: usize) {
        if let Some(forces) = self.forces(material) {
            let first = self.givers.tile(Giver::Force(0)).unwrap_or(0);
            self.add(material, "force", ForcePower { forces, first });
        }
    }

    /// What is prescribed, if a material has driven particles.
    fn drives(&self, material: usize) -> Option<Drives> {
        let one = |it: &scene::Drive| DriveMotion {
            motion: it.motion.clone(),
            components: it.components,
            until: it.until,
        };
        let driven = self.scene.drives.iter().any(|it| it.material == material);
        driven.then(|| Drives(self.scene.drives.iter().map(one).collect()))
    }

    pub(super) fn drive_scatter(&mut self, material: usize) {
        if let Some(drives) = self.drives(material) {
            let (images, lattice) = (self.images(), self.lattice);
            self.add(material, "drive", DriveScatter { drives, images, lattice });
        }
    }

    /// Between graphs of one tick.
    pub(super) fn drive_sum(&mut self) {
        if !self.scene.drives.is_empty() {
            self.all("drive", DriveSum);
        }
    }

    pub(super) fn drive_nodes(&mut self) {
        if !self.scene.drives.is_empty() {
            self.all("drive", DriveNodes);
        }
    }

    pub(super) fn drive(&mut self, material: usize) {
        if let Some(drives) = self.drives(material) {
            let (images, lattice) = (self.images(), self.lattice);
            let first = self.givers.tile(Giver::Drive(0)).unwrap_or(0);
            self.add(material, "drive", Drive { drives, first, images, lattice });
        }
    }

    fn pic(&self) -> Pic {
        Pic { share: self.scene.run.pic, rate: self.scene.run.pic_rate }
    }

    pub(super) fn advance(&mut self, material: usize) {
        self.add(material, "", Advance { pic: self.pic(), bases: self.bases(material) });
    }

    pub(super) fn follow(&mut self, material: usize) {
        self.add(material, "material", Follow { bases: self.bases(material) });
    }
}

struct AddStress<'a, 'b>(&'a mut Builder<'b>, usize);

impl WithLaw for AddStress<'_, '_> {
    type Output = ();
    fn with<L: Law>(self, law: L) {
        self.0.add(self.1, "material", Stress(law));
    }
}

/// Particles' half-size in cells along each axis, for the shape function of `scene`; 0 for hats.
pub fn half_size(scene: &Scene, material: usize) -> [f64; 3] {
    match scene.run.shape {
        ShapeFunction::Linear => [0.0; 3],
        ShapeFunction::Gimp => spacing(scene, material).map(|s| 0.5 * s),
    }
}

/// Distance of a material's particles in cells along each axis.
pub(super) fn spacing(scene: &Scene, material: usize) -> [f64; 3] {
    let body = scene.bodies.iter().find(|b| b.material == material);
    body.map_or([0.5; 3], |b| b.particles_per_cell.map(|n| 1.0 / n as f64))
}

pub(super) fn rigid(scene: &Scene) -> Vec<bool> {
    scene.materials.iter().map(scene::Material::is_rigid).collect()
}

/// How many tiles labels have where the scene decides about it.
pub fn tiles(scene: &Scene) -> Tiles {
    let mut tiles = Tiles::default();
    tiles.set(Reactions::ID, Givers::of(scene).0.len());
    tiles
}

/// The velocity fields of a scene: one for each deformable material.
pub fn fields(scene: &Scene) -> Fields {
    Fields::new(rigid(scene).into_iter().map(|rigid| usize::from(!rigid)))
}
