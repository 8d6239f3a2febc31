//! How far two runs may differ.
use std::collections::BTreeMap;

/// What `--tolerance` says. Without any, every bit counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tolerances {
    /// Over the largest value of a label, for all that have none of their own.
    pub relative: Option<f64>,
    /// By label, in its unit.
    pub absolute: BTreeMap<String, f64>,
}

impl Tolerances {
    /// From texts `1e-6` and `label=value`.
    ///
    /// # Errors
    /// What is wrong with one of them.
    pub fn parse(texts: &[String]) -> Result<Self, String> {
        let mut tolerances = Self::default();
        for text in texts {
            let (label, value) =
                text.split_once('=').map_or((None, text.as_str()), |(l, v)| (Some(l.trim()), v));
            let value = value.trim().parse().ok().filter(|value: &f64| *value >= 0.0).ok_or_else(|| {
                format!("--tolerance {text}: write a number, for example 1e-6, or LABEL=NUMBER in the label's unit")
            })?;
            match label {
                Some(label) => drop(tolerances.absolute.insert(label.to_owned(), value)),
                None => tolerances.relative = Some(value),
            }
        }
        Ok(tolerances)
    }

    /// What is allowed of a label whose largest value is `largest`; `None`: the same bits.
    pub fn allowed(&self, label: &str, largest: f64) -> Option<f64> {
        let own = self.absolute.get(label).copied();
        own.or_else(|| self.relative.map(|relative| relative * largest))
    }

    /// Whether every bit counts.
    pub fn none(&self) -> bool {
        self.relative.is_none() && self.absolute.is_empty()
    }
}
