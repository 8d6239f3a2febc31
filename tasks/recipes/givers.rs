//! Who acts on the matter from outside, or between materials: the tiles of label `Reactions`.
use physics::faces::FaceCondition;
use scene::{Behavior, RigidMotion, Scene};

/// Who gives something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Giver {
    /// A face of the domain, 0 to 5: x−, x+, y−, y+, z−, z+.
    Face(usize),
    /// Gravity and damping.
    Loads,
    /// A force, by its index in the scene.
    Force(usize),
    /// A drive, by its index in the scene.
    Drive(usize),
    /// A rigid material that is held: where its motion is prescribed, what holds it gives to the matter, through it; where it is free, its
    /// force and its locks give to it.
    Rigid(usize),
    /// A contact, by its index in the scene: what the second material gives to the first one.
    Contact(usize),
}

/// Faces in the order of `Scene::faces`.
const FACES: [&str; 6] = ["x-min", "x-max", "y-min", "y-max", "z-min", "z-max"];

impl Giver {
    /// Its name in files: `face.x-min`, `loads`, `force.NAME`, `drive.NAME`, `rigid.MATERIAL`, `contact.FIRST.SECOND`.
    pub fn name(self, scene: &Scene) -> String {
        let material = |m: usize| &scene.materials[m].name;
        match self {
            Giver::Face(face) => format!("face.{}", FACES[face]),
            Giver::Loads => "loads".to_owned(),
            Giver::Force(force) => format!("force.{}", scene.forces[force].name),
            Giver::Drive(drive) => format!("drive.{}", scene.drives[drive].name),
            Giver::Rigid(body) => format!("rigid.{}", material(body)),
            Giver::Contact(contact) => {
                let [a, b] = scene.contacts[contact].between;
                format!("contact.{}.{}", material(a), material(b))
            }
        }
    }

    /// Whether it gives from outside: what materials exchange adds up to nothing.
    pub fn is_outside(self) -> bool {
        !matches!(self, Giver::Contact(_))
    }
}

/// All givers of a scene, in the order of the tiles of label `Reactions`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Givers(pub Vec<Giver>);

impl Givers {
    /// Those of a scene.
    pub fn of(scene: &Scene) -> Self {
        let reflects = scene.run.leaving == scene::Leaving::Reflect;
        let faces = (0..6)
            .filter(|&face| reflects || scene.faces[face].acts() || scene.faces[face].wall().is_some())
            .map(Giver::Face);
        let held = |material: &scene::Material| match &material.behavior {
            Behavior::Rigid(RigidMotion::Prescribed { .. }) => true,
            Behavior::Rigid(RigidMotion::Free { locked, locked_turns, force, .. }) => {
                locked.contains(&true) || locked_turns.contains(&true) || force.acts()
            }
            Behavior::Deformable(_) => false,
        };
        let rigid = scene.materials.iter().enumerate().filter(|(_, material)| held(material));
        let all = faces.chain(scene.loads.acts().then_some(Giver::Loads));
        let all = all.chain((0..scene.forces.len()).map(Giver::Force));
        let all = all.chain((0..scene.drives.len()).map(Giver::Drive));
        let all = all.chain(rigid.map(|(material, _)| Giver::Rigid(material)));
        Self(all.chain((0..scene.contacts.len()).map(Giver::Contact)).collect())
    }

    /// The tile of a giver.
    pub fn tile(&self, giver: Giver) -> Option<usize> {
        self.0.iter().position(|it| *it == giver)
    }
}
