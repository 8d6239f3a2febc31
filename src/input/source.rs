//! Where the text of a scene comes from, and places in it.
use std::ops::Range;

/// A text that values come from: source 0 is the scene file, the others are overrides `key=value`.
pub(super) struct Source {
    pub name: String,
    pub text: String,
}

impl Source {
    /// The 1-based line of a byte.
    pub fn line(&self, byte: usize) -> usize {
        1 + self.text.bytes().take(byte).filter(|&b| b == b'\n').count()
    }
}

/// A range of bytes in a source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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
