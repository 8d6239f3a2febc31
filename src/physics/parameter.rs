//! How laws and conditions describe themselves and their parameters, so that scenes are read, checked and documented from
//! one table.
use super::table::Table;
use std::collections::BTreeMap;

/// Physical dimension of a number, with its SI unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// A pure number.
    One,
    /// m
    Length,
    /// s
    Time,
    /// m/s
    Velocity,
    /// m/s²
    Acceleration,
    /// kg/m³
    Density,
    /// Pa
    Stress,
    /// N
    Force,
    /// rad
    Angle,
    /// rad/s
    AngularVelocity,
    /// 1/s
    Rate,
}

impl Dimension {
    /// All dimensions, in the order of the documentation.
    pub const ALL: &[Dimension] = &[
        Dimension::One,
        Dimension::Length,
        Dimension::Time,
        Dimension::Velocity,
        Dimension::Acceleration,
        Dimension::Density,
        Dimension::Stress,
        Dimension::Force,
        Dimension::Angle,
        Dimension::AngularVelocity,
        Dimension::Rate,
    ];

    /// The SI unit.
    pub fn si(self) -> &'static str {
        match self {
            Dimension::One => "1",
            Dimension::Length => "m",
            Dimension::Time => "s",
            Dimension::Velocity => "m/s",
            Dimension::Acceleration => "m/s^2",
            Dimension::Density => "kg/m^3",
            Dimension::Stress => "Pa",
            Dimension::Force => "N",
            Dimension::Angle => "rad",
            Dimension::AngularVelocity => "rad/s",
            Dimension::Rate => "1/s",
        }
    }
}

/// What a parameter accepts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A number of a dimension in a range.
    Number {
        /// Its dimension.
        dimension: Dimension,
        /// The least value; exclusive if `open_below`.
        least: f64,
        /// Whether `least` itself is refused.
        open_below: bool,
        /// The greatest value, inclusive (infinite: unbounded).
        most: f64,
        /// `None`: the scene must give it.
        default: Option<f64>,
    },
    /// One of several words; the first is the default.
    Choice(&'static [&'static str]),
    /// true or false, with the default.
    Flag(bool),
    /// A velocity in time, which the scene must give unless it is rest where it gives none.
    Motion {
        /// Whether the scene need not give it.
        rest: bool,
    },
}

/// One parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Key in the scene file.
    pub key: &'static str,
    /// What it accepts.
    pub kind: Kind,
    /// What it means, in a sentence.
    pub meaning: &'static str,
}

impl Parameter {
    /// A number above zero that the scene must give.
    pub const fn positive(key: &'static str, dimension: Dimension, meaning: &'static str) -> Self {
        let kind =
            Kind::Number { dimension, least: 0.0, open_below: true, most: f64::INFINITY, default: None };
        Self { key, kind, meaning }
    }

    /// A number above zero with a default.
    pub const fn positive_or(
        key: &'static str,
        dimension: Dimension,
        default: f64,
        meaning: &'static str,
    ) -> Self {
        let default = Some(default);
        let kind = Kind::Number { dimension, least: 0.0, open_below: true, most: f64::INFINITY, default };
        Self { key, kind, meaning }
    }

    /// One of several words; the first is the default.
    pub const fn choice(key: &'static str, words: &'static [&'static str], meaning: &'static str) -> Self {
        Self { key, kind: Kind::Choice(words), meaning }
    }

    /// true or false, with the default.
    pub const fn flag(key: &'static str, default: bool, meaning: &'static str) -> Self {
        Self { key, kind: Kind::Flag(default), meaning }
    }

    /// A velocity in time that the scene must give.
    pub const fn motion(key: &'static str, meaning: &'static str) -> Self {
        Self { key, kind: Kind::Motion { rest: false }, meaning }
    }

    /// A velocity in time; rest, if the scene gives none.
    pub const fn motion_or_rest(key: &'static str, meaning: &'static str) -> Self {
        Self { key, kind: Kind::Motion { rest: true }, meaning }
    }

    /// A number of at least `least`, with a default (`None`: the scene must give it).
    pub const fn at_least(
        key: &'static str,
        dimension: Dimension,
        least: f64,
        default: Option<f64>,
        meaning: &'static str,
    ) -> Self {
        let kind = Kind::Number { dimension, least, open_below: false, most: f64::INFINITY, default };
        Self { key, kind, meaning }
    }
}

/// The values a scene gave, in SI, defaults filled in: every parameter is there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values {
    /// Numbers in SI units.
    pub numbers: BTreeMap<&'static str, f64>,
    /// Chosen words.
    pub choices: BTreeMap<&'static str, String>,
    /// Flags.
    pub flags: BTreeMap<&'static str, bool>,
    /// Velocities in time.
    pub motions: BTreeMap<&'static str, Table>,
}

impl Values {
    /// The number of a parameter.
    ///
    /// # Panics
    /// If a law asks for a key that it did not describe: an error in the law, not in the scene.
    pub fn number(&self, key: &str) -> f64 {
        self.numbers[key]
    }
    /// The chosen word. Panics as [`Values::number`].
    pub fn choice(&self, key: &str) -> &str {
        &self.choices[key]
    }
    /// The flag. Panics as [`Values::number`].
    pub fn flag(&self, key: &str) -> bool {
        self.flags[key]
    }
    /// The velocity in time. Panics as [`Values::number`].
    pub fn motion(&self, key: &str) -> &Table {
        &self.motions[key]
    }
}

/// Values that are each in range but not together: the key to blame, and what is wrong.
pub type Refusal = (&'static str, String);

/// What a scene can choose by a word: a law or a family of laws, a contact law, a condition.
pub trait Described {
    /// The word.
    const NAME: &'static str;
    /// What it models, with its source.
    const SUMMARY: &'static str;
    /// Its parameters, in the order of the documentation.
    const PARAMETERS: &'static [Parameter];
    /// What the values make: mostly the type itself.
    type Built;
    /// That, from complete, checked values.
    ///
    /// # Errors
    /// Values that are each in range but not together.
    fn build(values: &Values) -> Result<Self::Built, Refusal>;
}

/// A line of a registry: what the scene reader needs to know of something that makes a `T`.
pub struct Entry<T> {
    /// The word that chooses it.
    pub name: &'static str,
    /// What it models, with its source.
    pub summary: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Makes it from complete, checked values.
    pub build: fn(&Values) -> Result<T, Refusal>,
}

impl<T> Entry<T> {
    /// The line of `D`.
    pub const fn of<D: Described>() -> Self
    where
        T: From<D::Built>,
    {
        Self { name: D::NAME, summary: D::SUMMARY, parameters: D::PARAMETERS, build: build::<T, D> }
    }
}

fn build<T: From<D::Built>, D: Described>(values: &Values) -> Result<T, Refusal> {
    D::build(values).map(T::from)
}
