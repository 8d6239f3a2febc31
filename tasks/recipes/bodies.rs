//! The lines of rigid bodies.
use super::builder::Builder;
use super::givers::Giver;
use super::tools::{obstacles, tools};
use crate::rigid::apart::{Free, RigidApart};
use crate::rigid::bodies::Bodies;
use crate::rigid::carry::RigidCarry;
use crate::rigid::motion::RigidMotion;
use crate::rigid::plan::RigidPlan;
use crate::rigid::predict::RigidPredict;
use crate::rigid::push::{BondedPush, RigidPush};
use crate::rigid::round::{BondedRound, RigidRound};
use crate::rigid::sites::{DrivenSites, RigidSites};
use crate::rigid::solve::RigidSolve;
use crate::tool::Tool;
use physics::solid::dot;
use scene::sampling::{Filling, count, particle_volume};
use scene::{Behavior, RigidMotion as Motion, Scene, Table};
use std::ops::ControlFlow;

impl Builder<'_> {
    fn has_free(&self) -> bool {
        self.scene.materials.iter().any(scene::Material::is_free)
    }

    fn has_prescribed(&self) -> bool {
        self.scene.materials.iter().any(scene::Material::is_tool)
    }

    /// Free rigid bodies that may push something.
    fn bodies(&self) -> Bodies {
        let mut tools = tools(self.scene, &self.givers);
        tools.retain(|tool| tool.body().is_some_and(|m| self.scene.materials[m].is_free()));
        Bodies { tools, lattice: self.lattice, surfaces: self.surface_tables() }
    }

    pub(super) fn rigid_plan(&mut self) {
        let prescribed = self.scene.materials.iter().map(|m| match &m.behavior {
            Behavior::Rigid(Motion::Prescribed { course, spin, .. }) => Some((course.clone(), spin.clone())),
            _ => None,
        });
        let prescribed: Vec<_> = prescribed.collect();
        if self.has_prescribed() {
            self.all("material", RigidPlan { prescribed });
        }
        if self.has_free() {
            let (field, locked) = (self.load_field(), locked(self.scene));
            self.all("material", RigidPredict { field, locked, forces: forces(self.scene) });
        }
    }

    /// What the search for their motion needs to know.
    pub(super) fn rigid_sites(&mut self) {
        if pushes(self.scene) {
            let sites = RigidSites { least_mass: self.least_mass };
            match self.scene.drives.is_empty() {
                true => self.all("contact", sites),
                false => self.all("contact", DrivenSites(sites)),
            }
        }
    }

    /// A round of the search.
    pub(super) fn rigid_round(&mut self) {
        match self.bonds() {
            None => self.all("contact", RigidRound(self.bodies())),
            Some(_) => self.all("contact", BondedRound(self.bodies())),
        }
        self.all("contact", RigidSolve { locked: locked(self.scene) });
    }

    pub(super) fn rigid_push(&mut self) {
        match self.bonds() {
            _ if !pushes(self.scene) => {}
            None => self.all("contact", RigidPush(self.bodies())),
            Some(_) => self.all("contact", BondedPush(self.bodies())),
        }
    }

    /// Watches that free rigid bodies meet nothing rigid.
    pub(super) fn rigid_apart(&mut self) {
        let scene = self.scene;
        let free = (0..scene.materials.len()).filter(|&m| scene.materials[m].is_free());
        let bodies: Vec<Free> = free.map(|m| Free::new(m, surface_points(scene, m))).collect();
        let obstacles: Vec<Tool> = obstacles(scene).into_iter().map(|(_, tool)| tool).collect();
        if !bodies.is_empty() && obstacles.len() > 1 {
            self.all("material", RigidApart { bodies, obstacles });
        }
    }

    pub(super) fn rigid_motion(&mut self) {
        if self.has_prescribed() {
            self.all("material", RigidCarry);
        }
        if self.has_free() {
            let lock =
                |m: usize| self.givers.tile(Giver::Rigid(m)).filter(|_| self.scene.materials[m].is_free());
            let task = RigidMotion {
                locked: locked(self.scene),
                loads: self.givers.tile(Giver::Loads),
                locks: (0..self.scene.materials.len()).map(lock).collect(),
            };
            self.all("material", task);
        }
    }
}

/// Whether free rigid bodies push matter: then their motion has to be searched for.
pub fn pushes(scene: &Scene) -> bool {
    scene.contacts.iter().any(|contact| contact.between.iter().any(|&m| scene.materials[m].is_free()))
}

/// The particles of a rigid material that lie next to its surface [m].
fn surface_points(scene: &Scene, material: usize) -> Vec<[f64; 3]> {
    let mut points = Vec::new();
    for body in scene.bodies_of(material) {
        let n = body.particles_per_cell.iter().copied().min().unwrap_or(1);
        let (solid, depth, filling) = (&body.solid, -scene.domain.cell / n as f64, Filling::of(scene, body));
        // no distance changes faster than the point moves
        let deep = |(lower, upper): ([f64; 3], [f64; 3])| {
            let half: [f64; 3] = std::array::from_fn(|a| 0.5 * (upper[a] - lower[a]));
            let middle = std::array::from_fn(|a| lower[a] + half[a]);
            solid.distance(middle).0 + dot(half, half).sqrt() * (1.0 + 1e-9) < depth * (1.0 + 1e-9)
        };
        let first = points.len();
        let _ = filling.search(filling.span(), &deep, &mut |at, x| {
            if solid.distance(x).0 > depth {
                points.push((filling.order(at), x));
            }
            ControlFlow::<()>::Continue(())
        });
        points[first..].sort_unstable_by_key(|(order, _)| *order);
    }
    points.into_iter().map(|(_, x)| x).collect()
}

/// The force on each free rigid material in time [N].
pub fn forces(scene: &Scene) -> Vec<Table> {
    let one = |m: &scene::Material| match &m.behavior {
        Behavior::Rigid(Motion::Free { force, .. }) => force.clone(),
        _ => Table::zero(),
    };
    scene.materials.iter().map(one).collect()
}

/// What these forces make of the mass of the bodies [m/s²].
pub fn accelerations(scene: &Scene) -> Vec<Table> {
    let of = |(m, force): (usize, Table)| {
        if !force.acts() {
            return force;
        }
        let volume = |body: &scene::Body| count(scene, body) as f64 * particle_volume(scene, body);
        let mass = scene.materials[m].density * scene.bodies_of(m).map(volume).sum::<f64>();
        Table(force.0.into_iter().map(|(t, f)| (t, f.map(|f| f / mass))).collect())
    };
    forces(scene).into_iter().enumerate().map(of).collect()
}

/// The axes along which each material does not move, and about which it does not turn.
fn locked(scene: &Scene) -> Vec<[bool; 6]> {
    let one = |m: &scene::Material| match m.behavior {
        Behavior::Rigid(Motion::Free { locked: [x, y, z], locked_turns: [u, v, w], .. }) => {
            [x, y, z, u, v, w]
        }
        _ => [false; 6],
    };
    scene.materials.iter().map(one).collect()
}
