//! The table of labels: every quantity that passes between tasks, with all that the engine needs to know of it.
//!
//! To the right of the tile (eight particles, one node, or one material of the quantity): home, unit, meaning in words and symbols,
//! and what differs from the usual of such labels. See [`engine::schema`].
use crate::node;
use crate::reactions::NUMBERS;
use crate::rigid::newton::BALANCE;
use crate::rigid::state::{RigidState, RigidTrial as RigidTrialTile};
use engine::data::exact_sum::ExactSum;
use engine::data::rates::{Clock, MaterialStep};
use engine::schema::Life::{Carried, Step};
use engine::schema::{Label, Rates, Roles, Schema, block, chunk, material, node, particle, run};
use physics::law::{MAX_COUNTS, MAX_EVENTS, MAX_HISTORY};
use shapes::{NodeRows, Stencil};
use simd::Wide;

/// F of an undeformed particle, row by row.
pub const UNDEFORMED: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
/// The identity of nobody.
const NOBODY: [f64; 1] = [f64::from_bits(u64::MAX)];

engine::labels! {
    Position: [Wide; 3]       = particle("m", "position x_p").in_the_middle();
    Velocity: [Wide; 3]       = particle("m/s", "velocity v_p");
    Mass: Wide                = particle("kg", "mass m_p");
    InitialVolume: Wide       = particle("m^3", "undeformed volume V⁰_p");
    Volume: Wide              = particle("m^3", "volume V_p = J V⁰_p");
    Deformation: [Wide; 9]    = particle("1", "deformation gradient F_p, row by row").inert(&UNDEFORMED);
    KirchhoffStress: [Wide; 6] = particle("Pa", "Kirchhoff stress τ_p: xx xy xz yy yz zz");
    History: Wide             = particle("mixed", "history of the material: what its law keeps, one line a number").by_material();
    ViscousWork: Wide         = particle("J/m^3", "work of the artificial viscosity per reference volume");
    ViscousPressure: Wide     = particle("Pa", "pressure of the artificial viscosity, J q");
    ReferencePosition: [Wide; 3] = particle("m", "place in a rigid body, X_p − X_c");
    InitialPosition: [Wide; 3] = particle("m", "position at the start X_p, for those who look: no task reads it").known();
    DriveIndex: Wide          = particle("1", "1 + index of the drive that moves p, 0: none");
    ForceIndex: Wide          = particle("1", "1 + index of the force that acts on p, 0: none");
    SurfaceArea: [Wide; 3]    = particle("m^2, 1", "area of its undeformed faces on the surface, or its share of a force");
    Bond: Wide                = particle("1", "bond b_p: 1 where it holds, 0 where it is broken");
    Identity: Wide            = particle("1", "identity of p, as the bits of an integer").inert(&NOBODY);

    Weights: Stencil          = chunk("1, 1/m", "weights of the grid nodes around p: S_Ip and its gradient, one axis at a time");
    MassFlow: [Wide; 4]       = chunk("kg, N s", "mass m_p and momentum m_p v_p: what S_Ip distributes to grid nodes");
    StressFlow: [Wide; 7]     = chunk("J, m^3", "internal force −V⁰ τ and volume V: what ∇S_Ip (and S_Ip) distribute to grid nodes");
    ContactFlow: [Wide; 6]    = chunk("kg, kg m, m^3", "surface for contact: m_p, m_p x_p, V_p, m_p b_p, which S_Ip and ∇S_Ip distribute to grid nodes");
    ScatterRows: NodeRows     = chunk("mixed", "what particles give to grid nodes, one row a particle");
    GatherRows: NodeRows      = chunk("mixed", "what particles read from grid nodes, one row a particle");
    GridVelocity: [Wide; 3]   = chunk("m/s", "velocity of the grid at p: Σ_I S_Ip v_I");
    VelocityChange: [Wide; 3] = chunk("m/s", "change of velocity of the grid at p: Σ_I S_Ip Δv_I");
    VelocityGradient: [Wide; 9] = chunk("1/s", "velocity gradient L_p = Σ_I v_I ⊗ ∇S_Ip");
    StiffnessBound: Wide      = chunk("Pa", "upper bound of the stiffness, ρ₀ c²");

    NodeSums: node::Sums      = node("mixed", "sums on grid nodes: mass m, momentum m v (3), internal force f (3), volume V").partials(3);
    DriveSums: node::Driven   = node("kg, N s", "drives on grid nodes: mass that they hold (3), 0, what they give it (3), 0").partials(3).lives(Step);
    DriveGift: node::Gift     = node("N s/kg, m/s", "what drives gave to grid nodes, a mass that they hold (3), 0, (v⁰ + v)/2 (3), 0").values(3);
    ContactSums: node::Surface = node("mixed", "surface on grid nodes, for contact: m, m x (3), Σ V ∇S (3), m b").partials(3).where_fields_meet();
    ToolSums: node::Surface   = node("mixed", "surface on grid nodes near tools: m, m x (3), Σ V ∇S (3), 0").partials(3).where_near();
    ContactImpulse: node::Impulse = node("N s", "impulse of contact in this step: normal (3), what became of a bond, friction (3), what bonds make one")
                                    .values(3).lives(Step).where_fields_meet();
    NodeMotion: node::Motion  = node("m/s, kg", "motion of grid nodes: velocity v (3), mass m, change of v in this step (3), 0").values(3).lives(Step);
    LoadChange: node::Change  = node("m/s", "change of the velocity of grid nodes by loads in this step (3), 0 (5)").lives(Step);
    RigidSite: node::Site     = node("m, kg, Pa", "matter on grid nodes near free rigid bodies: its center (3), m, normal traction, how drives move it (3)").lives(Step);

    BlockExtent: [Wide; 6]    = block("cells", "where the particles of a block are: max of ±(base node), to see who leaves it").largest();

    SignalSpeed: [Wide; 3]    = material("m/s", "speed of signals: max over p of c + |v|, of c, of |v|").largest().lives(Carried);
    OwnStep: MaterialStep     = material("s", "time step of its own that a material is in").lives(Carried);
    Fault: Wide               = material("mixed", "first inadmissible particle: kind, identity, value").first();
    FirstEvent: [Wide; MAX_EVENTS] = material("mixed", "first of each event that the law tells: time, identity, place").first();
    RigidTrial: RigidTrialTile = material("m/s, rad/s", "sought motion of a free rigid body, V and ω: without contact, and as it is sought").lives(Step);
    RigidBalance: [ExactSum; BALANCE] = material("N s, N m s", "what contact gives the matter for a sought motion, and its derivative").exact();
    RigidImpulse: [ExactSum; 6] = material("N s, N m s", "impulse and torque impulse on a rigid body").exact().lives(Carried);
    RigidMotion: RigidState   = material("mixed", "motion of a rigid body: its state").lives(Carried);
    MaterialEnergy: [ExactSum; 5] = material("J", "energy of a material: kinetic, strain, plastic, fracture, viscous").exact();
    MaterialMotion: [ExactSum; 10] = material("mixed", "motion of a material: m, m v (3), m x (3), m x × v (3)").exact();
    MaterialExtent: [Wide; 6] = material("m", "extent of a material: max over p of x_p and of −x_p").largest();
    LargestHistory: [Wide; MAX_HISTORY] = material("mixed", "largest of what the law keeps, over p").largest();
    StateCount: [ExactSum; MAX_COUNTS + 1] = material("1", "particles in each state that the law counts, and at last those that have collapsed").exact();

    Time: Clock               = run("s", "time, tick, and what limits it").lives(Carried);
    StepOver: Wide            = run("1", "1 where all materials are together again: the step is over").lives(Step);
    RigidSolved: Wide         = run("1", "1 where the motion of all free rigid bodies is found").lives(Step);
    ContactWork: [ExactSum; 2] = run("J", "kinetic energy lost in contact: by friction, by impact").exact();
    StressWork: ExactSum      = material("J", "work of internal forces in a step, if they were those of its end: −V⁰ τ : (1 − (1 + Δt L)⁻¹)").exact();
    ForceWork: [ExactSum; 2]  = run("J", "work that internal forces would do in a step at the velocities of its beginning; of that, in first steps").exact();
    TransferLoss: ExactSum    = run("J", "kinetic energy that nodes gain and particles do not").exact();
    Reactions: [ExactSum; NUMBERS] = run("N s, N m s, J", "reactions: impulse (3), its torque about the origin (3) and work of each giver")
                                    .exact().several();
}

/// All labels, and those that the engine reads.
pub static SCHEMA: Schema = Schema::new(
    &ROWS,
    Roles {
        position: Position::ID,
        identity: Identity::ID,
        extent: BlockExtent::ID,
        rates: Some(Rates { clock: Time::ID, steps: OwnStep::ID }),
    },
);
