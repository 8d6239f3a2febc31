//! The table of labels: every quantity that passes between tasks, with home, unit and symbol.
use super::exact_sum::ExactSum;
use super::label::{Home, Reduce, labels};
use super::shared::{Clock, MaterialStep, RigidState};
use crate::physics::law::{MAX_COUNTS, MAX_EVENTS};
use crate::physics::shape::{NodeRows, Stencil};
use crate::simd::Wide;
use bytemuck::Pod;

/// A quantity, known to the compiler as a zero-sized type.
pub trait Label {
    /// Its row in the table.
    const ID: LabelId;
    /// Eight particles of the quantity, one node, or one material.
    type Tile: Pod;
}

labels! {
    Position:         Particle, [Wide; 3], "m",       "x_p";
    Velocity:         Particle, [Wide; 3], "m/s",     "v_p";
    Mass:             Particle, Wide,      "kg",      "m_p";
    InitialVolume:    Particle, Wide,      "m^3",     "V0_p";
    Volume:           Particle, Wide,      "m^3",     "V_p = J V0_p";
    Deformation:      Particle, [Wide; 9], "1",       "F_p, row by row";
    KirchhoffStress:  Particle, [Wide; 6], "Pa",      "tau_p: xx xy xz yy yz zz";
    History:          Particle, Wide,      "mixed",   "what the law keeps, one line a number";
    ViscousWork:      Particle, Wide,      "J/m^3",   "work of the artificial viscosity per reference volume";
    ReferencePosition: Particle, [Wide; 3], "m",      "X_p - X_c of a rigid body's particle";
    DriveIndex:       Particle, Wide,      "1",       "1 + index of the drive that moves p, 0: none";
    Identity:         Particle, Wide,      "1",       "identity of p, as the bits of an integer";

    Weights:          Chunk,    Stencil,   "1, 1/m",  "S_Ip and its gradient, one axis at a time";
    MassFlow:         Chunk,    [Wide; 4], "kg, N s", "m_p, m_p v_p: what S_Ip distributes";
    StressFlow:       Chunk,    [Wide; 7], "J, m^3",  "-V0 tau, V: what grad S_Ip (and S_Ip) distribute";
    ContactFlow:      Chunk,    [Wide; 4], "m^3, kg m", "V_p, m_p x_p: what grad S_Ip and S_Ip distribute";
    ScatterRows:      Chunk,    NodeRows,  "mixed",   "the flows, one row a particle";
    GatherRows:       Chunk,    NodeRows,  "mixed",   "gathered sums, one row a particle";
    GridVelocity:     Chunk,    [Wide; 3], "m/s",     "sum_I S_Ip v_I";
    VelocityChange:   Chunk,    [Wide; 3], "m/s",     "sum_I S_Ip dv_I";
    VelocityGradient: Chunk,    [Wide; 9], "1/s",     "L_p = sum_I v_I grad S_Ip";
    StiffnessBound:   Chunk,    Wide,      "Pa",      "upper bound of rho0 c^2 in p";

    NodeSums:         Node,     Wide,      "mixed",   "m, m v (3), f (3), V";
    ContactSums:      Node,     Wide,      "mixed",   "0, m x (3), sum V grad S (3), 0";
    ContactImpulse:   Node,     Wide,      "N s",     "impulse of contact in this step: normal (3), 0, friction (3), 0";
    NodeMotion:       Node,     Wide,      "m/s",     "v (3), 0, change of v in this step (3), 0";

    BlockExtent:      Block Max, [Wide; 6], "cells",  "max of +-(base node) over the block, to see who leaves it";

    SignalSpeed:      Material Max, [Wide; 3], "m/s", "max over p of c + |v|, of c, of |v|";
    Step:             Material, MaterialStep, "s",    "the step of its own that a material is in";
    Fault:            Material First, Wide, "mixed",  "first inadmissible particle: kind, identity, value";
    FirstEvent:       Material First, [Wide; MAX_EVENTS], "mixed", "time, identity, place of the first of each event that the law tells";
    RigidImpulse:     Material Sum, [ExactSum; 6], "N s, N m s", "impulse and torque impulse on a rigid body";
    RigidMotion:      Material, RigidState, "mixed",  "state of a rigid body";
    MaterialEnergy:   Material Sum, [ExactSum; 5], "J", "kinetic, strain, plastic, fracture, viscous";
    MaterialMotion:   Material Sum, [ExactSum; 10], "mixed", "m, m v (3), m x (3), m x cross v (3)";
    StateCount:       Material Sum, [ExactSum; MAX_COUNTS], "1", "particles in each state that the law counts";

    Time:             Global,   Clock,     "s",       "time, tick, and what limits it";
    ContactWork:      Global Sum, [ExactSum; 2], "J", "kinetic energy lost in contact: by friction, by impact";
    TransferLoss:     Global Sum, ExactSum, "J",      "kinetic energy that nodes gain and particles do not";
    BoundaryWork:     Global Sum, [ExactSum; 4], "J, N s", "work of boundaries, drives and loads on the matter, and their impulse";
}
