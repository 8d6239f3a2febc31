//! A particle of a body as the scene describes it.
use crate::simulation::RunError;
use crate::simulation::surfaces::Surfaces;
use engine::data::layout::ParticleLayout;
use engine::data::warehouse::Warehouse;
use engine::exec::ranks::{Network, collective};
use engine::schema::{Label, LabelId};
use physics::contact::cross;
use physics::law::{Law, Reference};
use physics::materials::WithLaw;
use scene::{Behavior, Scene, sampling};
use tasks::labels::{
    Bond, Deformation, DriveIndex, ForceIndex, History, Identity, InitialPosition, InitialVolume, Mass,
    Position, SurfaceArea, UNDEFORMED, Velocity, Volume,
};

struct Initial(Reference);
impl WithLaw for Initial {
    type Output = Vec<f64>;
    fn with<L: Law>(self, law: L) -> Vec<f64> {
        let mut history = vec![0.0; L::HISTORY.len()];
        law.initial(&self.0, &mut history);
        history
    }
}

/// What a law keeps of a particle at the start.
pub(in crate::simulation) fn history(behavior: &Behavior, reference: Reference) -> Vec<f64> {
    match behavior {
        Behavior::Deformable(law) => law.visit(Initial(reference)),
        Behavior::Rigid(_) => Vec::new(),
    }
}

/// Makes the particles of a body.
#[derive(Clone)]
pub(in crate::simulation) struct Maker<'a> {
    scene: &'a Scene,
    surfaces: &'a Surfaces<'a>,
    /// The body's number, and that of its material.
    pub index: usize,
    pub material: usize,
    /// About which it turns [m].
    center: [f64; 3],
    layout: ParticleLayout,
    /// What a scene does not say is as where there is no particle.
    inert: Vec<f64>,
    record: Vec<f64>,
    /// Volume of a particle [m³], and how much larger that is than undeformed.
    volume: [f64; 2],
    stretched: [f64; 9],
    /// The first particle that is claimed twice.
    pub clash: Option<Clash>,
}

/// A particle that two drives hold, or on which two forces act.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::simulation) struct Clash {
    identity: u64,
    drives: bool,
    /// The numbers of both.
    between: [usize; 2],
    /// Where it is, as bits [m].
    position: [u64; 3],
}

impl Clash {
    /// The first one of all ranks is the error of all.
    pub fn agree(found: Option<Self>, scene: &Scene, network: &mut dyn Network) -> Result<(), RunError> {
        let words = found.map_or(Vec::new(), |it| {
            let [a, b] = it.between.map(|number| number as u64);
            [[it.identity, u64::from(it.drives), a, b].as_slice(), &it.position].concat()
        });
        let all = collective::share(network, &words)?;
        let read = |words: &Vec<u64>| match words[..] {
            [identity, drives, a, b, x, y, z] => {
                let between = [a, b].map(|number| number as usize);
                Some(Self { identity, drives: drives > 0, between, position: [x, y, z] })
            }
            _ => None,
        };
        let Some(first) = all.iter().filter_map(read).min() else { return Ok(()) };
        let position = first.position.map(f64::from_bits);
        Err(match first.drives {
            true => {
                RunError::TwoDrives { names: first.between.map(|it| scene.drives[it].name.clone()), position }
            }
            false => {
                RunError::TwoForces { names: first.between.map(|it| scene.forces[it].name.clone()), position }
            }
        })
    }
}

impl<'a> Maker<'a> {
    pub fn new(
        scene: &'a Scene,
        surfaces: &'a Surfaces<'a>,
        index: usize,
        center: [f64; 3],
        warehouse: &Warehouse,
    ) -> Self {
        let (body, material) = (&scene.bodies[index], scene.bodies[index].material);
        let layout = warehouse.materials[material].layout.clone();
        let volume = [sampling::particle_volume(scene, body), body.stretch.iter().product()];
        let mut stretched = UNDEFORMED;
        (0..3).for_each(|a| stretched[4 * a] = body.stretch[a]);
        let inert = layout.inert_record([0.0; 3]);
        let (record, clash) = (inert.clone(), None);
        Self { scene, surfaces, index, material, center, layout, inert, record, volume, stretched, clash }
    }

    /// The drive that holds the particle at `x`; two are a fault.
    fn drive(&self, x: [f64; 3]) -> Result<Option<usize>, [usize; 2]> {
        let drives = &self.scene.drives;
        let holds =
            |d: &usize| drives[*d].material == self.material && drives[*d].region.contains(self.index, x);
        let mut holding = (0..drives.len()).filter(holds);
        match (holding.next(), holding.next()) {
            (Some(first), Some(other)) => Err([first, other]),
            (drive, _) => Ok(drive),
        }
    }

    fn note(&mut self, drives: bool, between: [usize; 2], identity: u64, x: [f64; 3]) {
        let here = Clash { identity, drives, between, position: x.map(f64::to_bits) };
        self.clash = Some(self.clash.map_or(here, |known| known.min(here)));
    }

    /// The record of the particle at `x`.
    pub fn make(&mut self, identity: u64, x: [f64; 3]) -> &[f64] {
        let drive = self.drive(x).unwrap_or_else(|both| {
            self.note(true, both, identity, x);
            None
        });
        let force = self.surfaces.on(self.index, x).unwrap_or_else(|both| {
            self.note(false, both, identity, x);
            None
        });
        let body = &self.scene.bodies[self.index];
        let material = &self.scene.materials[body.material];
        let reference = Reference { fiber: sampling::fiber_at(&body.fibers, x), stretch: body.stretch };
        let history = history(&material.behavior, reference);
        let Self { layout, inert, record, volume: [volume, j], stretched, center, .. } = self;
        record.copy_from_slice(inert);
        let mut set = |label: LabelId, numbers: &[f64]| {
            let width = layout.width(label);
            record[layout.starts[label.index()]..][..width].copy_from_slice(&numbers[..width]);
        };
        set(Position::ID, &x);
        set(InitialPosition::ID, &x);
        let turned = cross(body.angular_velocity, std::array::from_fn(|a| x[a] - center[a]));
        set(Velocity::ID, &[0, 1, 2].map(|a| body.velocity[a] + turned[a]));
        set(Mass::ID, &[material.density * *volume / *j]);
        set(InitialVolume::ID, &[*volume / *j]);
        set(Deformation::ID, stretched);
        set(Volume::ID, &[*volume]);
        set(History::ID, &history);
        set(Bond::ID, &[1.0]);
        set(ForceIndex::ID, &[force.map_or(0.0, |(number, _)| number as f64 + 1.0)]);
        set(SurfaceArea::ID, &force.map_or([0.0; 3], |(_, area)| area));
        set(DriveIndex::ID, &[drive.map_or(0.0, |d| d as f64 + 1.0)]);
        set(Identity::ID, &[f64::from_bits(identity)]);
        record
    }
}
