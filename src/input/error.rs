//! What is wrong with a scene, where, and what to do about it.
use super::source::{Place, Source};
use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};
use std::fmt::{self, Display};

/// A scene that cannot be run. As a [`miette::Diagnostic`] it shows the line and names a remedy.
#[derive(Debug, thiserror::Error)]
#[error("{}", self.details.message)]
pub struct SceneError {
    details: Box<Details>,
}

#[derive(Debug)]
struct Details {
    message: String,
    help: Option<String>,
    source: Option<NamedSource<String>>,
    label: Option<LabeledSpan>,
    line: Option<usize>,
}

impl SceneError {
    /// An error that has no place in a scene, such as a file that is not there.
    pub(super) fn elsewhere(message: String, help: impl Into<Option<String>>) -> Self {
        let details = Details { message, help: help.into(), source: None, label: None, line: None };
        Self { details: Box::new(details) }
    }

    /// The 1-based line of the scene file that is at fault; `None` if the fault is not in the file.
    pub fn line(&self) -> Option<usize> {
        self.details.line
    }
}

impl Diagnostic for SceneError {
    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        self.details.help.as_ref().map(|help| Box::new(help) as Box<dyn Display>)
    }
    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.details.source.as_ref().map(|source| source as &dyn SourceCode)
    }
    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.details
            .label
            .clone()
            .map(|label| Box::new(std::iter::once(label)) as Box<dyn Iterator<Item = _>>)
    }
}

/// A fault at a place, before the sources are at hand that make it a [`SceneError`].
#[derive(Debug)]
pub(super) struct Fault {
    message: String,
    help: Option<String>,
    label: &'static str,
    place: Place,
}

/// What reading a part of a scene gives.
pub(super) type Outcome<T> = Result<T, Fault>;

impl Fault {
    pub fn new(place: Place, message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None, label: "here", place }
    }

    /// Names the remedy.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Says what the marked text is.
    pub fn label(mut self, label: &'static str) -> Self {
        self.label = label;
        self
    }

    /// Shows the fault in its source.
    pub fn in_sources(self, sources: &[Source]) -> SceneError {
        let Self { message, help, label, place } = self;
        let Some(source) = sources.get(place.source) else { return SceneError::elsewhere(message, help) };
        let text = source.text.get(place.start..place.end).unwrap_or_default();
        let length = text.lines().next().unwrap_or_default().len(); // one line is enough to show
        let label = LabeledSpan::new(Some(label.into()), place.start, length);
        let line = (place.source == 0).then(|| source.line(place.start));
        let source = NamedSource::new(&source.name, source.text.clone()).with_language("TOML");
        let details = Details { message, help, source: Some(source), label: Some(label), line };
        SceneError { details: Box::new(details) }
    }
}

/// "did you mean ...?", or all the words that there are.
pub(super) fn suggestion<'a>(wrong: &str, words: impl IntoIterator<Item = &'a str>) -> String {
    let words: Vec<_> = words.into_iter().collect();
    let nearest = words
        .iter()
        .map(|word| (strsim::damerau_levenshtein(wrong, word), word))
        .filter(|(distance, word)| *distance <= 1 + word.len() / 3)
        .min();
    match nearest {
        Some((_, word)) => format!("did you mean `{word}`? There are: {}", listing(&words)),
        None if words.is_empty() => "there are none".into(),
        None => format!("there are: {}", listing(&words)),
    }
}

/// `a`, `b`, `c`
pub(super) fn listing<W: Display>(words: &[W]) -> String {
    words.iter().map(|word| format!("`{word}`")).collect::<Vec<_>>().join(", ")
}

/// A point as people write it [m].
pub(super) struct Point(pub [f64; 3]);

impl Display for Point {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let round = |x: f64| (x * 1e9).round() / 1e9; // lattice sums end in noise
        write!(f, "({}, {}, {}) m", round(self.0[0]), round(self.0[1]), round(self.0[2]))
    }
}
