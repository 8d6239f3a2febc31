//! Contacts, drives and forces of a completed document: who meets whom, what moves as prescribed, and what is pushed.
use super::choose;
use super::document::{Node, dotted};
use super::error::{Fault, Outcome, all};
use super::moved::SIDES;
use super::references;
use super::references::material_index;
use super::shapes::solid;
use physics::contact::{self, ContactLaw};
use physics::table::Table;
use scene::*;

pub(super) fn contacts(given: &Node, materials: &[Material]) -> Outcome<Vec<Contact>> {
    let each = |(i, node): (usize, &Node)| contact(node, materials, &dotted("contact", &i.to_string()));
    let found = all(given.items().iter().enumerate().map(each))?;
    let mut contacts: Vec<Contact> = Vec::new();
    for (contact, node) in found.into_iter().zip(given.items()) {
        if contacts.iter().any(|other| other.between == contact.between) {
            let [a, b] = contact.between.map(|index| &materials[index].name);
            let message = format!("the contact between {a:?} and {b:?} is described twice");
            return Err(Fault::new(node.get("between").place, message).help("remove one of the two"));
        }
        breakable(&contact, &contacts, node, materials)?;
        contacts.push(contact);
    }
    Ok(contacts)
}

/// A bond with a strength is one between matter, and the only one of its materials: particles know of one bond.
fn breakable(contact: &Contact, others: &[Contact], node: &Node, materials: &[Material]) -> Outcome<()> {
    let parts = |c: &Contact| c.law.bond().is_some_and(|strength| strength.is_finite());
    if !parts(contact) {
        return Ok(());
    }
    if let Some(&rigid) = contact.between.iter().find(|&&m| materials[m].is_rigid()) {
        let message = format!(
            "the bond with the rigid material {:?} has a strength, which is not modelled",
            materials[rigid].name
        );
        return Err(
            Fault::new(node.place, message).help("leave out the strength, or make the material deformable")
        );
    }
    let shares = |other: &&Contact| parts(other) && other.between.iter().any(|m| contact.between.contains(m));
    if let Some(other) = others.iter().find(shares) {
        let shared = other.between.iter().find(|m| contact.between.contains(m)).copied().unwrap_or(0);
        let message = format!("material {:?} has two bonds with a strength", materials[shared].name);
        return Err(
            Fault::new(node.place, message).help("a material may have one: split it into two materials")
        );
    }
    Ok(())
}

fn contact(given: &Node, materials: &[Material], path: &str) -> Outcome<Contact> {
    let between = given.get("between");
    let mut pair = [0; 2];
    for (index, name) in pair.iter_mut().zip(between.items()) {
        *index = material_index(name, materials)?;
    }
    if pair[0] == pair[1] {
        let name = &materials[pair[0]].name;
        let message = format!("material {name:?} cannot be in contact with itself");
        let help = "bodies of one material share a velocity field: make a second material of the same law";
        return Err(Fault::new(between.place, message).help(help));
    }
    if pair.iter().all(|&m| materials[m].is_rigid()) {
        let [a, b] = pair.map(|m| &materials[m].name);
        let message = format!("materials {a:?} and {b:?} are both rigid: their contact is not modelled");
        let help = "make one of them deformable, or leave the contact out: the run ends if they ever meet";
        return Err(Fault::new(between.place, message).help(help));
    }
    pair.sort_unstable();
    let law = choose::tagged(contact::LAWS, "law", given, path)?;
    let rigid = pair.iter().find(|&&m| materials[m].is_rigid());
    if let Some(&rigid) = rigid.filter(|_| law.asks_traction()) {
        let message = format!(
            "{:?} is rigid: it has no traction that `criterion` could ask for",
            materials[rigid].name
        );
        let place = given.find("criterion").unwrap_or(given).place;
        return Err(Fault::new(place, message).help("set `criterion = \"approach\"`"));
    }
    let gap = given.get("gap");
    if gap.number() > 0.0 && law.bond().is_some_and(|strength| !strength.is_finite()) {
        let message = "a bond without a strength holds whatever the gap";
        return Err(Fault::new(gap.place, message).help("leave out `gap`, or give the bond a strength"));
    }
    Ok(Contact { between: pair, law, gap: gap.number() })
}

pub(super) fn drives(given: &Node, materials: &[Material], bodies: &Node) -> Outcome<Vec<Drive>> {
    let each = |(number, node): (usize, &Node)| drive(node, number, materials, bodies);
    let found = all(given.items().iter().enumerate().map(each))?;
    unique(found, given, "drive", |drive| &drive.name)
}

fn drive(given: &Node, number: usize, materials: &[Material], bodies: &Node) -> Outcome<Drive> {
    let material = material_index(given.get("material"), materials)?;
    if materials[material].is_rigid() {
        let name = &materials[material].name;
        let message = format!("material {name:?} is rigid: a drive cannot move a part of it");
        return Err(Fault::new(given.get("material").place, message)
            .help(format!("set `material.{name}.motion = \"prescribed\"` with its velocity")));
    }
    let components = given.get("components").word();
    Ok(Drive {
        name: name(given, number),
        material,
        region: region(given, material, materials, bodies)?,
        motion: motion(given)?,
        components: ["x", "y", "z"].map(|axis| components.contains(axis)),
        until: given.find("until").map_or(f64::INFINITY, Node::number),
    })
}

/// What a table of a list calls itself; else its number.
pub(super) fn name(given: &Node, number: usize) -> String {
    given.find("name").map_or_else(|| number.to_string(), |name| name.word().to_owned())
}

/// What a list has made, if no two have the same name.
pub(super) fn unique<T>(
    made: Vec<T>,
    given: &Node,
    what: &str,
    name: impl Fn(&T) -> &String,
) -> Outcome<Vec<T>> {
    for (i, (it, node)) in made.iter().zip(given.items()).enumerate() {
        if made[..i].iter().any(|other| name(other) == name(it)) {
            let place = node.find("name").unwrap_or(node).place;
            return Err(Fault::new(place, format!("there are two {what}s named {:?}", name(it)))
                .help(format!("give each {what} a name of its own")));
        }
    }
    Ok(made)
}

/// The part of a material that a table means by `region` or `body`.
pub(super) fn region(
    given: &Node,
    material: usize,
    materials: &[Material],
    bodies: &Node,
) -> Outcome<Region> {
    match (given.find("region"), given.find("body")) {
        (None, None) => Ok(Region::All),
        (Some(shape), None) => solid(shape).map(Region::Solid),
        (Some(_), Some(body)) => Err(Fault::new(body.place, "both `region` and `body` are given")
            .help("keep one: the region of a body is what lies in both, an `intersection` of shapes")),
        (None, Some(body)) => {
            let name = body.word();
            let index = references::body(body, bodies.items().iter().map(|node| node.get("name").word()))?;
            let made_of = bodies.items()[index].get("material").word();
            if made_of != materials[material].name {
                let message =
                    format!("body {name:?} is made of {made_of:?}, not of {:?}", materials[material].name);
                return Err(Fault::new(body.place, message).help("change `material` or `body`"));
            }
            Ok(Region::Body(index))
        }
    }
}

/// A rigid motion, by `velocity` or `displacement`, `angular-velocity` and `center`.
pub(super) fn motion(given: &Node) -> Outcome<Motion> {
    let course = match (given.find("velocity"), given.find("displacement")) {
        (None, None) => Course::rest(),
        (Some(velocity), None) => Course::Velocity(choose::in_time(velocity)),
        (None, Some(displacement)) => Course::Displacement(from_rest(displacement)?),
        (Some(_), Some(displacement)) => {
            return Err(Fault::new(displacement.place, "both `velocity` and `displacement` are given")
                .help("keep one: each says where the center is"));
        }
    };
    let spin = choose::in_time(given.get("angular-velocity"));
    let center = given.find("center").map_or([0.0; 3], Node::vector);
    Ok(Motion { course, spin, center })
}

/// A table of displacements, which says nothing of where things are at the start.
fn from_rest(displacement: &Node) -> Outcome<Table> {
    let table = choose::in_time(displacement);
    if table.at(0.0) != [0.0; 3] {
        let message = "a displacement is from where things are at the start, and is zero there";
        return Err(Fault::new(displacement.place, message)
            .help("begin the table with [0, 0, 0, 0], or move the shape at the start"));
    }
    Ok(table)
}

pub(super) fn forces(given: &Node, materials: &[Material], bodies: &Node) -> Outcome<Vec<Force>> {
    let each = |(number, node): (usize, &Node)| force(node, number, materials, bodies);
    let found = all(given.items().iter().enumerate().map(each))?;
    unique(found, given, "force", |force| &force.name)
}

fn force(given: &Node, number: usize, materials: &[Material], bodies: &Node) -> Outcome<Force> {
    let material = material_index(given.get("material"), materials)?;
    if materials[material].is_rigid() {
        let message =
            format!("material {:?} is rigid: forces act on deformable matter", materials[material].name);
        return Err(Fault::new(given.get("material").place, message)
            .help("a free rigid body has a force of its own: `material.NAME.force`"));
    }
    let kind = match ["total", "traction", "pressure"].map(|key| given.find(key)) {
        [Some(total), None, None] => ForceKind::Total(choose::in_time(total)),
        [None, Some(traction), None] => ForceKind::Traction(choose::in_time(traction)),
        [None, None, Some(pressure)] if given.get("follows").flag() => {
            ForceKind::Pressure(choose::number_in_time(pressure))
        }
        [None, None, Some(pressure)] => ForceKind::DeadPressure(choose::number_in_time(pressure)),
        _ => {
            let message = "a force has one of `total`, `traction` and `pressure`";
            return Err(Fault::new(given.place, message).help("give just one of them"));
        }
    };
    let meaningless = |key: &str, what: &str| {
        let message = format!("`{key}` has no meaning for {what}");
        Err(Fault::new(given.get(key).place, message).help("leave it out"))
    };
    match &kind {
        ForceKind::Total(_) if given.get("side").word() != SIDES[0] => {
            return meaningless("side", "a total, which acts on all particles of its region");
        }
        ForceKind::Total(_) | ForceKind::Traction(_) if !given.get("follows").flag() => {
            return meaningless("follows", "a force that keeps its direction in any case");
        }
        _ => {}
    }
    let side = SIDES.iter().position(|side| *side == given.get("side").word()).unwrap_or(0);
    Ok(Force {
        name: name(given, number),
        material,
        region: region(given, material, materials, bodies)?,
        kind,
        sides: std::array::from_fn(|face| side == 0 || side == face + 1),
    })
}
