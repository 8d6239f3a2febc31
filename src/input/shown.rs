//! `output.fields`: what frames show.
use super::document::Node;
use super::error::{Fault, Outcome, all, listing, suggestion};
use physics::materials::DECLARED;
use physics::quantities::{Of, QUANTITIES, Shown};
use scene::Material;
use scene::shown::{available, of_law};

/// What every frame has, whatever a scene asks for.
const ALWAYS: [&str; 3] = ["position", "id", "material"];

/// What a scene asks for, or what is usual.
pub(super) fn fields(given: Option<&Node>, materials: &[Material]) -> Outcome<Vec<Shown>> {
    let available = available(materials);
    let Some(given) = given else {
        return Ok(available.into_iter().filter(|shown| shown.usual).collect());
    };
    let items = given.items();
    let each = |(i, node): (usize, &Node)| {
        let name = node.word();
        let before = items[..i].iter().any(|other| other.word() == name);
        match one(node, &available, "no material of this scene") {
            Ok(_) if before => {
                Err(Fault::new(node.place, format!("{name:?} is there twice")).help("take one out"))
            }
            found => found,
        }
    };
    all(items.iter().enumerate().map(each))
}

/// Something that particles show, by its name; or that `nobody` has it.
pub(super) fn one(given: &Node, available: &[Shown], nobody: &str) -> Outcome<Shown> {
    let found = available.iter().find(|shown| shown.name == given.word());
    found.copied().ok_or_else(|| unknown(given, available, nobody))
}

fn unknown(node: &Node, available: &[Shown], nobody: &str) -> Fault {
    let name = node.word();
    if ALWAYS.contains(&name) && available.iter().all(|shown| shown.name != "position") {
        let message = format!("{name:?} is in every frame, and not asked for");
        return Fault::new(node.place, message).help("take it out");
    }
    let names: Vec<&str> = available.iter().map(|shown| shown.name).collect();
    let knows = |(_, law): &&(&str, _)| of_law(law).iter().any(|shown| shown.name == name);
    if let Some((word, _)) = DECLARED.iter().find(knows) {
        let message = format!("{nobody} has {name:?}: that is something of the law {word:?}");
        return Fault::new(node.place, message).help(format!("there are: {}", listing(&names)));
    }
    Fault::new(node.place, format!("{nobody} has {name:?}")).help(suggestion(name, names))
}

const INTRODUCTION: &str = "\
# Fields of particle files

A frame of `particles.vtkhdf` has the position, the `id` and the `material` of every particle, and the fields that the scene \
asks for: `output.fields = [\"velocity\", \"stress\"]`. Without `output.fields` it has those marked with *, as far as a material has \
them. This page is generated (`sinew scene-docs fields`) from the descriptions by which frames are written.

- Numbers are in SI and in single precision; what a material does not have is not a number (NaN).
- `id` is the same for a particle in all frames; particles come in any order.
- `material` counts from 0, in the order of the scene; the attribute `names` of the column has the names. It is the same in every file \
of a run.
- Every column has its `unit` and `meaning` as attributes, and `codes` where its values are codes.
- Symmetric tensors have the order of VTK: xx, yy, zz, xy, yz, xz. Other tensors go row by row.
- A particle that is squeezed to less than a tenth of its volume (J < 0.1) has collapsed: it bears nothing that a grid could tell, and \
σ = τ / J would show any number. Its Cauchy stress, pressure and von Mises stress are not a number; `count_collapsed` in `history.csv` \
and in `summary.json` says how many there are.
- `sinew wound` is made of `failure`, and pictures are colored by it; they do without the rest.

| Field | Unit | Shape | Of | Meaning |
| --- | --- | --- | --- | --- |
";

/// The page on what frames show, as Markdown.
pub fn documentation() -> String {
    let mut page = INTRODUCTION.to_owned();
    let mut row = |shown: &Shown, of: &str| {
        let codes: Vec<_> = shown.codes.iter().enumerate().map(|(i, code)| format!("{i} {code}")).collect();
        let codes = if codes.is_empty() { String::new() } else { format!(": {}", codes.join(", ")) };
        let (usual, shape) = (if shown.usual { " *" } else { "" }, shape(shown.components));
        let Shown { name, unit, meaning, .. } = shown;
        let meaning = meaning.replace('|', "\\|");
        page += &format!("| `{name}`{usual} | {unit} | {shape} | {of} | {meaning}{codes} |\n");
    };
    for quantity in QUANTITIES {
        let of = if quantity.of == Of::All { "all" } else { "what deforms" };
        row(&quantity.shown, of);
    }
    let mut told: Vec<(&str, &str)> = Vec::new();
    for (word, law) in DECLARED {
        for shown in of_law(law) {
            if !told.contains(&(word, shown.name)) {
                row(&shown, &format!("`{word}`"));
                told.push((word, shown.name));
            }
        }
    }
    page
}

fn shape(components: usize) -> &'static str {
    match components {
        1 => "number",
        3 => "vector",
        6 => "symmetric tensor",
        _ => "tensor",
    }
}
