//! What a run says of itself at one time.
use physics::contact::cross;
use tasks::recipes::Giver;
use tasks::rigid::rotation;
use tasks::rigid::state::RigidState;

/// Energies of one material [J].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energies {
    /// ½ Σ m v²
    pub kinetic: f64,
    /// Stored elastically.
    pub strain: f64,
    /// Spent on plastic flow.
    pub plastic: f64,
    /// Released by failure.
    pub fracture: f64,
    /// Turned into heat by artificial viscosity.
    pub viscous: f64,
}

impl Energies {
    /// The sum.
    pub fn total(&self) -> f64 {
        self.kinetic + self.strain + self.plastic + self.fracture + self.viscous
    }
}

/// One material at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialReport {
    /// Energies [J].
    pub energies: Energies,
    /// Mass [kg].
    pub mass: f64,
    /// Momentum [N s].
    pub momentum: [f64; 3],
    /// How a tool moves [m/s], which has no mass.
    pub tool: Option<[f64; 3]>,
    /// How far the center of a rigid body has gone [m], and its angular velocity [rad/s].
    pub rigid: Option<[[f64; 3]; 2]>,
    /// Center of mass [m]; of a tool, that about which it turns.
    pub center: [f64; 3],
    /// The box around its particles [m]; `None` if there are none.
    pub extent: Option<[[f64; 3]; 2]>,
    /// The largest of what its law keeps, by the law's names.
    pub largest: Vec<(&'static str, f64)>,
    /// Angular momentum about the origin [N m s].
    pub angular_momentum: [f64; 3],
    /// Particles in each state that its law counts, by the law's names.
    pub counts: Vec<(&'static str, u64)>,
    /// Number of particles.
    pub particles: u64,
    /// The first of each event that its law tells, by the law's names.
    pub first: Vec<(&'static str, Option<FirstEvent>)>,
}

impl MaterialReport {
    /// Mean velocity [m/s].
    pub fn velocity(&self) -> [f64; 3] {
        if let Some(velocity) = self.tool {
            return velocity;
        }
        self.momentum.map(|p| if self.mass > 0.0 { p / self.mass } else { 0.0 })
    }

    /// Particles in a state; none if the law does not count it.
    pub fn count(&self, state: &str) -> u64 {
        self.counts.iter().filter(|(name, _)| *name == state).map(|(_, count)| count).sum()
    }
}

/// When and where an event of a law happened first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstEvent {
    /// When [s].
    pub time: f64,
    /// Which particle.
    pub particle: u64,
    /// Where [m].
    pub position: [f64; 3],
}

/// What a face, a drive, a prescribed body or loads have given to the matter so far, or one material to another in a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct GiverReport {
    /// Who.
    pub giver: Giver,
    /// Its name in files.
    pub name: String,
    /// Impulse so far [N s].
    pub impulse: [f64; 3],
    /// Torque impulse about the origin so far [N m s].
    pub torque_impulse: [f64; 3],
    /// Work so far [J]; not of contacts, whose losses are accounts of their own.
    pub work: f64,
    /// How far the center of a drive has gone [m].
    pub displacement: Option<[f64; 3]>,
    /// Mean force since the last row of the history [N].
    pub force: [f64; 3],
    /// Mean torque about the origin since then [N m].
    pub torque: [f64; 3],
}

/// All accounts at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Time [s].
    pub time: f64,
    /// Steps taken.
    pub steps: u64,
    /// Size of the last step [s].
    pub step: f64,
    /// What limited the last step: a material, or the end of the run.
    pub limited_by: String,
    /// The materials.
    pub materials: Vec<MaterialReport>,
    /// Kinetic energy lost to friction so far [J].
    pub friction: f64,
    /// Kinetic energy lost in impact at nodes so far [J].
    pub impact: f64,
    /// Kinetic energy lost in the transfer between particles and nodes so far [J].
    pub transfer: f64,
    /// What internal forces do to velocities in half a step, by which they are behind positions; now, less that at the start [J].
    pub half_step: f64,
    /// Who has given what.
    pub givers: Vec<GiverReport>,
    /// What the probes of the scene show, component by component.
    pub probes: Vec<f64>,
    /// Work of boundaries, drives and loads so far [J].
    pub boundary_work: f64,
    /// Impulse of boundaries, drives and loads so far [N s].
    pub boundary_impulse: [f64; 3],
    /// Energy that left with deleted particles (their kinetic energy) [J].
    pub deleted_energy: f64,
    /// Deleted particles.
    pub deleted: u64,
    /// How often a particle was put back into the domain.
    pub reflected: u64,
    /// What the accounts do not explain [J]: initial energy + boundary work − all energy now, with `half_step`.
    pub residual: f64,
    /// Angular momentum about the origin that the transfer between particles and nodes has taken so far [N m s]: what there was and what
    /// all torques gave, without what there is.
    pub spin_lost: [f64; 3],
    /// The energy turned over [J]: the most that there was, and Σ |work|.
    pub turnover: f64,
}

impl Report {
    /// Angular momentum of all materials about the origin [N m s].
    pub fn angular_momentum(&self) -> [f64; 3] {
        let sum = |a: usize| self.materials.iter().map(|m| m.angular_momentum[a]).sum();
        [0, 1, 2].map(sum)
    }

    /// Energy of all materials [J].
    pub fn energy(&self) -> Energies {
        self.materials.iter().fold(Energies::default(), |a, m| Energies {
            kinetic: a.kinetic + m.energies.kinetic,
            strain: a.strain + m.energies.strain,
            plastic: a.plastic + m.energies.plastic,
            fracture: a.fracture + m.energies.fracture,
            viscous: a.viscous + m.energies.viscous,
        })
    }
}

/// The report of a free rigid body: what it is as a whole, and not the sum of particles that are points.
pub(super) fn as_one(report: MaterialReport, body: &RigidState) -> MaterialReport {
    let spin = rotation::momentum(body);
    let square = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>();
    let turning: f64 = (0..3).map(|a| body.angular[a] * spin[a]).sum();
    let momentum = body.velocity.map(|v| body.mass * v);
    let about = cross(body.center, momentum);
    MaterialReport {
        energies: Energies {
            kinetic: 0.5 * (body.mass * square(body.velocity) + turning),
            ..report.energies
        },
        mass: body.mass,
        momentum,
        center: body.center,
        angular_momentum: [0, 1, 2].map(|a| about[a] + spin[a]),
        ..report
    }
}
