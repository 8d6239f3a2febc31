//! Where the text of a scene comes from, and places in it.
use std::ops::Range;

/// A text that values come from: source 0 is the scene file, the others are overrides `key=value`.
pub(super) struct Source {
    pub name: String,
    pub text: String,
    /// Where lines begin.
    lines: Vec<usize>,
}

impl Source {
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Self {
        let text = text.into();
        let after = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1);
        let lines = std::iter::once(0).chain(after).collect();
        Self { name: name.into(), text, lines }
    }

    /// The 1-based line of a byte.
    pub fn line(&self, byte: usize) -> usize {
        self.lines.partition_point(|&begin| begin <= byte)
    }

    /// Bytes of the longest line at a byte, or beside that.
    pub fn longest_near(&self, byte: usize) -> usize {
        let line = self.line(byte);
        let end = |line: usize| self.lines.get(line).copied().unwrap_or(self.text.len());
        let length = |line: usize| end(line) - self.lines[line - 1];
        (line.saturating_sub(1).max(1)..=(line + 1).min(self.lines.len())).map(length).max().unwrap_or(0)
    }
}

/// A range of bytes in a source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Place {
    pub source: usize,
    pub start: usize,
    pub end: usize,
}

impl Place {
    pub fn new(source: usize, span: Range<usize>) -> Self {
        Self { source, start: span.start, end: span.end }
    }
}
