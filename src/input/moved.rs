//! Fields of what moves as prescribed, or as one, and of what is pushed: rigid bodies, drives, forces.
use super::form::{Absent, Field, Form, positive};
use super::shapes::SHAPE;
use physics::parameter::Dimension::{AngularVelocity, Force, Length, Stress, Time, Velocity};

const ZERO: Absent = Absent::Vector([0.0; 3]);
const POINT: Form = Form::Vector(Length, 3);

/// The word of materials that do not deform.
pub(super) const RIGID: &str = "rigid";

pub(super) static RIGID_FIELDS: &[Field] = &[
    Field::required(
        "motion",
        Form::Choice(&["free", "prescribed"]),
        "\"free\": contact and gravity move it, from the `velocity` of its bodies; \"prescribed\": it is a tool, a shape that moves \
        as `velocity` or `displacement` says, whatever meets it.",
    ),
    Field::optional(
        "velocity",
        Form::InTime(Velocity),
        "Velocity of the center in time (prescribed motion only; absent: at rest).",
    ),
    Field::optional(
        "displacement",
        Form::InTime(Length),
        "Displacement of the center in time, instead of a velocity (prescribed motion only): from where it is at the start.",
    ),
    Field::with_default(
        "angular-velocity",
        Form::InTime(AngularVelocity),
        ZERO,
        "Angular velocity about the center: at the start (free), or in time (prescribed).",
    ),
    Field::with_default(
        "force",
        Form::InTime(Force),
        ZERO,
        "A force at the center in time (free motion only): of the part of the body that is in the domain.",
    ),
    Field::with_default(
        "locked",
        Form::Choice(LOCKED),
        Absent::Word("none"),
        "Axes along which a free body does not move.",
    ),
    Field::with_default(
        "locked-turns",
        Form::Choice(LOCKED),
        Absent::Word("none"),
        "Axes about which a free body does not turn.",
    ),
    Field::optional(
        "center",
        POINT,
        "The center at the start, about which it turns (prescribed motion only); absent: that of its shape.",
    ),
    Field::with_default(
        "visible",
        Form::Flag,
        Absent::Flag(false),
        "Whether particles show where a prescribed body is: matter meets its shape, and not them.",
    ),
];

pub(super) static DRIVE: &[Field] = &[
    Field::optional("name", Form::Text, "Its name in `history.csv`; absent: its number, from 0."),
    Field::required("material", Form::Material, "The material whose particles are driven."),
    Field::optional(
        "region",
        Form::Other(&SHAPE),
        "Particles that lie in this shape at the start are driven; absent: all of the body or of the material.",
    ),
    Field::optional(
        "body",
        Form::Text,
        "The name of a body whose particles are driven, instead of a region.",
    ),
    Field::optional("velocity", Form::InTime(Velocity), "Velocity of the center in time; absent: at rest."),
    Field::optional(
        "displacement",
        Form::InTime(Length),
        "Displacement of the center in time, instead of a velocity: from where it is at the start.",
    ),
    Field::with_default(
        "angular-velocity",
        Form::InTime(AngularVelocity),
        ZERO,
        "Angular velocity about the center in time. Over a step particles turn as a rigid body does.",
    ),
    Field::with_default("center", POINT, ZERO, "The center at the start: it moves along."),
    Field::with_default(
        "components",
        Form::Choice(COMPONENTS),
        Absent::Word("xyz"),
        "Along which axes the motion is prescribed: the matter is free along the others.",
    ),
    Field::optional("until", positive(Time), "When the matter is released; absent: never."),
];

/// Words of `drive.components`.
const COMPONENTS: &[&str] = &["x", "y", "z", "xy", "xz", "yz", "xyz"];

/// Words of `locked` and `locked-turns`.
const LOCKED: &[&str] = &["none", "x", "y", "z", "xy", "xz", "yz", "xyz"];

/// Words of `force.side`: all, and those of `Force::sides` in their order.
pub(super) const SIDES: &[&str] = &["all", "-x", "+x", "-y", "+y", "-z", "+z"];

pub(super) static FORCE: &[Field] = &[
    Field::optional("name", Form::Text, "Its name in `history.csv`; absent: its number, from 0."),
    Field::required("material", Form::Material, "The material on which it acts."),
    Field::optional(
        "region",
        Form::Other(&SHAPE),
        "It acts on particles that lie in this shape at the start; absent: all of the body or of the material.",
    ),
    Field::optional("body", Form::Text, "The name of a body on which it acts, instead of a region."),
    Field::optional(
        "total",
        Form::InTime(Force),
        "A force in time, spread over all particles of the region.",
    ),
    Field::optional(
        "traction",
        Form::InTime(Stress),
        "A force in time for each area of the surface at the start; it keeps its direction.",
    ),
    Field::optional("pressure", Form::NumberInTime(Stress), "A pressure on the surface in time."),
    Field::with_default(
        "follows",
        Form::Flag,
        Absent::Flag(true),
        "Whether a pressure follows the surface as it turns and stretches; or stays as at the start.",
    ),
    Field::with_default(
        "side",
        Form::Choice(SIDES),
        Absent::Word("all"),
        "Tractions and pressures: on which faces of the particles on the surface, by their normals at the start. The surface is \
        made of faces of particles: what is oblique has steps, whose resultant is right.",
    ),
];
