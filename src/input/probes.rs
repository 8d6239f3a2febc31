//! `[[probe]]`: what is followed in time.
use super::document::Node;
use super::error::{Fault, Outcome, all};
use super::form::{Field, Form, positive};
use super::meetings::{name, region, unique};
use super::references::material_index;
use super::shapes::SHAPE;
use super::shown::one;
use physics::parameter::Dimension;
use physics::quantities::POSITION;
use scene::shown::{Probe, ProbeOf, available};
use scene::{Domain, Material};

const POINT: Form = Form::Vector(Dimension::Length, 3);

pub(super) static PROBE: &[Field] = &[
    Field::optional("name", Form::Text, "Its name in `history.csv`; absent: its number, from 0."),
    Field::required("material", Form::Material, "The material whose particles are followed."),
    Field::required("field", Form::Text, "What of them: `position`, or a name of [FIELDS.md](FIELDS.md)."),
    Field::optional(
        "at",
        POINT,
        "Of the particle that is nearest to this point at the start, instead of a region.",
    ),
    Field::optional(
        "region",
        Form::Other(&SHAPE),
        "Of particles that lie in this shape at the start; absent: of all of the body or of the material.",
    ),
    Field::optional("body", Form::Text, "Of the particles of a body, instead of a region."),
    Field::optional(
        "value",
        Form::Choice(VALUES),
        "Over a region: the mean, weighted by mass, the largest or the smallest, each component by itself; absent: the mean. What is \
        not a number does not count.",
    ),
    Field::optional(
        "interval",
        positive(Dimension::Time),
        "Simulated time between rows of `history.csv` with this probe alone, besides the rows of all columns (`output.history-every`). \
        A row is written after the first step that ends then or later.",
    ),
];

const VALUES: &[&str] = &["mean", "largest", "smallest"];

/// All probes of a scene.
pub(super) fn probes(
    given: &Node,
    materials: &[Material],
    bodies: &Node,
    domain: &Domain,
) -> Outcome<Vec<Probe>> {
    let each = |(number, node): (usize, &Node)| probe(node, number, materials, (bodies, domain));
    let found = all(given.items().iter().enumerate().map(each))?;
    unique(found, given, "probe", |probe| &probe.name)
}

fn probe(
    given: &Node,
    number: usize,
    materials: &[Material],
    (bodies, domain): (&Node, &Domain),
) -> Outcome<Probe> {
    let material = material_index(given.get("material"), materials)?;
    let it = &materials[material];
    if !it.has_particles() {
        let message =
            format!("material {:?} is a tool without particles: there is nothing to follow", it.name);
        return Err(Fault::new(given.get("material").place, message)
            .help("history.csv has its force, torque, work and motion in any case"));
    }
    let mut all = available([it]);
    all.push(POSITION.shown);
    let shown = one(given.get("field"), &all, &format!("no particle of {:?}", it.name))?;
    let region = region(given, material, materials, bodies)?;
    let value = given.find("value");
    let of = match (given.find("at"), value.map_or(VALUES[0], Node::word)) {
        (Some(at), _) => {
            if let Some(other) = ["region", "body"].into_iter().find_map(|key| given.find(key)) {
                let message = "a probe `at` a point has no region";
                return Err(Fault::new(other.place, message).help("keep one of them"));
            }
            if let Some(value) = value {
                let message = "`value` has no meaning for one particle";
                return Err(Fault::new(value.place, message).help("leave it out"));
            }
            let point: [f64; 3] = at.vector();
            let end = |a: usize| domain.lower[a] + (domain.cells[a] as f64 + 1.0) * domain.cell;
            if (0..3).any(|a| !(domain.lower[a] - domain.cell..=end(a)).contains(&point[a])) {
                let message = format!("the point {point:?} m lies outside of the domain");
                return Err(
                    Fault::new(at.place, message).help("is a unit missing? A bare number is in meters")
                );
            }
            ProbeOf::Nearest(point)
        }
        (None, "largest") => ProbeOf::Largest(region),
        (None, "smallest") => ProbeOf::Smallest(region),
        (None, _) => ProbeOf::Mean(region),
    };
    let interval = given.find("interval").map(Node::number);
    Ok(Probe { name: name(given, number), material, shown, of, interval })
}
