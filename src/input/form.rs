//! What a scene may say, as data: from one description of a field come its checks, its default and its documentation.
use physics::parameter::{Dimension, Entry, Kind, Parameter};

/// A key of a table.
#[derive(Clone, Copy)]
pub(super) struct Field {
    pub key: &'static str,
    pub form: Form,
    pub absent: Absent,
    pub meaning: &'static str,
}

/// What holds when a scene does not give a field.
#[derive(Clone, Copy)]
pub(super) enum Absent {
    /// That is an error.
    Refused,
    /// The scene has no such thing.
    Nothing,
    /// A table with the defaults of its fields, or an array without items.
    Empty,
    /// A number in SI.
    Number(f64),
    /// A count.
    Count(i64),
    /// A count or a number, three times.
    Three(i64),
    /// A direction.
    Vector([f64; 3]),
    Word(&'static str),
    Flag(bool),
    /// A table with one case: a vector.
    Case(&'static str, [f64; 3]),
}

/// What a value must look like.
#[derive(Clone, Copy)]
pub(super) enum Form {
    Number(Range),
    Count(Counts),
    /// One count for all axes, or one for each.
    Counts(Counts),
    /// Patches: one count in all, or one for each axis.
    Patches(Counts),
    /// Threads of a process: see [`most_threads`].
    Threads,
    Choice(&'static [&'static str]),
    Flag,
    Text,
    /// The name of a material of the scene.
    Material,
    /// The names of two materials.
    Pair,
    /// As many numbers of one dimension.
    Vector(Dimension, usize),
    /// A vector of a dimension in time: one vector, or rows of time and vector, linear in between.
    InTime(Dimension),
    /// A number of a dimension in time: one number, or rows of time and number, linear in between.
    NumberInTime(Dimension),
    Table(&'static [Field]),
    /// Any number of items.
    List(&'static Form),
    /// Tables with names that the scene chooses.
    Named(&'static Form),
    /// A table with these parameters.
    Parameters(&'static [Parameter]),
    /// A table with exactly one of the keys.
    One(&'static [Field]),
    /// A word, or a table with exactly one key.
    Either(fn() -> Options),
    /// A table with further keys that depend on the word of one of them.
    Tagged {
        tag: &'static str,
        common: &'static [Field],
        cases: fn() -> Vec<Case>,
    },
    /// A form that is described elsewhere, which breaks the cycle of shapes within shapes.
    Other(&'static Form),
}

/// Numbers of a dimension.
#[derive(Clone, Copy)]
pub(super) struct Range {
    pub dimension: Dimension,
    pub least: f64,
    /// Whether `least` itself is refused.
    pub open_below: bool,
    pub most: f64,
}

/// Integers, both ends inclusive.
#[derive(Clone, Copy)]
pub(super) struct Counts {
    pub least: i64,
    pub most: i64,
}

/// A word of a tag and the fields that come with it.
pub(super) struct Case {
    pub word: &'static str,
    pub summary: &'static str,
    pub fields: Vec<Field>,
}

impl<T> From<&Entry<T>> for Case {
    fn from(entry: &Entry<T>) -> Self {
        let fields = entry.parameters.iter().map(Field::from).collect();
        Self { word: entry.name, summary: entry.summary, fields }
    }
}

/// What may be chosen: words with what they mean, and keys.
#[derive(Default)]
pub(super) struct Options {
    pub words: Vec<(&'static str, &'static str)>,
    pub cases: Vec<Field>,
}

impl Options {
    /// The entries of a registry: one without parameters is a word, the others are keys of a table.
    pub fn of<T>(entries: &[Entry<T>]) -> Self {
        let mut options = Self::default();
        for entry in entries {
            let (key, meaning) = (entry.name, entry.summary);
            match (entry.parameters, sole(entry)) {
                ([], _) => options.words.push((key, meaning)),
                (_, Some(only)) => options.cases.push(Field { meaning, ..Field::from(only) }),
                (all, None) => options.cases.push(Field::required(key, Form::Parameters(all), meaning)),
            }
        }
        options
    }

    /// The words without their meaning.
    pub fn words(&self) -> Vec<&'static str> {
        self.words.iter().map(|(word, _)| *word).collect()
    }
}

/// The only parameter of an entry, if it is called like the entry: `{ name = value }` says all.
pub(super) fn sole<T>(entry: &Entry<T>) -> Option<&'static Parameter> {
    entry.parameters.first().filter(|first| entry.parameters.len() == 1 && first.key == entry.name)
}

impl Field {
    pub const fn required(key: &'static str, form: Form, meaning: &'static str) -> Self {
        Self { key, form, absent: Absent::Refused, meaning }
    }
    pub const fn optional(key: &'static str, form: Form, meaning: &'static str) -> Self {
        Self { key, form, absent: Absent::Nothing, meaning }
    }
    pub const fn with_default(key: &'static str, form: Form, absent: Absent, meaning: &'static str) -> Self {
        Self { key, form, absent, meaning }
    }
}

impl From<&Parameter> for Field {
    fn from(parameter: &Parameter) -> Self {
        let (form, absent) = match parameter.kind {
            Kind::Number { dimension, least, open_below, most, default } => (
                Form::Number(Range { dimension, least, open_below, most }),
                // what has no end is not written: scenes leave it out
                match default {
                    None => Absent::Refused,
                    Some(number) if number.is_infinite() => Absent::Nothing,
                    Some(number) => Absent::Number(number),
                },
            ),
            Kind::Choice(words) => {
                (Form::Choice(words), words.first().map_or(Absent::Refused, |word| Absent::Word(word)))
            }
            Kind::Flag(default) => (Form::Flag, Absent::Flag(default)),
            Kind::Motion { rest } => {
                let absent = if rest { Absent::Vector([0.0; 3]) } else { Absent::Refused };
                (Form::InTime(Dimension::Velocity), absent)
            }
        };
        Self { key: parameter.key, form, absent, meaning: parameter.meaning }
    }
}

/// Any number.
pub(super) const fn any(dimension: Dimension) -> Form {
    Form::Number(Range { dimension, least: f64::NEG_INFINITY, open_below: false, most: f64::INFINITY })
}

/// Numbers above zero.
pub(super) const fn positive(dimension: Dimension) -> Form {
    Form::Number(Range { dimension, least: 0.0, open_below: true, most: f64::INFINITY })
}

/// Numbers from zero.
pub(super) const fn not_negative(dimension: Dimension) -> Form {
    Form::Number(Range { dimension, least: 0.0, open_below: false, most: f64::INFINITY })
}

/// Integers from `least`.
pub(super) const fn count_from(least: i64) -> Form {
    Form::Count(Counts { least, most: i64::MAX })
}

/// So many threads a process may have on any machine; they start in a second.
pub(super) const THREADS: i64 = 1024;
/// On large machines it may have so many for each core.
pub(super) const THREADS_A_CORE: i64 = 4;

/// The most threads of a process that may use so many cores.
pub(super) fn most_threads(cores: usize) -> i64 {
    let of_cores = i64::try_from(cores).unwrap_or(i64::MAX).saturating_mul(THREADS_A_CORE);
    of_cores.max(THREADS)
}

impl Range {
    pub fn contains(&self, x: f64) -> bool {
        (if self.open_below { x > self.least } else { x >= self.least }) && x <= self.most
    }

    /// A number with its SI unit.
    pub fn show(&self, x: f64) -> String {
        match self.dimension {
            Dimension::One => x.to_string(),
            _ if x == 0.0 => "0".into(),
            dimension => format!("{x} {}", dimension.si()),
        }
    }

    /// The range in words; `None` if every number will do.
    pub fn words(&self) -> Option<String> {
        let least =
            format!("{} {}", if self.open_below { "above" } else { "at least" }, self.show(self.least));
        let most = format!("at most {}", self.show(self.most));
        match (self.least.is_finite(), self.most.is_finite()) {
            (true, true) => Some(format!("{least} and {most}")),
            (true, false) => Some(least),
            (false, true) => Some(most),
            (false, false) => None,
        }
    }
}

impl Counts {
    /// Both ends in words, whatever they are.
    pub fn limits(&self) -> String {
        format!("{} to {}", self.least, self.most)
    }

    /// The range in words.
    pub fn words(&self) -> String {
        match self.most {
            i64::MAX => format!("at least {}", self.least),
            most => format!("{} to {most}", self.least),
        }
    }
}

impl Form {
    /// What a value of this form is called, with its article.
    pub fn name(&self) -> String {
        match self {
            Form::Number(range) => super::units::name(range.dimension).to_owned(),
            Form::Count(_) | Form::Threads => "an integer".into(),
            Form::Counts(_) | Form::Patches(_) => "an integer or an array of three".into(),
            Form::Choice(_) | Form::Text => "a string".into(),
            Form::Flag => "true or false".into(),
            Form::Material => "the name of a material".into(),
            Form::Pair => "an array of the names of two materials".into(),
            Form::Vector(_, length) => format!("an array of {length} numbers"),
            Form::InTime(_) => "a vector or an array of rows [time, x, y, z]".into(),
            Form::NumberInTime(_) => "a number or an array of rows [time, number]".into(),
            Form::Table(_) | Form::Parameters(_) | Form::Named(_) | Form::Tagged { .. } => "a table".into(),
            Form::List(_) => "an array".into(),
            Form::One(_) => "a table with one key".into(),
            Form::Either(_) => "a word or a table with one key".into(),
            Form::Other(form) => form.name(),
        }
    }
}
