//! `young-modulus` and `poisson-ratio` in place of `bulk-modulus` and `shear-modulus`.
use super::check::complete;
use super::document::{Data, Entry, Node, dotted};
use super::error::{Fault, Outcome, all, both, listing};
use super::form::{Form, Range, positive};
use physics::materials::{AnyLaw, LAWS};
use physics::parameter::Dimension;

const YOUNG: &str = "young-modulus";
const POISSON: &str = "poisson-ratio";
const BULK: &str = "bulk-modulus";
const SHEAR: &str = "shear-modulus";

/// What a scene says of them.
pub(super) const WORDS: &str = "In place of `bulk-modulus` K and `shear-modulus` μ a material can have `young-modulus` E and \
    `poisson-ratio` ν: K = E / (3 (1 − 2 ν)), μ = E / (2 (1 + ν)).";

/// ν of matter that can be compressed, and is stable.
const RATIO: Form =
    Form::Number(Range { dimension: Dimension::One, least: -1.0, open_below: true, most: 0.4999999 });

/// Puts K and μ in the place of E and ν, in every material that has them. Where that cannot be, it is an error, and others are
/// looked for as if it were right.
pub(super) fn convert(root: &mut Node) -> Outcome<()> {
    let Data::Table(entries) = &mut root.data else { return Ok(()) };
    let materials = entries.iter_mut().filter(|entry| entry.key == "material");
    let each = materials.flat_map(|entry| match &mut entry.node.data {
        Data::Table(materials) => &mut materials[..],
        _ => &mut [],
    });
    let one = |material: &mut Entry| match of(&material.key, &material.node) {
        Ok(None) => Ok(()),
        Ok(Some(moduli)) => {
            put(&mut material.node, moduli);
            Ok(())
        }
        Err(fault) => {
            forgive(&mut material.node);
            Err(fault)
        }
    };
    all(each.map(one)).map(drop)
}

/// K and μ [Pa] of a material that says E and ν.
fn of(name: &str, material: &Node) -> Outcome<Option<[f64; 2]>> {
    let path = |key: &str| dotted(&dotted("material", name), key);
    let find = |key: &str| material.entries().iter().find(|entry| entry.key == key);
    let alone = |missing: &str, given: &str| {
        let message = format!("`{}` is missing: it goes with `{given}`", path(missing));
        Err(Fault::new(material.place, message).label("in this table"))
    };
    let Some(first) = find(YOUNG).or_else(|| find(POISSON)) else { return Ok(None) };
    if let Some(law) = law(material).filter(|law| !has_both(law)) {
        let message = format!("the law {:?} has no `{}`: its parameters are others", law.name, first.key);
        let keys: Vec<_> = law.parameters.iter().map(|p| p.key).collect();
        return Err(Fault::new(first.place, message).help(format!("there are: {}", listing(&keys))));
    }
    let (young, poisson) = match (find(YOUNG), find(POISSON)) {
        (Some(young), Some(poisson)) => (young, poisson),
        (None, _) => return alone(YOUNG, POISSON),
        (_, None) => return alone(POISSON, YOUNG),
    };
    if let Some(other) = find(BULK).or_else(|| find(SHEAR)) {
        let message = format!("`{}` is given beside `{YOUNG}` and `{POISSON}`", path(&other.key));
        return Err(Fault::new(other.place, message).help("two of them say all: take the others out"));
    }
    let number = |entry: &Entry, form: Form| match complete(&entry.node, &form, &path(&entry.key))?.data {
        Data::Number(number) => Ok(number),
        _ => Ok(f64::NAN),
    };
    let (e, nu) = both(number(young, positive(Dimension::Stress)), number(poisson, RATIO))?;
    let moduli = [e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))];
    match moduli.iter().all(|modulus| modulus.is_finite()) {
        true => Ok(Some(moduli)),
        false => Err(Fault::new(young.place, format!("`{}` is too large: K has no end", path(YOUNG)))),
    }
}

fn law(material: &Node) -> Option<&'static physics::parameter::Entry<AnyLaw>> {
    let word = material.find("law")?.word();
    LAWS.iter().find(|law| law.name == word)
}

fn has_both(law: &physics::parameter::Entry<AnyLaw>) -> bool {
    [BULK, SHEAR].iter().all(|key| law.parameters.iter().any(|parameter| parameter.key == *key))
}

/// K takes the place of E, and μ that of ν.
fn put(material: &mut Node, [bulk, shear]: [f64; 2]) {
    let Data::Table(entries) = &mut material.data else { return };
    for entry in entries {
        let (key, modulus) = match entry.key.as_str() {
            YOUNG => (BULK, bulk),
            POISSON => (SHEAR, shear),
            _ => continue,
        };
        (entry.key, entry.node.data) = (key.to_owned(), Data::Number(modulus));
    }
}

/// As if nothing were wrong with the moduli.
fn forgive(material: &mut Node) {
    let takes_them = law(material).is_none_or(has_both);
    let place = material.place;
    let Data::Table(entries) = &mut material.data else { return };
    entries.retain(|entry| entry.key != YOUNG && entry.key != POISSON);
    for key in [BULK, SHEAR].into_iter().filter(|_| takes_them) {
        if entries.iter().all(|entry| entry.key != key) {
            let node = Node { data: Data::Number(1.0), place, given: true };
            entries.push(Entry { key: key.to_owned(), place, node });
        }
    }
}
