//! Names of materials and bodies that a document refers to: looked up in what is written, where a part that is wrong keeps it
//! from being built.
use super::document::{Data, Node};
use super::error::{Fault, Outcome, all, suggestion};
use scene::Material;

/// Whether all materials and bodies that are named are there.
pub(super) fn check(root: &Node) -> Outcome<()> {
    let list = |key: &str| root.find(key).map_or(&[][..], Node::items);
    let materials: Vec<&str> =
        root.find("material").map_or(&[][..], Node::entries).iter().map(|e| &*e.key).collect();
    let bodies: Vec<&str> =
        list("body").iter().filter_map(|body| text(body, "name")).map(Node::word).collect();
    let made_of =
        ["body", "drive", "force", "probe"].into_iter().flat_map(list).filter_map(|it| text(it, "material"));
    let met =
        list("contact").iter().filter_map(|it| it.find("between")).flat_map(Node::items).filter(is_text);
    let wound = root.find("output").and_then(|output| output.find("wound"));
    let shot = ["target", "projectile"].into_iter().filter_map(|key| text(wound?, key));
    let named =
        made_of.chain(met).chain(shot).map(|given| material(given, materials.iter().copied()).map(drop));
    let held = ["drive", "force", "probe"].into_iter().flat_map(list).filter_map(|it| text(it, "body"));
    let held = held.map(|given| body(given, bodies.iter().copied()).map(drop));
    // where there are none at all, that is the fault
    let named = named.filter(|_| !materials.is_empty()).chain(held.filter(|_| !bodies.is_empty()));
    all(named).map(drop)
}

fn is_text(node: &&Node) -> bool {
    matches!(node.data, Data::Text(_))
}

fn text<'a>(node: &'a Node, key: &str) -> Option<&'a Node> {
    node.find(key).filter(is_text)
}

/// The index of a material of the scene.
pub(super) fn material_index(given: &Node, materials: &[Material]) -> Outcome<usize> {
    material(given, materials.iter().map(|material| material.name.as_str()))
}

/// The number of a material among all.
pub(super) fn material<'a>(given: &Node, all: impl Iterator<Item = &'a str> + Clone) -> Outcome<usize> {
    position(given, "material", all)
}

/// The number of a body among all.
pub(super) fn body<'a>(given: &Node, all: impl Iterator<Item = &'a str> + Clone) -> Outcome<usize> {
    position(given, "body", all)
}

fn position<'a>(given: &Node, what: &str, all: impl Iterator<Item = &'a str> + Clone) -> Outcome<usize> {
    let name = given.word();
    all.clone().position(|it| it == name).ok_or_else(|| {
        Fault::new(given.place, format!("there is no {what} {name:?}")).help(suggestion(name, all))
    })
}
