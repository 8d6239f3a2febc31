//! Every field of a scene. Checks, defaults and `docs/SCENE.md` come from here.
use super::form::{
    Absent, Case, Counts, Field, Form, Options, Range, any, count_from, not_negative, positive,
};
use super::moved::{DRIVE, FORCE, RIGID, RIGID_FIELDS};
use super::probes::PROBE;
use super::shapes::SHAPE;
use physics::parameter::Dimension::{
    Acceleration, Angle, AngularVelocity, Density, Length, One, Rate, Time, Velocity,
};
use physics::{contact, faces, materials};

const ZERO: Absent = Absent::Vector([0.0; 3]);
const POINT: Form = Form::Vector(Length, 3);
const DIRECTION: Form = Form::Vector(One, 3);
const PATCHES: Form = Form::Patches(Counts { least: 1, most: 1 << 20 });

/// The whole scene.
pub(super) static SCENE: &[Field] = &[
    Field::with_default("title", Form::Text, Absent::Word(""), "One line for people."),
    Field::required("domain", Form::Table(DOMAIN), "Where: a box of cubic cells."),
    Field::required(
        "material",
        Form::Named(&MATERIAL),
        "What things are made of. Each material has a name of its \
        choice and a velocity field of its own. There are at most 65536.",
    ),
    Field::required("body", Form::List(&Form::Table(BODY)), "Pieces of matter, filled with particles."),
    Field::with_default(
        "contact",
        Form::List(&CONTACT),
        Absent::Empty,
        "Which materials touch, and how. Materials \
        of pairs that are not listed pass through each other, but for free rigid bodies, which may not meet anything rigid.",
    ),
    Field::with_default(
        "boundary",
        Form::Table(BOUNDARY),
        Absent::Empty,
        "What holds on the faces of the domain.",
    ),
    Field::with_default(
        "drive",
        Form::List(&Form::Table(DRIVE)),
        Absent::Empty,
        "Regions of matter whose motion is prescribed: grips. The nodes that they touch move with them.",
    ),
    Field::with_default("load", Form::Table(LOAD), Absent::Empty, "What acts on all matter."),
    Field::with_default(
        "force",
        Form::List(&Form::Table(FORCE)),
        Absent::Empty,
        "Forces on parts of bodies, tractions and pressures on their surfaces.",
    ),
    Field::with_default(
        "probe",
        Form::List(&Form::Table(PROBE)),
        Absent::Empty,
        "What is followed in time, of a particle or over a region: columns `probe.NAME.FIELD` of `history.csv`.",
    ),
    Field::required("run", Form::Table(RUN), "Numerics."),
    Field::with_default("output", Form::Table(OUTPUT), Absent::Empty, "What to write."),
];

static DOMAIN: &[Field] = &[
    Field::required("lower", POINT, "Lower corner."),
    Field::required("upper", POINT, "Upper corner: a whole number of cells above the lower one."),
    Field::required("cell", positive(Length), "Edge of a cell."),
];

static MATERIAL: Form = Form::Tagged {
    tag: "law",
    common: &[
        Field::required("law", Form::Text, "How it deforms: a constitutive law, or \"rigid\"."),
        Field::required("density", positive(Density), "Density of the undeformed material."),
    ],
    cases: laws,
};

fn laws() -> Vec<Case> {
    let rigid = Case {
        word: RIGID,
        summary: "Does not deform. All bodies of the material form one rigid body.",
        fields: RIGID_FIELDS.to_vec(),
    };
    materials::LAWS.iter().map(Case::from).chain([rigid]).collect()
}

static BODY: &[Field] = &[
    Field::required("name", Form::Text, "Name in messages; no two bodies share one."),
    Field::required("material", Form::Material, "What it is made of."),
    Field::required(
        "shape",
        Form::Other(&SHAPE),
        "Its shape. Bodies may not overlap nor leave the domain, but tools may.",
    ),
    Field::with_default(
        "particles-per-cell",
        Form::Counts(Counts { least: 1, most: 8 }),
        Absent::Three(2),
        "Particles along each axis of a cell.",
    ),
    Field::with_default("velocity", Form::Vector(Velocity, 3), ZERO, "Velocity at the start."),
    Field::with_default(
        "angular-velocity",
        Form::Vector(AngularVelocity, 3),
        ZERO,
        "Angular velocity about the center of mass at the start (deformable bodies).",
    ),
    Field::with_default(
        "stretch",
        Form::Vector(One, 3),
        Absent::Vector([1.0; 3]),
        "How far it is stretched along x, y and z at the start; its shape is what it fills then (deformable bodies).",
    ),
    Field::with_default(
        "fibers",
        FIBERS,
        Absent::Case("uniform", [1.0, 0.0, 0.0]),
        "Direction of the fibers at the \
        start, for laws that have fibers.",
    ),
];

const FIBERS: Form = Form::One(&[
    Field::optional("uniform", DIRECTION, "The same direction everywhere."),
    Field::optional(
        "turning",
        Form::Table(&[
            Field::required("start", DIRECTION, "Direction at the plane `from`, perpendicular to `axis`."),
            Field::required("axis", DIRECTION, "Normal of the planes, about which the fibers turn."),
            Field::required("from", any(Length), "Where the turn starts: the plane where axis · x is this."),
            Field::required("to", any(Length), "Where the turn ends."),
            Field::required(
                "angle",
                any(Angle),
                "Angle between the two planes, right-handed about the axis, linear in \
                between and beyond.",
            ),
        ]),
        "A direction that turns through the thickness.",
    ),
]);

static CONTACT: Form = Form::Tagged {
    tag: "law",
    common: &[
        Field::required("between", Form::Pair, "The two materials."),
        Field::required("law", Form::Text, "How they touch."),
        Field::with_default(
            "gap",
            not_negative(One),
            Absent::Number(0.0),
            "Contact acts only while the gap between \
            the surfaces is below this many cells.",
        ),
    ],
    cases: contact_laws,
};

fn contact_laws() -> Vec<Case> {
    contact::LAWS.iter().map(Case::from).collect()
}

/// Keys of the faces in the order of `Scene::faces`.
pub(super) const FACES: [&str; 6] = ["x-min", "x-max", "y-min", "y-max", "z-min", "z-max"];

static BOUNDARY: &[Field] = &[
    face(FACES[0], "Lower x face."),
    face(FACES[1], "Upper x face."),
    face(FACES[2], "Lower y face."),
    face(FACES[3], "Upper y face."),
    face(FACES[4], "Lower z face."),
    face(FACES[5], "Upper z face."),
];

/// A condition on a face.
pub(super) static FACE: Form = Form::Either(|| Options::of(faces::CONDITIONS));

const fn face(key: &'static str, meaning: &'static str) -> Field {
    Field::with_default(key, Form::Other(&FACE), Absent::Word(faces::CONDITIONS[0].name), meaning)
}

static LOAD: &[Field] = &[
    Field::with_default("gravity", Form::InTime(Acceleration), ZERO, "Acceleration of all matter in time."),
    Field::with_default(
        "damping",
        not_negative(Rate),
        Absent::Number(0.0),
        "Mass-proportional damping, a = −damping · v, by its exponential, however strong. Impulses of tools, drives, moving \
        faces and contact are told as they act on the damped motion: (1 − e^(−damping Δt))/(damping Δt) of the force in a step, the rest by \
        `loads`.",
    ),
    Field::with_default(
        "local-damping",
        Form::Number(Range { dimension: One, least: 0.0, open_below: false, most: 0.95 }),
        Absent::Number(0.0),
        "Local damping of Cundall, for slow loading: at each node this share of the force out of balance acts against the \
        velocity, axis by axis, after all else has acted on it. It does not act on free rigid bodies, and its torque is no one's.",
    ),
];

static RUN: &[Field] = &[
    Field::required("until", positive(Time), "End of the simulated time."),
    Field::optional("steps", count_from(1), "Most steps to take; absent: as many as it needs."),
    Field::with_default(
        "cfl",
        fraction(true),
        Absent::Number(0.4),
        "CFL number: the part of a cell that the fastest \
        wave may cross in a step.",
    ),
    Field::with_default(
        "rates",
        Form::Choice(&["common", "per-material"]),
        Absent::Word("common"),
        "\"common\": all materials take the time step that the fastest one needs; \"per-material\": each takes steps \
        of its own, and slow materials wait for fast ones.",
    ),
    Field::with_default(
        "most-substeps",
        Form::Count(Counts { least: 1, most: 1 << 20 }),
        Absent::Count(256),
        "The most steps of the fastest material in one of the slowest (per-material rates; 1 gives the common step).",
    ),
    Field::with_default(
        "smallest-step",
        positive(Time),
        Absent::Number(1e-15),
        "A smaller step ends the run with an \
        error.",
    ),
    Field::with_default(
        "shape",
        Form::Choice(&["gimp", "linear"]),
        Absent::Word("gimp"),
        "Shape functions: uniform GIMP, or trilinear hats. With hats a particle that barely touches a node can be torn by it: \
        they are for small motions and comparisons.",
    ),
    Field::with_default(
        "pic",
        fraction(false),
        Absent::Number(0.0),
        "Share of PIC in the velocity update of a step; 0 is FLIP. It damps more the smaller steps are: see `pic-rate`.",
    ),
    Field::with_default(
        "pic-rate",
        not_negative(Rate),
        Absent::Number(0.0),
        "Rate of PIC: velocities that particles do not share with the nodes around decay like this, whatever the step is.",
    ),
    Field::optional("viscosity", Form::Table(VISCOSITY), "Artificial viscosity; absent: none."),
    Field::with_default(
        "leaving",
        Form::Choice(&["error", "delete", "reflect"]),
        Absent::Word("error"),
        "A particle that leaves the domain stops the run, is taken out, or is put back with its velocity mirrored at the face; \
        the latter two are counted.",
    ),
    Field::with_default(
        "rebalance-every",
        count_from(0),
        Absent::Count(100),
        "Every so many steps patches move to other ranks, if their measured costs say that it pays; 0: never. It changes \
        no bit of the result.",
    ),
    Field::optional(
        "patches",
        PATCHES,
        "Patches: about so many in all, cut where the particles are, or so many along each axis; absent: eight for each thread, \
        unless bodies have few blocks of 4x4x4 cells.",
    ),
    Field::optional(
        "threads",
        Form::Threads,
        "Threads, of each rank if there are several; absent: all cores. More threads than cores take turns.",
    ),
];

const fn fraction(open_below: bool) -> Form {
    Form::Number(Range { dimension: One, least: 0.0, open_below, most: 1.0 })
}

static VISCOSITY: &[Field] = &[
    Field::with_default(
        "linear",
        not_negative(One),
        Absent::Number(0.2),
        "c₁ in q = ρ l (c₁ c |tr D| + c₂ l (tr D)²), \
        in compression only.",
    ),
    Field::with_default("quadratic", not_negative(One), Absent::Number(2.0), "c₂."),
];

static OUTPUT: &[Field] = &[
    Field::with_default(
        "frames",
        count_from(0),
        Absent::Count(20),
        "Frames of `particles.vtkhdf` over the whole run, \
        besides the first; 0: none at all.",
    ),
    Field::optional(
        "fields",
        Form::List(&Form::Text),
        "What a frame shows of each particle, of the names in [FIELDS.md](FIELDS.md); absent: those that are marked there, as far \
        as a material has them. It stays as it is over a restart.",
    ),
    Field::with_default(
        "history-every",
        count_from(1),
        Absent::Count(10),
        "A row of `history.csv` every so many steps.",
    ),
    Field::with_default(
        "period",
        Form::List(&Form::Table(PERIOD)),
        Absent::Empty,
        "Parts of the simulated time in which there is more to see, or less.",
    ),
    Field::with_default(
        "checkpoint",
        Form::Table(CHECKPOINT),
        Absent::Empty,
        "When to write a checkpoint, from which `sinew run --restart` goes on.",
    ),
    Field::optional("wound", Form::Table(WOUND), "For `sinew wound`, if the scene is a shot through a slab."),
];

static PERIOD: &[Field] = &[
    Field::with_default("from", not_negative(Time), Absent::Number(0.0), "From when on."),
    Field::optional("to", positive(Time), "Until when; absent: until the end of the run."),
    Field::optional(
        "frames-every",
        positive(Time),
        "Simulated time between frames, from `from` on, besides the frames of the whole run.",
    ),
    Field::optional(
        "history-every",
        count_from(1),
        "A row of `history.csv` every so many steps, instead of `output.history-every`; where periods overlap, the last of them says.",
    ),
];

static CHECKPOINT: &[Field] = &[
    Field::optional("steps", count_from(1), "Every so many steps."),
    Field::optional("time", positive(Time), "Every so much simulated time."),
    Field::with_default(
        "wall",
        not_negative(Time),
        Absent::Number(600.0),
        "Every so much time on the clock of the machine; 0: never.",
    ),
    Field::with_default(
        "final",
        Form::Flag,
        Absent::Flag(true),
        "At the end of the run, too, so that `--restart` with a later `--until` goes on from there.",
    ),
    Field::with_default(
        "kept",
        count_from(1),
        Absent::Count(2),
        "How many to keep: older ones are deleted when a new one is whole.",
    ),
];

/// Words of `output.wound.axis`: up and down x, y and z.
pub(super) const SHOTS: &[&str] = &["+x", "-x", "+y", "-y", "+z", "-z"];

static WOUND: &[Field] = &[
    Field::required("target", Form::Material, "Material of the slab."),
    Field::required("projectile", Form::Material, "Material of the projectile."),
    Field::required("axis", Form::Choice(SHOTS), "Direction of the shot."),
    Field::required("entry", any(Length), "Where on that axis the slab's surface of entry is."),
    Field::required("exit", any(Length), "Where the slab's surface of exit is."),
    Field::required(
        "center",
        Form::Vector(Length, 2),
        "Point of entry in the two other axes, in ascending order.",
    ),
];
