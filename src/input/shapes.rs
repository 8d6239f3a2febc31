//! How scenes write solids.
use super::document::Node;
use super::error::{Fault, Outcome};
use super::form::{Absent, Field, Form, any, not_negative, positive};
use physics::parameter::Dimension::{Angle, Length, One};
use scene::geometry::{Solid, direction, rotation};

const POINT: Form = Form::Vector(Length, 3);
const DIRECTION: Form = Form::Vector(One, 3);

const UNITS: &[&str] = &["m", "cm", "mm", "um", "in"];

/// A solid: a table with one key, which says what it is.
pub(super) static SHAPE: Form = Form::One(&[
    Field::optional(
        "box",
        Form::Table(&[
            Field::required("lower", POINT, "Lower corner."),
            Field::required("upper", POINT, "Upper corner, above the lower one in every direction."),
        ]),
        "A box along the axes.",
    ),
    Field::optional(
        "sphere",
        Form::Table(&[
            Field::required("center", POINT, "Center."),
            Field::required("radius", positive(Length), "Radius."),
        ]),
        "A ball.",
    ),
    Field::optional(
        "cylinder",
        Form::Table(&[
            Field::required("start", POINT, "Center of the first end."),
            Field::required("end", POINT, "Center of the second end."),
            Field::required("radius", positive(Length), "Radius."),
        ]),
        "A cylinder with flat ends.",
    ),
    Field::optional(
        "cone",
        Form::Table(&[
            Field::required("start", POINT, "Center of the first end."),
            Field::required("end", POINT, "Center of the second end."),
            Field::required("start-radius", not_negative(Length), "Radius at the first end."),
            Field::required("end-radius", not_negative(Length), "Radius at the second end."),
        ]),
        "A cone, or a frustum of one.",
    ),
    Field::optional(
        "capsule",
        Form::Table(&[
            Field::required("start", POINT, "Center of the first round end."),
            Field::required("end", POINT, "Center of the second round end."),
            Field::required("radius", positive(Length), "Radius."),
        ]),
        "A cylinder with a half ball on each end.",
    ),
    Field::optional(
        "half-space",
        Form::Table(&[
            Field::required("point", POINT, "A point of the plane."),
            Field::required("normal", DIRECTION, "Direction out of the solid."),
        ]),
        "All points behind a plane; for bodies, only inside an intersection with something bounded.",
    ),
    Field::optional(
        "mesh",
        Form::Table(&[
            Field::required(
                "file",
                Form::Text,
                "An STL file, text or binary, beside the scene or with its whole path. \
                Its surface is closed, turns counterclockwise as seen from outside and does not cut itself; shells of one file lie apart.",
            ),
            Field::required("unit", Form::Choice(UNITS), "What its numbers count: the format has no unit."),
            Field::optional(
                "digest",
                Form::Text,
                "A hash of the file: another one is refused. Results of runs have it.",
            ),
        ]),
        "What triangles bound.",
    ),
    Field::optional("union", Form::List(&SHAPE), "What lies in any of the shapes."),
    Field::optional("intersection", Form::List(&SHAPE), "What lies in all of the shapes."),
    Field::optional(
        "difference",
        Form::List(&SHAPE),
        "What lies in the first shape and in none of the others.",
    ),
    Field::optional(
        "translate",
        Form::Table(&[
            Field::required("by", POINT, "How far."),
            Field::required("shape", Form::Other(&SHAPE), "What is moved."),
        ]),
        "A shape, moved.",
    ),
    Field::optional(
        "rotate",
        Form::Table(&[
            Field::required("axis", DIRECTION, "Axis of the turn."),
            Field::required("angle", any(Angle), "Angle, right-handed about the axis."),
            Field::with_default("about", POINT, Absent::Vector([0.0; 3]), "A point of the axis."),
            Field::required("shape", Form::Other(&SHAPE), "What is turned."),
        ]),
        "A shape, turned.",
    ),
]);

/// The solid that a completed shape describes.
pub(super) fn solid(shape: &Node) -> Outcome<Solid> {
    let Some((kind, given)) = shape.case() else {
        return Err(Fault::new(shape.place, "this shape has no key")); // the description asks for one
    };
    let point = |key: &str| given.get(key).vector::<3>();
    Ok(match kind {
        "box" => {
            let (lower, upper) = (point("lower"), point("upper"));
            if let Some(a) = (0..3).find(|&a| lower[a] >= upper[a]) {
                let message =
                    format!("this box is empty: along {}, `upper` is not above `lower`", ["x", "y", "z"][a]);
                return Err(
                    Fault::new(given.get("upper").place, message).help("swap the corners or enlarge the box")
                );
            }
            Solid::Box { lower, upper }
        }
        "sphere" => Solid::Sphere { center: point("center"), radius: given.get("radius").number() },
        "cylinder" => {
            let radius = given.get("radius").number();
            Solid::Cone { ends: ends(given)?, radii: [radius, radius] }
        }
        "cone" => {
            let radii = ["start-radius", "end-radius"].map(|key| given.get(key).number());
            if radii == [0.0, 0.0] {
                return Err(Fault::new(
                    given.get("end-radius").place,
                    "this cone is empty: both radii are 0",
                ));
            }
            Solid::Cone { ends: ends(given)?, radii }
        }
        "capsule" => Solid::Capsule { ends: ends(given)?, radius: given.get("radius").number() },
        "half-space" => Solid::HalfSpace { point: point("point"), normal: unit_vector(given.get("normal"))? },
        "mesh" => Solid::Mesh(super::meshes::read(given)?),
        "union" => Solid::Union(solids(given)?),
        "intersection" => Solid::Intersection(solids(given)?),
        "difference" => {
            let mut all = solids(given)?;
            let first = all.remove(0);
            Solid::Difference(Box::new(first), all)
        }
        "translate" => Solid::Translate { by: point("by"), solid: Box::new(solid(given.get("shape"))?) },
        _ => Solid::Rotate {
            rotation: rotation(unit_vector(given.get("axis"))?, given.get("angle").number()),
            about: point("about"),
            solid: Box::new(solid(given.get("shape"))?),
        },
    })
}

fn ends(given: &Node) -> Outcome<[[f64; 3]; 2]> {
    let ends = ["start", "end"].map(|key| given.get(key).vector::<3>());
    if ends[0] == ends[1] {
        return Err(Fault::new(given.get("end").place, "`start` and `end` are the same point"));
    }
    Ok(ends)
}

fn solids(given: &Node) -> Outcome<Vec<Solid>> {
    if given.items().is_empty() {
        return Err(Fault::new(given.place, "this list has no shapes").help("give at least one shape"));
    }
    given.items().iter().map(solid).collect()
}

/// A direction: any vector but zero.
pub(super) fn unit_vector(given: &Node) -> Outcome<[f64; 3]> {
    direction(given.vector()).ok_or_else(|| {
        Fault::new(given.place, "a direction cannot be the zero vector")
            .help("give a vector such as [0, 1, 0]; its length does not matter")
    })
}
