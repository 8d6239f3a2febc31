//! Scenes that are almost right: what people mistype, copy to the wrong place, or never thought of.
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Random numbers from a seed: SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let x = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    fn of<'a, T>(&mut self, all: &'a [T]) -> Option<&'a T> {
        all.get(self.below(all.len()))
    }
}

/// Values, as TOML, where others are expected.
const VALUES: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "3",
    "1000",
    "0.5",
    "1e-9",
    "1e9",
    "-0.0",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "1e300",
    "-1e300",
    "1e308",
    "5e-324",
    "1e-300",
    "9223372036854775807",
    "-9223372036854775808",
    "99999999999999999999",
    "-99999999999999999999",
    "0xffffffffffffffffffff",
    "4294967296",
    "1048577",
    "65537",
    "true",
    "false",
    "1979-05-27T07:32:00Z",
    "[]",
    "[[]]",
    "{}",
    "[{}]",
    "[0, 0, 0]",
    "[1, 2]",
    "[1, 2, 3, 4]",
    "[[0, 1, 2, 3]]",
    "[[0, 0, 0, 0], [1, 1, 0, 0]]",
    "[[1, 0, 0, 0], [0, 1, 0, 0]]",
    "[nan, 0, 0]",
    "[1e300, 0, 0]",
    "[\"1 mm\", 0, 0]",
    "{ a = 1 }",
    "{ uniform = [0, 0, 0] }",
    "\"\"",
    "\" \"",
    "\"x\"",
    "\"free\"",
    "\"fixed\"",
    "\"rigid\"",
    "\"symmetric\"",
    "\"prescribed\"",
    "\"neo-hookean\"",
    "\"friction\"",
    "\"bonded\"",
    "\"per-material\"",
    "\"1 mm\"",
    "\"-3 mm\"",
    "\"1e6 m\"",
    "\"0 m\"",
    "\"7 kPa\"",
    "\"1 s\"",
    "\"1 ns\"",
    "\"1e400 m\"",
    "\"1e-400 m\"",
    "\"1 parsec\"",
    "\"1\"",
    "\"mm\"",
    "\"1 µm\"",
    "\"90 deg\"",
    "\"45 %\"",
    "\"\\u0000\"",
    "\"\\u001b[2J\"",
    "\"a\\nb\"",
    "\"Stück\"",
    "\"球\"",
    "\"\\u202etxet\"",
    "\"+x\"",
    "\"xyz\"",
    "\"none\"",
    "\"all\"",
    "\"/dev/zero\"",
    "\"../../..\"",
];

/// Pieces of text at places where none belong.
const PIECES: &[&str] = &[
    "=",
    "[",
    "]",
    "{",
    "}",
    "\"",
    "'",
    "#",
    ",",
    ".",
    "\n",
    "\r",
    "\t",
    "\0",
    "\u{1b}[31m",
    "\u{85}",
    "\u{202e}",
    "é",
    "[[",
    "]]",
    "\"\"\"",
    "\\u",
    "[body]\n",
    "[[body]]\n",
    "[run]\n",
    "[material.x]\n",
    "nan",
    "e999",
    "-",
    "_",
    "0x",
    "1.",
    "🦴",
    "\u{feff}",
    "{ a.b.c = 1 }",
];

/// One step of a path into a document.
#[derive(Clone, Debug)]
enum Step {
    Key(String),
    Item(usize),
}

/// A scene with one more fault, or another one; `others` are those that it may copy from.
pub fn mutate(scene: &[u8], seed: u64, others: &[Table]) -> Vec<u8> {
    let random = &mut Random(seed);
    let table = std::str::from_utf8(scene).ok().and_then(|text| text.parse::<Table>().ok());
    match (random.below(20), table) {
        (0, _) => bytes(scene.to_vec(), random),
        (1..=3, _) | (_, None) => lines(scene, random),
        (_, Some(table)) => {
            let mut root = Value::Table(table);
            tree(&mut root, random, others);
            root.as_table().and_then(|table| toml::to_string(table).ok()).unwrap_or_default().into_bytes()
        }
    }
}

fn bytes(mut scene: Vec<u8>, random: &mut Random) -> Vec<u8> {
    let at = random.below(scene.len());
    match random.below(5) {
        0 if at < scene.len() => scene[at] ^= 1 << random.below(8),
        1 if at < scene.len() => drop(scene.remove(at)),
        2 => scene.insert(at, random.next() as u8),
        3 => scene.truncate(at),
        _ => {
            let piece = random.of(PIECES).copied().unwrap_or_default();
            scene.splice(at..at, piece.bytes());
        }
    }
    scene
}

fn lines(scene: &[u8], random: &mut Random) -> Vec<u8> {
    let mut lines: Vec<&[u8]> = scene.split(|byte| *byte == b'\n').collect();
    let (at, to) = (random.below(lines.len()), random.below(lines.len()));
    let mut line = lines[at].to_vec();
    match random.below(6) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(to, &line),
        2 => lines.swap(at, to),
        3 => {
            lines.remove(at);
            lines.insert(to.min(lines.len()), &line);
        }
        4 => {
            // another value, right or not
            let key = line.iter().position(|byte| *byte == b'=').map_or(0, |equals| equals + 1);
            line.truncate(key);
            line.extend(random.of(VALUES).copied().unwrap_or_default().bytes());
            lines[at] = &line;
        }
        _ => {
            line = bytes(line, random);
            lines[at] = &line;
        }
    }
    lines.join(&b'\n')
}

fn tree(root: &mut Value, random: &mut Random, others: &[Table]) {
    let all = paths(root);
    let (Some(path), Some(other)) = (random.of(&all).cloned(), random.of(&all).cloned()) else { return };
    match random.below(12) {
        0 => drop(remove(root, &path)),
        1 => {
            // a key under another name, or an item twice
            let Some(value) = at(root, &path).map(|value| value.clone()) else { return };
            insert(root, &path, "copy", value);
        }
        2 => {
            let [a, b] = [&path, &other].map(|path| at(root, path).map(|value| value.clone()));
            if let (Some(a), Some(b)) = (a, b) {
                replace(root, &path, b);
                replace(root, &other, a);
            }
        }
        3 => {
            if let Some(value) = remove(root, &path) {
                insert(root, &other, &name(&path), value);
            }
        }
        4 => {
            // of another scene: what has the same name, if there is one
            let Some(other) = random.of(others) else { return };
            let mut other = Value::Table(other.clone());
            let all = paths(&other);
            let same: Vec<_> = all.iter().filter(|from| name(from) == name(&path)).cloned().collect();
            let from = random.of(if same.is_empty() { &all } else { &same }).cloned().unwrap_or_default();
            if let Some(value) = at(&mut other, &from).map(|value| value.clone()) {
                replace(root, &path, value);
            }
        }
        5 => {
            // a word of the scene, such as the name of another material
            let words: Vec<_> = all
                .iter()
                .flatten()
                .filter_map(|step| if let Step::Key(key) = step { Some(key.clone()) } else { None })
                .collect();
            let words: Vec<_> = words.into_iter().collect::<BTreeSet<_>>().into_iter().collect();
            let word = random.of(&words).cloned().unwrap_or_default();
            replace(root, &path, Value::String(word));
        }
        6..=9 => {
            if let Some(value) = at(root, &path) {
                scale(value, random);
            }
        }
        10 => replace(root, &path, Value::String("long ".repeat(1 + random.below(4000)))),
        _ => {
            let text = random.of(VALUES).copied().unwrap_or_default();
            let value = format!("x = {text}").parse::<Table>().ok().and_then(|mut table| table.remove("x"));
            replace(root, &path, value.unwrap_or(Value::Integer(0)));
        }
    }
}

/// Another number of the same unit.
fn scale(value: &mut Value, random: &mut Random) {
    let factors = [-1.0, 0.0, 0.5, 0.99, 1.01, 2.0, 3.0, 10.0, 1e3, 1e-3, 1e12, 1e-12, 1e200, 1e-200];
    let factor = random.of(&factors).copied().unwrap_or(1.0);
    match value {
        Value::Float(x) => *x *= factor,
        Value::Integer(n) => *value = Value::Float(*n as f64 * factor),
        Value::String(text) => {
            let end = text.find(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c))).unwrap_or(text.len());
            if let Ok(number) = text[..end].parse::<f64>() {
                *text = format!("{:e}{}", number * factor, &text[end..]);
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| scale(item, random)),
        _ => {}
    }
}

/// The paths of all values.
fn paths(root: &Value) -> Vec<Vec<Step>> {
    let mut found = Vec::new();
    visit(root, &mut Vec::new(), &mut found);
    found
}

fn visit(value: &Value, path: &mut Vec<Step>, found: &mut Vec<Vec<Step>>) {
    let children: Vec<(Step, &Value)> = match value {
        Value::Table(table) => table.iter().map(|(key, value)| (Step::Key(key.clone()), value)).collect(),
        Value::Array(items) => items.iter().enumerate().map(|(i, item)| (Step::Item(i), item)).collect(),
        _ => Vec::new(),
    };
    for (step, child) in children {
        path.push(step);
        found.push(path.clone());
        visit(child, path, found);
        path.pop();
    }
}

fn name(path: &[Step]) -> String {
    match path.last() {
        Some(Step::Key(key)) => key.clone(),
        Some(Step::Item(i)) => i.to_string(),
        None => String::new(),
    }
}

fn at<'a>(root: &'a mut Value, path: &[Step]) -> Option<&'a mut Value> {
    path.iter().try_fold(root, |value, step| match (value, step) {
        (Value::Table(table), Step::Key(key)) => table.get_mut(key),
        (Value::Array(items), Step::Item(i)) => items.get_mut(*i),
        _ => None,
    })
}

fn replace(root: &mut Value, path: &[Step], value: Value) {
    if let Some(there) = at(root, path) {
        *there = value;
    }
}

fn remove(root: &mut Value, path: &[Step]) -> Option<Value> {
    let (last, parent) = path.split_last()?;
    match (at(root, parent)?, last) {
        (Value::Table(table), Step::Key(key)) => table.remove(key),
        (Value::Array(items), Step::Item(i)) if *i < items.len() => Some(items.remove(*i)),
        _ => None,
    }
}

/// Puts a value beside the one at a path; into a table as `key`.
fn insert(root: &mut Value, path: &[Step], key: &str, value: Value) {
    match path.split_last().and_then(|(_, parent)| at(root, parent)) {
        Some(Value::Table(table)) => drop(table.insert(key.to_owned(), value)),
        Some(Value::Array(items)) => items.push(value),
        _ => {}
    }
}
