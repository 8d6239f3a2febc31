//! What a scene chooses from a registry, with its parameters.
use super::document::{Node, dotted};
use super::error::{Fault, Outcome};
use super::form::sole;
use physics::parameter::{Entry, Kind, Parameter, Values};
use physics::table::Table;

/// The entry of a name.
pub(super) fn entry<'a, T>(entries: &'a [Entry<T>], name: &str) -> Option<&'a Entry<T>> {
    entries.iter().find(|entry| entry.name == name)
}

/// What an entry makes of a completed table that has its parameters.
pub(super) fn build<T>(entry: &Entry<T>, given: &Node, path: &str) -> Outcome<T> {
    let mut values = Values::default();
    for parameter in entry.parameters {
        match (given.find(parameter.key), parameter.kind) {
            (None, Kind::Number { default: Some(number), .. }) => {
                values.numbers.insert(parameter.key, number);
            }
            _ => take(&mut values, parameter, given.get(parameter.key)),
        }
    }
    finish(entry, &values, given, path)
}

/// What a completed table chooses by the word of `tag`.
pub(super) fn tagged<T>(entries: &[Entry<T>], tag: &str, given: &Node, path: &str) -> Outcome<T> {
    let word = given.get(tag);
    build(known(entries, word.word(), word)?, given, path)
}

/// What a completed word chooses, or a table with one key.
pub(super) fn either<T>(entries: &[Entry<T>], given: &Node, path: &str) -> Outcome<T> {
    let (name, value) = given.case().unwrap_or((given.word(), given));
    let entry = known(entries, name, given)?;
    let Some(parameter) = sole(entry) else { return build(entry, value, &dotted(path, name)) };
    let mut values = Values::default();
    take(&mut values, parameter, value);
    finish(entry, &values, given, path)
}

/// A vector in time, from a vector or from rows.
pub(super) fn in_time(given: &Node) -> Table {
    let row = |row: &Node| {
        let [t, x, y, z] = row.vector();
        (t, [x, y, z])
    };
    match given.items().first() {
        Some(first) if !first.items().is_empty() => Table(given.items().iter().map(row).collect()),
        _ => Table(vec![(0.0, given.vector())]),
    }
}

/// A number in time as a vector along x.
pub(super) fn number_in_time(given: &Node) -> Table {
    let row = |row: &Node| {
        let [t, x] = row.vector();
        (t, [x, 0.0, 0.0])
    };
    match given.items() {
        [] => Table(vec![(0.0, [given.number(), 0.0, 0.0])]),
        rows => Table(rows.iter().map(row).collect()),
    }
}

fn known<'a, T>(entries: &'a [Entry<T>], name: &str, given: &Node) -> Outcome<&'a Entry<T>> {
    // the description of the field has the same entries
    entry(entries, name).ok_or_else(|| Fault::new(given.place, format!("there is no {name:?}")))
}

fn take(values: &mut Values, parameter: &Parameter, given: &Node) {
    let key = parameter.key;
    match parameter.kind {
        Kind::Number { .. } => drop(values.numbers.insert(key, given.number())),
        Kind::Choice(_) => drop(values.choices.insert(key, given.word().to_owned())),
        Kind::Flag(_) => drop(values.flags.insert(key, given.flag())),
        Kind::Motion { .. } => drop(values.motions.insert(key, in_time(given))),
    }
}

fn finish<T>(entry: &Entry<T>, values: &Values, given: &Node, path: &str) -> Outcome<T> {
    (entry.build)(values).map_err(|(key, message)| {
        let place = given.find(key).unwrap_or(given).place;
        Fault::new(place, format!("`{}`: {message}", dotted(path, key)))
    })
}

#[cfg(test)]
mod tests {
    use super::super::check::complete;
    use super::super::document::parse;
    use super::super::form::{Form, Options};
    use super::super::source::Source;
    use super::*;
    use physics::parameter::{Described, Dimension, Refusal};

    /// Conditions of a made-up registry: one without parameters, one whose parameter says all, one with two.
    struct Off;
    struct Rate;
    struct Wall;

    impl Described for Off {
        const NAME: &'static str = "off";
        const SUMMARY: &'static str = "Nothing.";
        const PARAMETERS: &'static [Parameter] = &[];
        type Built = &'static str;
        fn build(_: &Values) -> Result<Self::Built, Refusal> {
            Ok("off")
        }
    }
    impl Described for Rate {
        const NAME: &'static str = "rate";
        const SUMMARY: &'static str = "Something.";
        const PARAMETERS: &'static [Parameter] = &[Parameter::positive("rate", Dimension::Rate, "How fast.")];
        type Built = String;
        fn build(values: &Values) -> Result<String, Refusal> {
            Ok(format!("rate {}", values.number("rate")))
        }
    }
    impl Described for Wall {
        const NAME: &'static str = "wall";
        const SUMMARY: &'static str = "Something else.";
        const PARAMETERS: &'static [Parameter] = &[
            Parameter::positive_or("density", Dimension::Density, 3.0, "How dense."),
            Parameter::motion("velocity", "Where to."),
        ];
        type Built = String;
        fn build(values: &Values) -> Result<String, Refusal> {
            match values.number("density") {
                13.0 => Err(("density", "thirteen".into())),
                density => Ok(format!("wall {density} {:?}", values.motion("velocity").at(0.5))),
            }
        }
    }

    const ENTRIES: &[Entry<String>] = &[Entry::of::<Off>(), Entry::of::<Rate>(), Entry::of::<Wall>()];

    fn read(text: &str) -> Result<String, String> {
        let form = Form::Either(|| Options::of(ENTRIES));
        let source = Source::new("test", format!("x = {text}"));
        let read = || {
            let root = parse(&source)?;
            either(ENTRIES, &complete(root.get("x"), &form, "x")?, "x")
        };
        read().map_err(|fault| fault.in_sources(std::slice::from_ref(&source)).to_string())
    }

    #[test]
    fn a_word_a_value_or_a_table_chooses_an_entry() {
        assert_eq!(read("'off'").as_deref(), Ok("off"));
        assert_eq!(read("{ rate = '2 1/ms' }").as_deref(), Ok("rate 2000"));
        assert_eq!(read("{ wall = { velocity = [1, 2, 3] } }").as_deref(), Ok("wall 3 [1.0, 2.0, 3.0]"));
        let moving = "{ wall = { density = 2, velocity = [[0, 0, 0, 0], [1, 2, 4, 8]] } }";
        assert_eq!(read(moving).as_deref(), Ok("wall 2 [1.0, 2.0, 4.0]"));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_key() {
        let wrong = |text: &str| read(text).expect_err("it is wrong");
        assert_eq!(wrong("'of'"), "`x` cannot be \"of\"");
        assert_eq!(wrong("3"), "`x` must be a word or a table with one key, not an integer");
        assert_eq!(wrong("{ rate = 0 }"), "`x.rate` is 0, but must be above 0");
        assert_eq!(wrong("{ wall = {} }"), "`x.wall.velocity` is missing");
        assert_eq!(wrong("{ wall = 3 }"), "`x.wall` must be a table, not an integer");
        assert_eq!(wrong("{ wall = { velocity = [0, 0, 0], mass = 1 } }"), "unknown key `x.wall.mass`");
        let unlucky = "{ wall = { density = 13, velocity = [0, 0, 0] } }";
        assert_eq!(wrong(unlucky), "`x.wall.density`: thirteen");
    }
}
