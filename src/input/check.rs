//! Completes a document by its description: every value checked and turned into SI, every default filled in, nothing
//! left that is not described. What comes out is read without further questions about its form.
use super::document::{Data, Entry, Node, dotted};
use super::error::{Fault, Outcome, all, both, listing, suggestion};
use super::form::{Absent, Case, Counts, Field, Form, Range, most_threads};
use super::source::Place;
use super::units;
use physics::parameter::Dimension;
use std::collections::BTreeSet;
use std::fmt::Display;
use std::num::NonZero;

/// The document as `form` wants it.
pub(super) fn complete(node: &Node, form: &Form, path: &str) -> Outcome<Node> {
    let data = match (form, &node.data) {
        (Form::Number(range), _) => Data::Number(number(node, range, path)?),
        (Form::Count(range), Data::Integer(n)) => Data::Integer(count(*n, *range, node.place, path)?),
        (Form::Counts(range), Data::Integer(_)) => {
            let one = complete(node, &Form::Count(*range), path)?;
            Data::List(vec![one.clone(), one.clone(), one])
        }
        (Form::Patches(range), Data::Integer(n)) => Data::Integer(count(*n, *range, node.place, path)?),
        (Form::Counts(range) | Form::Patches(range), Data::List(items)) if items.len() == 3 => {
            list(items, &Form::Count(*range), path)?
        }
        (Form::Threads, Data::Integer(n)) => Data::Integer(threads(*n, node.place, path)?),
        (Form::Threads, Data::Huge(n, _)) => return Err(wrong_threads(n, cores(), node.place, path)),
        (Form::Count(range) | Form::Counts(range) | Form::Patches(range), Data::Huge(n, _)) => {
            return Err(wrong_count(n, &range.limits(), node.place, path));
        }
        (Form::Choice(words), Data::Text(text)) => Data::Text(choice(text, words, node.place, path)?),
        (Form::Flag, Data::Flag(flag)) => Data::Flag(*flag),
        (Form::Text | Form::Material, Data::Text(text)) => Data::Text(plain(text, node.place, path)?),
        (Form::Pair, Data::List(items)) if items.len() == 2 => list(items, &Form::Material, path)?,
        (Form::Vector(dimension, length), Data::List(items)) if items.len() == *length => {
            list(items, &super::form::any(*dimension), path)?
        }
        (Form::InTime(dimension), Data::List(items)) => in_time(items, (*dimension, 3), node.place, path)?,
        (Form::NumberInTime(dimension), Data::List(items)) => {
            in_time(items, (*dimension, 1), node.place, path)?
        }
        (Form::NumberInTime(dimension), _) => complete(node, &super::form::any(*dimension), path)?.data,
        (Form::Table(fields), Data::Table(entries)) => table(entries, fields, node.place, path)?,
        (Form::Parameters(parameters), Data::Table(entries)) => {
            let fields: Vec<_> = parameters.iter().map(Field::from).collect();
            table(entries, &fields, node.place, path)?
        }
        (Form::List(form), Data::List(items)) => list(items, form, path)?,
        (Form::Named(form), Data::Table(entries)) => Data::Table(all(entries.iter().map(|entry| {
            let node = complete(&entry.node, form, &dotted(path, &entry.key))?;
            Ok(Entry { node, ..entry.clone() })
        }))?),
        (Form::One(cases), Data::Table(entries)) => one(entries, cases, node.place, path)?,
        (Form::Either(options), Data::Text(text)) => {
            Data::Text(choice(text, &options().words(), node.place, path)?)
        }
        (Form::Either(options), Data::Table(entries)) => one(entries, &options().cases, node.place, path)?,
        (Form::Tagged { tag, common, cases }, Data::Table(entries)) => {
            let fields = tagged(entries, (tag, common, cases()), node.place, path)
                .map_err(|fault| fault.and(untagged(entries, (tag, common, cases()), path)))?;
            table(entries, &fields, node.place, path)?
        }
        (Form::Other(form), _) => return complete(node, form, path),
        _ => return Err(wrong_type(node, form, path)),
    };
    Ok(Node { data, ..*node })
}

/// The fields that go with the word of a table's tag.
fn tagged(
    entries: &[Entry],
    (tag, common, cases): (&str, &[Field], Vec<Case>),
    place: Place,
    path: &str,
) -> Outcome<Vec<Field>> {
    let known: Vec<_> = cases.iter().map(|case| case.word).collect();
    let given = entries.iter().find(|entry| entry.key == tag);
    let word = match given.map(|entry| &entry.node) {
        Some(Node { data: Data::Text(word), place, .. }) => choice(word, &known, *place, &dotted(path, tag))?,
        Some(other) => return Err(wrong_type(other, &Form::Text, &dotted(path, tag))),
        None => return Err(missing(tag, path, place).help(format!("one of {}", listing(&known)))),
    };
    let extra = cases.into_iter().find(|case| case.word == word).map(|case| case.fields);
    Ok(common.iter().copied().chain(extra.unwrap_or_default()).collect())
}

/// The other keys of a table whose tag is wrong: right is what is right for any of its words, and nothing is missing.
fn untagged(entries: &[Entry], (tag, common, cases): (&str, &[Field], Vec<Case>), path: &str) -> Outcome<()> {
    let fields: Vec<Field> =
        common.iter().copied().chain(cases.into_iter().flat_map(|case| case.fields)).collect();
    let one = |entry: &Entry| {
        let path = dotted(path, &entry.key);
        let mut found = fields.iter().filter(|field| field.key == entry.key);
        let Some(first) = found.next() else {
            return Err(Fault::new(entry.place, format!("unknown key `{path}`")).help(suggestion(
                &entry.key,
                fields.iter().map(|field| field.key).collect::<BTreeSet<_>>(),
            )));
        };
        let fault = complete(&entry.node, &first.form, &path).map(drop);
        fault.or_else(|fault| {
            let fits = found.any(|field| complete(&entry.node, &field.form, &path).is_ok());
            if fits { Ok(()) } else { Err(fault) }
        })
    };
    all(entries.iter().filter(|entry| entry.key != tag).map(one)).map(drop)
}

fn wrong_type(node: &Node, form: &Form, path: &str) -> Fault {
    let found = match &node.data {
        Data::List(items) => format!("an array of {}", items.len()),
        other => other.kind().to_owned(),
    };
    let fault = Fault::new(node.place, format!("`{path}` must be {}, not {found}", form.name()));
    let one_of = |words: &[&str], cases: &[Field]| {
        let keys = cases.iter().map(|case| format!("{{ {} = ... }}", case.key));
        let all: Vec<_> = words.iter().map(|word| format!("{word:?}")).chain(keys).collect();
        format!("one of {}", listing(&all))
    };
    match form {
        Form::One(cases) => fault.help(one_of(&[], cases)),
        Form::Either(options) => {
            let options = options();
            fault.help(one_of(&options.words(), &options.cases))
        }
        Form::Vector(dimension, _) if *dimension != Dimension::One => fault.help(format!(
            "each in {} or a string with a unit, such as \"1 {}\"",
            dimension.si(),
            dimension.si()
        )),
        _ => fault,
    }
}

/// A text that does to a terminal what it looks like.
fn plain(text: &str, place: Place, path: &str) -> Outcome<String> {
    match text.chars().find(|c| c.is_control()) {
        None => Ok(text.to_owned()),
        Some(c) => Err(Fault::new(place, format!("`{path}` holds the control character {c:?}"))
            .help("write it in one line of ordinary letters")),
    }
}

fn missing(key: &str, path: &str, place: Place) -> Fault {
    Fault::new(place, format!("`{}` is missing", dotted(path, key))).label("in this table")
}

fn number(node: &Node, range: &Range, path: &str) -> Outcome<f64> {
    let dimension = range.dimension;
    let value = match &node.data {
        Data::Number(x) => *x,
        Data::Integer(n) => *n as f64,
        Data::Huge(_, x) => *x,
        Data::Text(text) => units::parse(text, dimension).map_err(|what| {
            let accepted = units::accepted(dimension);
            let help = format!("units: {accepted}; a bare number without quotes is in {}", dimension.si());
            Fault::new(node.place, format!("`{path}` {what}")).help(help)
        })?,
        _ => return Err(wrong_type(node, &Form::Number(*range), path)),
    };
    let fits = if node.given { value.is_finite() } else { !value.is_nan() }; // a default may be "no limit"
    if fits && range.contains(value) {
        return Ok(value);
    }
    let wanted = range.words().unwrap_or_else(|| "a finite number".into());
    Err(Fault::new(node.place, format!("`{path}` is {}, but must be {wanted}", range.show(value)))
        .label("out of range"))
}

fn count(n: i64, range: Counts, place: Place, path: &str) -> Outcome<i64> {
    if (range.least..=range.most).contains(&n) {
        return Ok(n);
    }
    Err(wrong_count(n, &range.words(), place, path))
}

fn wrong_count(n: impl Display, wanted: &str, place: Place, path: &str) -> Fault {
    Fault::new(place, format!("`{path}` is {n}, but must be {wanted}")).label("out of range")
}

/// Cores that this process may use.
fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, NonZero::get)
}

fn threads(n: i64, place: Place, path: &str) -> Outcome<i64> {
    let cores = cores();
    if (1..=most_threads(cores)).contains(&n) { Ok(n) } else { Err(wrong_threads(n, cores, place, path)) }
}

fn wrong_threads(n: impl Display, cores: usize, place: Place, path: &str) -> Fault {
    let (most, s) = (most_threads(cores), if cores == 1 { "" } else { "s" });
    let message = format!(
        "`{path}` is {n}, but must be at least 1 and at most {most}: this process may use {cores} core{s}"
    );
    Fault::new(place, message)
        .label("out of range")
        .help(format!("more threads than cores only take turns; without `{path}` every core gets one"))
}

fn choice(text: &str, words: &[&str], place: Place, path: &str) -> Outcome<String> {
    if words.contains(&text) {
        return Ok(text.to_owned());
    }
    let fault = Fault::new(place, format!("`{path}` cannot be {text:?}"));
    Err(fault.help(suggestion(text, words.iter().copied())))
}

fn list(items: &[Node], form: &Form, path: &str) -> Outcome<Data> {
    let item = |(i, item): (usize, &Node)| complete(item, form, &dotted(path, &i.to_string()));
    Ok(Data::List(all(items.iter().enumerate().map(item))?))
}

/// A vector of so many numbers, or rows with ascending times.
fn in_time(
    items: &[Node],
    (dimension, count): (Dimension, usize),
    place: Place,
    path: &str,
) -> Outcome<Data> {
    let form = Form::Vector(dimension, count);
    if !items.iter().any(|item| matches!(item.data, Data::List(_))) {
        return complete(&Node { data: Data::List(items.to_vec()), place, given: true }, &form, path)
            .map(|node| node.data);
    }
    let mut rows = Vec::new();
    let mut last = f64::NEG_INFINITY;
    for (i, row) in items.iter().enumerate() {
        let path = dotted(path, &i.to_string());
        let [time, vector @ ..] = row.items() else {
            let form = if count == 3 { Form::InTime(dimension) } else { Form::NumberInTime(dimension) };
            return Err(wrong_type(row, &form, &path));
        };
        if vector.len() != count {
            let wanted = if count == 3 { "x, y, z" } else { "number" };
            let message = format!("`{path}` must be a row [time, {wanted}], not {} values", vector.len() + 1);
            return Err(Fault::new(row.place, message));
        }
        let time = complete(time, &super::form::any(Dimension::Time), &path)?;
        if time.number() <= last {
            let message = format!("times must ascend, but `{path}` has {} s after {last} s", time.number());
            return Err(Fault::new(row.place, message).help("sort the rows; to jump, use two close times"));
        }
        last = time.number();
        let vector = Node { data: Data::List(vector.to_vec()), ..*row };
        let vector = complete(&vector, &form, &path)?;
        let values = std::iter::once(time).chain(vector.items().to_vec()).collect();
        rows.push(Node { data: Data::List(values), ..*row });
    }
    Ok(Data::List(rows))
}

/// A table with these fields. Where there are unknown keys, none is said to be missing: it may be misspelt.
fn table(entries: &[Entry], fields: &[Field], place: Place, path: &str) -> Outcome<Data> {
    let is_known = |entry: &&Entry| fields.iter().any(|field| field.key == entry.key);
    let unknown = all(entries.iter().filter(|entry| !is_known(entry)).map(|entry| {
        let fault = Fault::new(entry.place, format!("unknown key `{}`", dotted(path, &entry.key)));
        Err::<(), _>(fault.help(suggestion(&entry.key, fields.iter().map(|field| field.key))))
    }));
    let misspelt = unknown.is_err();
    let one = |field: &Field| {
        let given = entries.iter().find(|entry| entry.key == field.key);
        let default = || {
            Some(Entry { key: field.key.into(), place, node: default(&field.absent, &field.form, place)? })
        };
        match given.cloned().or_else(default) {
            Some(entry) => {
                let node = complete(&entry.node, &field.form, &dotted(path, field.key))?;
                Ok(Some(Entry { node, ..entry }))
            }
            None if matches!(field.absent, Absent::Refused) && !misspelt => {
                Err(missing(field.key, path, place).help(format!("{}: {}", field.key, field.meaning)))
            }
            None => Ok(None),
        }
    };
    let (_, found) = both(unknown, all(fields.iter().map(one)))?;
    Ok(Data::Table(found.into_iter().flatten().collect()))
}

/// A table with exactly one of the keys.
fn one(entries: &[Entry], cases: &[Field], place: Place, path: &str) -> Outcome<Data> {
    let keys = || cases.iter().map(|case| case.key);
    if let Some(entry) = entries.iter().find(|entry| !keys().any(|key| key == entry.key)) {
        let fault = Fault::new(entry.place, format!("unknown key `{}`", dotted(path, &entry.key)));
        return Err(fault.help(suggestion(&entry.key, keys())));
    }
    match entries {
        [only] => {
            let only = std::slice::from_ref(only);
            let fields: Vec<_> = cases.iter().filter(|case| case.key == only[0].key).copied().collect();
            table(only, &fields, place, path)
        }
        _ => Err(Fault::new(place, format!("`{path}` must have exactly one key, not {}", entries.len()))
            .help(format!("one of {}", listing(&keys().collect::<Vec<_>>())))),
    }
}

fn default(absent: &Absent, form: &Form, place: Place) -> Option<Node> {
    let node = |data| Node { data, place, given: false };
    let vector = |v: &[f64; 3]| node(Data::List(v.map(|x| node(Data::Number(x))).to_vec()));
    Some(match absent {
        Absent::Refused | Absent::Nothing => return None,
        Absent::Empty if matches!(form, Form::List(_)) => node(Data::List(vec![])),
        Absent::Empty => node(Data::Table(vec![])),
        Absent::Number(x) => node(Data::Number(*x)),
        Absent::Count(n) => node(Data::Integer(*n)),
        Absent::Three(n) => node(Data::List([*n; 3].map(|n| node(Data::Integer(n))).to_vec())),
        Absent::Vector(v) => vector(v),
        Absent::Word(word) => node(Data::Text((*word).into())),
        Absent::Flag(flag) => node(Data::Flag(*flag)),
        Absent::Case(key, v) => node(Data::Table(vec![Entry { key: (*key).into(), place, node: vector(v) }])),
    })
}

/// Reading completed values. Another form than the described one is an error in the reader, not in the scene.
impl Node {
    /// The value of a key that is required or has a default.
    pub fn get(&self, key: &str) -> &Node {
        self.find(key).unwrap_or_else(|| unreachable!("`{key}` is not in the description of its table"))
    }
    /// The only entry of a table with one case.
    pub fn case(&self) -> Option<(&str, &Node)> {
        self.entries().first().map(|entry| (entry.key.as_str(), &entry.node))
    }
    /// A number in SI.
    pub fn number(&self) -> f64 {
        if let Data::Number(x) = self.data { x } else { unreachable!("no number: {:?}", self.data) }
    }
    /// An integer that is not negative.
    pub fn count<N: TryFrom<i64>>(&self) -> N {
        match self.data {
            Data::Integer(n) => N::try_from(n).unwrap_or_else(|_| unreachable!("{n} is out of its range")),
            _ => unreachable!("no integer: {:?}", self.data),
        }
    }
    /// true or false.
    pub fn flag(&self) -> bool {
        matches!(self.data, Data::Flag(true))
    }
    /// Numbers in SI.
    pub fn vector<const N: usize>(&self) -> [f64; N] {
        std::array::from_fn(|i| self.items()[i].number())
    }
    /// Three counts.
    pub fn counts(&self) -> [usize; 3] {
        std::array::from_fn(|i| self.items()[i].count())
    }
}
