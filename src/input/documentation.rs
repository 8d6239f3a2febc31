//! `docs/SCENE.md`, written from the same descriptions that scenes are checked by.
use super::fields::{FACE, SCENE};
use super::form::{Absent, Field, Form, Options, THREADS, THREADS_A_CORE};
use super::shapes::SHAPE;
use super::units;
use physics::parameter::Dimension;
use std::fmt::Write;

const INTRODUCTION: &str = "\
# Scene files

A scene is a folder with a `scene.toml`, or a TOML file. This page is generated (`sinew scene-docs`) from the \
descriptions by which scenes are read; what is not on it is an error in a scene.

- A number with a dimension is a string with a unit, `\"0.5 mm\"`, or a bare number in SI. A string without a unit is an error.
- Every item of a vector can have its own unit: `[\"50 mm\", 0.01, \"1 cm\"]`.
- `--set KEY=VALUE` changes any field from the command line, before anything is checked: `--set run.cfl=0.2`, \
`--set contact.0.friction=0.1`, `--set body.bullet.velocity.1='-150 m/s'`. Items of arrays have an index, or the `name` they \
give themselves. Without a value the key is removed.
- A *vector in time* is `[x, y, z]`, or rows `[[time, x, y, z], ...]` with ascending times: linear between the rows, \
constant before and after them. A *number in time* is a number, or rows `[[time, number], ...]`.
- ";

const EXAMPLE: &str = include_str!("../../problems/two-spheres/scene.toml");

/// The page on scene files, as Markdown: every field with its meaning, unit, range and default, and an example.
pub fn documentation() -> String {
    let mut page = Page(format!("{INTRODUCTION}{}\n\n", super::moduli::WORDS));
    page.units();
    page.fields(SCENE);
    for field in SCENE {
        let heading = match field.form {
            Form::Table(_) => format!("[{}]", field.key),
            Form::Named(_) => format!("[{}.NAME]", field.key),
            Form::List(_) => format!("[[{}]]", field.key),
            _ => continue,
        };
        page.section(2, &heading, field.meaning, &field.form);
    }
    page.section(
        2,
        "face",
        "What holds on a face of the domain: one of these words, or a table with one key.",
        &FACE,
    );
    page.section(2, "shape", "A shape is a table with exactly one of these keys.", &SHAPE);
    page.line("## An example\n");
    page.line(&format!("```toml\n{EXAMPLE}```"));
    page.0
}

struct Page(String);

impl Page {
    fn line(&mut self, text: &str) {
        self.0.push_str(text);
        self.0.push('\n');
    }

    fn row(&mut self, cells: &[&str]) {
        let cells: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        self.line(&format!("| {} |", cells.join(" | ")));
    }

    fn units(&mut self) {
        self.line("## Units\n");
        self.row(&["Quantity", "Units, SI first"]);
        self.row(&["---", "---"]);
        for dimension in Dimension::ALL {
            self.row(&[units::name(*dimension), &units::accepted(*dimension)]);
        }
        self.line("\n## The tables of a scene\n");
    }

    /// A heading, what it is about, its fields, and sections for the fields that have fields themselves.
    fn section(&mut self, depth: usize, name: &str, meaning: &str, form: &Form) {
        let level = "#".repeat(depth);
        self.line(&format!("{level} `{name}`\n\n{meaning}\n"));
        let form = if let Form::List(each) | Form::Named(each) = form { each } else { form };
        match form {
            Form::Table(fields) => {
                self.fields(fields);
                self.nested(depth, name, fields);
            }
            Form::Parameters(parameters) => {
                self.fields(&parameters.iter().map(Field::from).collect::<Vec<_>>())
            }
            Form::One(cases) => self.options(depth, name, &[], cases),
            Form::Either(options) => {
                let Options { words, cases } = options();
                self.options(depth, name, &words, &cases);
            }
            Form::Tagged { tag, common, cases } => {
                let cases = cases();
                let words: Vec<_> = cases.iter().map(|case| case.word).collect();
                self.rows(common, |field| match field.key == *tag {
                    true => quoted(&words).join(", "),
                    false => accepts(&field.form),
                });
                for case in cases {
                    let level = "#".repeat(depth + 1);
                    self.line(&format!(
                        "{level} `{name}` with `{tag} = \"{}\"`\n\n{}\n",
                        case.word, case.summary
                    ));
                    self.fields(&case.fields);
                }
            }
            _ => {}
        }
    }

    fn nested(&mut self, depth: usize, parent: &str, fields: &[Field]) {
        for field in fields.iter().filter(|field| has_section(&field.form)) {
            let name = format!("{parent}.{}", field.key).replace(['[', ']'], "");
            self.section(depth + 1, &name, field.meaning, &field.form);
        }
    }

    /// Words of which one is given, or keys of which a table has exactly one.
    fn options(&mut self, depth: usize, name: &str, words: &[(&str, &str)], cases: &[Field]) {
        self.row(&["One of", "Meaning", "Accepts"]);
        self.row(&["---", "---", "---"]);
        for (word, meaning) in words {
            self.row(&[&format!("`\"{word}\"`"), meaning, "the word alone"]);
        }
        for case in cases {
            self.row(&[&format!("`{}`", case.key), case.meaning, &accepts(&case.form)]);
        }
        self.line("");
        self.nested(depth, name, cases);
    }

    fn fields(&mut self, fields: &[Field]) {
        self.rows(fields, |field| accepts(&field.form));
    }

    fn rows(&mut self, fields: &[Field], accepts: impl Fn(&Field) -> String) {
        if fields.is_empty() {
            return;
        }
        self.row(&["Key", "Meaning", "Accepts", "Default"]);
        self.row(&["---", "---", "---", "---"]);
        for field in fields {
            self.row(&[&format!("`{}`", field.key), field.meaning, &accepts(field), &default(field)]);
        }
        self.line("");
    }
}

fn has_section(form: &Form) -> bool {
    match form {
        Form::Table(_) | Form::Parameters(_) | Form::Tagged { .. } => true,
        Form::One(cases) => cases.iter().any(|case| has_section(&case.form)),
        Form::List(each) => matches!(each, Form::Table(_)),
        _ => false,
    }
}

fn quoted(words: &[&str]) -> Vec<String> {
    words.iter().map(|word| format!("`\"{word}\"`")).collect()
}

fn keyed(cases: &[Field]) -> Vec<String> {
    cases.iter().map(|case| format!("`{{ {} = ... }}`", case.key)).collect()
}

fn accepts(form: &Form) -> String {
    match form {
        Form::Number(range) => {
            let mut text = with_unit(units::name(range.dimension), range.dimension);
            if let Some(words) = range.words() {
                let _ = write!(text, ", {words}");
            }
            text
        }
        Form::Count(counts) => format!("an integer, {}", counts.words()),
        Form::Counts(counts) => format!("an integer or three, each {}", counts.words()),
        Form::Patches(counts) => {
            format!("an integer in all, or three along the axes, each {}", counts.words())
        }
        Form::Threads => format!(
            "an integer, 1 to {THREADS}, or to {THREADS_A_CORE} for each core that the process may use, whichever is more"
        ),
        Form::Choice(words) => quoted(words).join(", "),
        Form::Vector(dimension, length) => with_unit(&format!("{length} numbers"), *dimension),
        Form::InTime(dimension) => with_unit("a vector in time", *dimension),
        Form::NumberInTime(dimension) => with_unit("a number in time", *dimension),
        Form::List(form) if std::ptr::eq(*form, &SHAPE) => "shapes".into(),
        Form::List(Form::Text) => "an array of names".into(),
        Form::List(_) => "tables".into(),
        Form::Named(_) => "named tables".into(),
        Form::One(cases) => keyed(cases).join(", "),
        Form::Either(options) => {
            let options = options();
            [quoted(&options.words()), keyed(&options.cases)].concat().join(", ")
        }
        Form::Other(form) if std::ptr::eq(*form, &SHAPE) => "a [shape](#shape)".into(),
        Form::Other(form) => accepts(form),
        other => other.name(),
    }
}

fn with_unit(name: &str, dimension: Dimension) -> String {
    match dimension {
        Dimension::One => name.to_owned(),
        _ => format!("{name} [{}]", dimension.si()),
    }
}

fn default(field: &Field) -> String {
    let item = |x: f64| if x.is_infinite() { "unlimited".into() } else { format!("`{x:?}`") };
    match field.absent {
        Absent::Refused => "required".into(),
        Absent::Nothing => "absent".into(),
        Absent::Empty if matches!(field.form, Form::List(_)) => "none".into(),
        Absent::Empty => "its defaults".into(),
        Absent::Number(x) => item(x),
        Absent::Count(n) | Absent::Three(n) => format!("`{n}`"),
        Absent::Vector(v) => format!("`{v:?}`"),
        Absent::Word(word) => format!("`\"{word}\"`"),
        Absent::Flag(flag) => format!("`{flag}`"),
        Absent::Case(key, v) => format!("`{{ {key} = {v:?} }}`"),
    }
}
