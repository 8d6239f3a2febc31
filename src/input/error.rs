//! What is wrong with a scene, where, and what to do about it.
use super::source::{Place, Source};
use miette::{Diagnostic, LabeledSpan, NamedSource, SourceCode};
use std::fmt::{self, Display};
use std::sync::Arc;

/// Faults that are told at once; more are counted.
const MOST: usize = 20;
/// Letters of all of them, beside the first: more of them than fit are counted, too.
const LETTERS: usize = 8000;
/// Words that a misspelt one is held against, and that are listed: each fault has a list.
const MOST_WORDS: usize = 1000;
/// Bytes of a word that may be a misspelt one.
const LONGEST_WORD: usize = 200;
/// Letters of a message, of a help and of a line of the scene that are shown.
const LONGEST: usize = 1000;

/// A scene that cannot be run: all that is wrong with it, in the order of its lines. As a [`miette::Diagnostic`] it shows the
/// lines and names remedies.
#[derive(Debug, thiserror::Error)]
#[error("{}", self.details.message)]
pub struct SceneError {
    details: Box<Details>,
    /// What else is wrong.
    more: Vec<SceneError>,
}

#[derive(Debug)]
struct Details {
    message: String,
    help: Option<String>,
    source: Option<NamedSource<Arc<str>>>,
    label: Option<LabeledSpan>,
    line: Option<usize>,
}

impl SceneError {
    /// An error that has no place in a scene, such as a file that is not there.
    pub(super) fn elsewhere(message: String, help: impl Into<Option<String>>) -> Self {
        let details = Details { message, help: help.into(), source: None, label: None, line: None };
        Self { details: Box::new(details), more: Vec::new() }
    }

    /// The 1-based line of the scene file that is at fault; `None` if the fault is not in the file.
    pub fn line(&self) -> Option<usize> {
        self.details.line
    }

    /// What else is wrong with the scene.
    pub fn more(&self) -> &[SceneError] {
        &self.more
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
    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn Diagnostic> + 'a>> {
        let more = self.more.iter().map(|error| error as &dyn Diagnostic);
        (!self.more.is_empty()).then(|| Box::new(more) as Box<dyn Iterator<Item = _>>)
    }
}

/// A fault at a place, before the sources are at hand that make it a [`SceneError`]; with others, where there are some.
#[derive(Debug)]
pub(super) struct Fault {
    message: String,
    help: Option<String>,
    label: &'static str,
    pub place: Place,
    /// Where in the file it shows, if an override is at fault.
    shows: Option<Place>,
    more: Vec<Fault>,
}

/// What reading a part of a scene gives.
pub(super) type Outcome<T> = Result<T, Fault>;

/// All of some parts, or all that is wrong with them.
pub(super) fn all<T>(parts: impl IntoIterator<Item = Outcome<T>>) -> Outcome<Vec<T>> {
    let (mut found, mut fault) = (Vec::new(), None);
    for part in parts {
        match part {
            Ok(part) => found.push(part),
            Err(one) => fault = Some(one.after(fault)),
        }
    }
    fault.map_or(Ok(found), Err)
}

/// Both parts, or all that is wrong with them.
pub(super) fn both<A, B>(a: Outcome<A>, b: Outcome<B>) -> Outcome<(A, B)> {
    match (a, b) {
        (Ok(a), Ok(b)) => Ok((a, b)),
        (Err(a), Err(b)) => Err(b.after(Some(a))),
        (Err(fault), Ok(_)) | (Ok(_), Err(fault)) => Err(fault),
    }
}

impl Fault {
    pub fn new(place: Place, message: impl Into<String>) -> Self {
        let message = clipped(plain(message.into()));
        Self { message, help: None, label: "here", place, shows: None, more: Vec::new() }
    }

    /// Names the remedy.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(clipped(plain(help.into())));
        self
    }

    /// Says what the marked text is.
    pub fn label(mut self, label: &'static str) -> Self {
        self.label = label;
        self
    }

    /// With what is wrong elsewhere, if anything is.
    pub fn and<T>(self, elsewhere: Outcome<T>) -> Self {
        match elsewhere {
            Ok(_) => self,
            Err(other) => other.after(Some(self)),
        }
    }

    /// As one more fault beside others.
    fn after(self, others: Option<Self>) -> Self {
        let Some(mut first) = others else { return self };
        first.more.push(self);
        first
    }

    /// Makes it that of an override.
    pub fn give_to(&mut self, place: Place) {
        (self.shows, self.place, self.label) = (Some(self.place), place, "here");
    }

    /// Looks at this one and the others.
    pub fn visit(&self, look: &mut impl FnMut(&Fault)) {
        look(self);
        self.more.iter().for_each(|fault| fault.visit(look));
    }

    /// Changes this one and the others.
    pub fn each_mut(&mut self, change: &mut impl FnMut(&mut Fault)) {
        change(self);
        self.more.iter_mut().for_each(|fault| fault.each_mut(change));
    }

    /// Shows the faults in their sources.
    pub fn in_sources(self, sources: &[Source]) -> SceneError {
        let mut faults = Vec::new();
        self.flatten(&mut faults);
        faults.sort_by_key(|fault| (fault.place.source, fault.place.start));
        let all = faults.len();
        let mut letters = 0;
        faults.truncate(MOST);
        faults.retain(|fault| {
            let room = letters <= LETTERS;
            letters += fault.letters(sources);
            room
        });
        let left_out = all - faults.len();
        let texts: Vec<Arc<str>> = sources.iter().map(|source| visible(&source.text).into()).collect();
        let shown = faults.into_iter().map(|fault| fault.shown(sources, &texts));
        let mut errors = shown.collect::<Vec<_>>().into_iter();
        let Some(mut error) = errors.next() else { return SceneError::elsewhere(String::new(), None) };
        error.more = errors.collect();
        if left_out > 0 {
            error.more.push(SceneError::elsewhere(format!("and {left_out} more"), None));
        }
        error
    }

    fn flatten(mut self, into: &mut Vec<Fault>) {
        let more = std::mem::take(&mut self.more);
        into.push(self);
        more.into_iter().for_each(|fault| fault.flatten(into));
    }

    /// About how much of a screen it takes.
    fn letters(&self, sources: &[Source]) -> usize {
        let longest =
            sources.get(self.place.source).map_or(0, |source| source.longest_near(self.place.start));
        let picture = if longest > LONGEST { 0 } else { 4 * longest };
        self.message.len() + self.help.as_ref().map_or(0, String::len) + picture
    }

    fn shown(self, sources: &[Source], texts: &[Arc<str>]) -> SceneError {
        let Self { message, mut help, label, place, shows, .. } = self;
        let Some(source) = sources.get(place.source) else { return SceneError::elsewhere(message, help) };
        if let Some((file, there)) = sources.first().zip(shows) {
            let shows = format!("it shows at {}:{}", file.name, file.line(there.start));
            help = Some(help.map_or_else(|| shows.clone(), |help| format!("{help}; {shows}")));
        }
        let line = (place.source == 0).then(|| source.line(place.start));
        let text = source.text.get(place.start..place.end).unwrap_or_default();
        let length = text.lines().next().unwrap_or_default().len(); // one line is enough to show
        if source.longest_near(place.start) > LONGEST {
            // a picture of it would fill the screen
            let at = line.map_or_else(|| source.name.clone(), |line| format!("{}:{line}", source.name));
            let mut error = SceneError::elsewhere(format!("{at}: {message}"), help);
            error.details.line = line;
            return error;
        }
        let label = LabeledSpan::new(Some(label.into()), place.start, length);
        let text = texts.get(place.source).cloned().unwrap_or_default();
        let source = NamedSource::new(&source.name, text).with_language("TOML");
        let details = Details { message, help, source: Some(source), label: Some(label), line };
        SceneError { details: Box::new(details), more: Vec::new() }
    }
}

/// A text in which control characters are spelled out.
fn plain(text: String) -> String {
    if !text.contains(char::is_control) {
        return text;
    }
    let spelled = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(spelled).collect()
}

/// The text of a source with nothing in it that a terminal would act on, every byte at its place.
fn visible(text: &str) -> String {
    let stand_in = |c: char| match (c, c.len_utf8()) {
        ('\n' | '\t', _) => c,
        (_, 1) if c.is_control() => '?',
        (_, 2) if c.is_control() => '·',
        // these turn the direction of what stands behind them
        ('\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}', _) => '\u{fffd}',
        _ => c,
    };
    let unix = text.replace("\r\n", " \n");
    unix.chars().map(stand_in).collect()
}

/// A text that is too long to read without its middle.
fn clipped(text: String) -> String {
    if text.len() <= LONGEST {
        return text;
    }
    let (begin, end) =
        (text.floor_char_boundary(LONGEST / 2), text.ceil_char_boundary(text.len() - LONGEST / 4));
    format!("{} … {}", &text[..begin], &text[end..])
}

/// "did you mean ...?", or all the words that there are.
pub(super) fn suggestion<'a>(wrong: &str, words: impl IntoIterator<Item = &'a str>) -> String {
    let words: Vec<_> = words.into_iter().take(MOST_WORDS).collect();
    // nobody mistypes so much, and the distance takes work and memory for every letter
    let short = wrong.len() <= LONGEST_WORD;
    let nearest = words
        .iter()
        .filter(|_| short)
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
