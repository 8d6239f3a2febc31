//! A TOML document that remembers where each value was written, in the file or on the command line.
use super::error::{Fault, Outcome, suggestion};
use super::source::{Place, Source};
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Parts of a dotted key at most: shapes within shapes have most, and the reader of TOML has a like bound.
const DEEPEST: usize = 64;

/// A value and where it was written; a default has the place of the table that does not give it.
#[derive(Clone, Debug)]
pub(super) struct Node {
    pub data: Data,
    pub place: Place,
    /// Whether the scene gave it.
    pub given: bool,
}

#[derive(Clone, Debug)]
pub(super) enum Data {
    Text(String),
    Integer(i64),
    /// An integer of more than 64 bits, as it is written, and the number next to it.
    Huge(String, f64),
    Number(f64),
    Flag(bool),
    /// Dates, which no field takes.
    Date,
    List(Vec<Node>),
    Table(Vec<Entry>),
}

/// A key of a table, where it stands, and its value.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub key: String,
    pub place: Place,
    pub node: Node,
}

impl Data {
    /// The name of the type, with its article.
    pub fn kind(&self) -> &'static str {
        match self {
            Data::Text(_) => "a string",
            Data::Integer(_) => "an integer",
            Data::Huge(..) => "an integer of more than 64 bits",
            Data::Number(_) => "a number",
            Data::Flag(_) => "a boolean",
            Data::Date => "a date",
            Data::List(_) => "an array",
            Data::Table(_) => "a table",
        }
    }
}

/// Reads the scene file.
pub(super) fn parse(source: &Source) -> Outcome<Node> {
    parse_text(&source.text, 0)
        .map_err(|(span, message)| Fault::new(Place::new(0, span), format!("this is not TOML: {message}")))
}

fn parse_text(text: &str, source: usize) -> Result<Node, (Range<usize>, String)> {
    let table = DeTable::parse(text)
        .map_err(|e| (e.span().unwrap_or_default(), e.message().to_owned()))?
        .into_inner();
    let root = Node { data: Data::Table(vec![]), place: Place { source, start: 0, end: 0 }, given: true };
    Ok(Node { data: Data::Table(entries(table, source)), ..root })
}

fn entries(table: DeTable<'_>, source: usize) -> Vec<Entry> {
    let entry = |(key, value): (Spanned<_>, _)| {
        let place = Place::new(source, key.span());
        let key: std::borrow::Cow<str> = key.into_inner();
        Entry { key: key.into_owned(), place, node: node(value, source) }
    };
    table.into_iter().map(entry).collect()
}

fn node(value: Spanned<DeValue<'_>>, source: usize) -> Node {
    let place = Place::new(source, value.span());
    let data = match value.into_inner() {
        DeValue::String(text) => Data::Text(text.into_owned()),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(integer) => Data::Integer(integer),
            Err(_) => Data::Huge(integer.to_string(), large(integer.as_str(), integer.radix())),
        },
        DeValue::Float(float) => Data::Number(float.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Data::Flag(flag),
        DeValue::Datetime(_) => Data::Date,
        DeValue::Array(array) => Data::List(array.into_iter().map(|value| node(value, source)).collect()),
        DeValue::Table(table) => Data::Table(entries(table, source)),
    };
    Node { data, place, given: true }
}

/// The number next to an integer of any length.
fn large(digits: &str, radix: u32) -> f64 {
    let add = |sum: f64, digit: char| sum * f64::from(radix) + f64::from(digit.to_digit(radix).unwrap_or(0));
    match radix {
        10 => digits.parse().unwrap_or(f64::NAN),
        _ => digits.chars().fold(0.0, add), // has no sign
    }
}

/// Applies the override `key=value`, which is source number `index`: keys are dotted; an array takes an index or the
/// `name` of one of its tables; no value removes the key.
pub(super) fn set(root: &mut Node, key: &str, value: &str, index: usize) -> Outcome<()> {
    let place = Place { source: index, start: 0, end: key.len() };
    let prefix = "x = ";
    let parsed = parse_text(&format!("{prefix}{value}"), index).ok().and_then(|root| match root.data {
        Data::Table(entries) => entries.into_iter().next().map(|entry| entry.node),
        _ => None,
    });
    let bare = Node { data: Data::Text(value.to_owned()), place, given: true };
    let mut value = (!value.is_empty()).then(|| parsed.unwrap_or(bare));
    if let Some(value) = &mut value {
        value.relocate(place); // its own spans count from the made-up prefix
    }
    if key.split('.').count() > DEEPEST {
        return Err(Fault::new(place, "this key leads deeper than any key of a scene")
            .help("for the keys of a scene see: sinew scene-docs"));
    }
    let (parents, last) = key.rsplit_once('.').map_or((None, key), |(parents, last)| (Some(parents), last));
    let mut node = root;
    for part in parents.into_iter().flat_map(|parents| parents.split('.')) {
        node = node.child(part, place)?;
    }
    match (value, &mut node.data) {
        (None, Data::Table(entries)) => entries.retain(|entry| entry.key != last),
        (None, _) => {
            return Err(Fault::new(place, format!("`{key}` cannot be removed: it is not a key of a table")));
        }
        (Some(value), _) => *node.child(last, place)? = value,
    }
    Ok(())
}

impl Node {
    /// The child of a table, made if it is not there, or of an array.
    fn child(&mut self, part: &str, place: Place) -> Outcome<&mut Node> {
        match &mut self.data {
            Data::Table(entries) => {
                let at = entries.iter().position(|entry| entry.key == part).unwrap_or_else(|| {
                    let node = Node { data: Data::Table(vec![]), place, given: true };
                    entries.push(Entry { key: part.to_owned(), place, node });
                    entries.len() - 1
                });
                Ok(&mut entries[at].node)
            }
            Data::List(items) => {
                let named = |item: &Node| item.find("name").is_some_and(|name| name.word() == part);
                let at = part.parse().ok().or_else(|| items.iter().position(named));
                let names: Vec<String> = (0..items.len()).map(|i| i.to_string()).collect();
                at.and_then(|at: usize| items.get_mut(at)).ok_or_else(|| {
                    Fault::new(place, format!("`{part}` is no element of this array"))
                        .help(suggestion(part, names.iter().map(String::as_str)))
                })
            }
            other => Err(Fault::new(place, format!("`{part}` cannot be set inside {}", other.kind()))),
        }
    }

    fn relocate(&mut self, place: Place) {
        self.place = place;
        match &mut self.data {
            Data::List(items) => items.iter_mut().for_each(|item| item.relocate(place)),
            Data::Table(entries) => entries.iter_mut().for_each(|entry| {
                entry.place = place;
                entry.node.relocate(place);
            }),
            _ => {}
        }
    }

    /// The entries of a table; none for other values.
    pub fn entries(&self) -> &[Entry] {
        if let Data::Table(entries) = &self.data { entries } else { &[] }
    }

    /// The items of an array; none for other values.
    pub fn items(&self) -> &[Node] {
        if let Data::List(items) = &self.data { items } else { &[] }
    }

    /// The value of a key, if it is there.
    pub fn find(&self, key: &str) -> Option<&Node> {
        self.entries().iter().find(|entry| entry.key == key).map(|entry| &entry.node)
    }

    /// The text of a string; empty for other values.
    pub fn word(&self) -> &str {
        if let Data::Text(text) = &self.data { text } else { "" }
    }

    /// The line of every key and table that the file gives, by dotted key.
    pub fn lines(&self, file: &Source) -> BTreeMap<String, usize> {
        let mut lines = BTreeMap::new();
        self.collect_lines("", file, &mut lines);
        lines
    }

    fn collect_lines(&self, path: &str, file: &Source, lines: &mut BTreeMap<String, usize>) {
        let mut visit = |key: &str, place: Place, node: &Node| {
            let path = dotted(path, key);
            if node.given && place.source == 0 {
                lines.insert(path.clone(), file.line(place.start));
            }
            node.collect_lines(&path, file, lines);
        };
        match &self.data {
            Data::Table(entries) => entries.iter().for_each(|e| visit(&e.key, e.place, &e.node)),
            Data::List(items) => {
                let tables = items.iter().enumerate().filter(|(_, item)| matches!(item.data, Data::Table(_)));
                tables.for_each(|(i, item)| visit(&i.to_string(), item.place, item));
            }
            _ => {}
        }
    }

    /// The same as a plain TOML value.
    pub fn to_toml(&self) -> toml::Value {
        match &self.data {
            Data::Text(text) => text.as_str().into(),
            Data::Integer(integer) => (*integer).into(),
            Data::Huge(_, number) => (*number).into(),
            Data::Number(number) => (*number).into(),
            Data::Flag(flag) => (*flag).into(),
            Data::Date => "".into(),
            Data::List(items) => toml::Value::Array(items.iter().map(Node::to_toml).collect()),
            Data::Table(entries) => {
                toml::Value::Table(entries.iter().map(|e| (e.key.clone(), e.node.to_toml())).collect())
            }
        }
    }
}

/// `path.key`
pub(super) fn dotted(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}
