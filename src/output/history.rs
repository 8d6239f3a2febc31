//! `history.csv`: a row every few steps, for people with a spreadsheet and for plots.
use super::create::{create, write_whole};
use super::error::{Result, io};
use super::plain;
use std::borrow::Cow;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use twox_hash::XxHash3_128;

/// What a column holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// What, with the material if it is one material's: `tissue.kinetic`.
    pub name: String,
    /// Unit as it is spelled in a name, `m_s` for m/s; empty for counts and words.
    pub unit: Cow<'static, str>,
}

impl Column {
    /// A quantity of the whole run.
    pub fn global(name: &str, unit: &'static str) -> Self {
        Self { name: name.into(), unit: unit.into() }
    }

    /// A quantity of one material.
    pub fn of(material: &str, name: &str, unit: &'static str) -> Self {
        Self { name: format!("{material}.{name}"), unit: unit.into() }
    }

    /// The header: `tissue.kinetic_j`.
    pub fn header(&self) -> String {
        let separator = if self.unit.is_empty() { "" } else { "_" };
        format!("{}{separator}{}", self.name, self.unit)
    }
}

/// An entry of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cell<'a> {
    /// In the column's unit; written so that it reads back the same bits. NaN is an empty cell.
    Number(f64),
    /// A count.
    Count(u64),
    /// For example what limits the step.
    Text(&'a str),
}

impl From<f64> for Cell<'_> {
    fn from(number: f64) -> Self {
        Cell::Number(number)
    }
}

impl From<u64> for Cell<'_> {
    fn from(count: u64) -> Self {
        Cell::Count(count)
    }
}

impl<'a> From<&'a str> for Cell<'a> {
    fn from(text: &'a str) -> Self {
        Cell::Text(text)
    }
}

impl Cell<'_> {
    fn text(&self) -> String {
        match *self {
            Cell::Number(x) if x.is_nan() => String::new(),
            Cell::Number(x) if x != 0.0 && !(1e-3..1e6).contains(&x.abs()) => format!("{x:e}"),
            Cell::Number(x) => x.to_string(),
            Cell::Count(n) => n.to_string(),
            Cell::Text(text) => quoted(text),
        }
    }
}

/// A comma, a quote or a line break inside an entry needs quotes around it (RFC 4180).
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        return format!("\"{}\"", text.replace('"', "\"\""));
    }
    text.into()
}

/// A table that was written: its header, and its rows as they stand.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// Names with units.
    pub header: Vec<String>,
    /// One entry a column.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a file; half a row at its end is passed over.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(path: &Path) -> Result<Self> {
        let text = plain::read(path)?;
        let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
        let mut rows = entries(whole).into_iter();
        let header = rows.next().unwrap_or_default();
        Ok(Self { rows: rows.filter(|row| row.len() == header.len()).collect(), header })
    }

    /// A column as numbers, NaN where an entry is none; `None`: there is none of that name.
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        let at = self.header.iter().position(|header| header == name)?;
        Some(self.rows.iter().map(|row| row[at].parse().unwrap_or(f64::NAN)).collect())
    }
}

/// The entries of a text, row by row (RFC 4180).
pub(super) fn entries(text: &str) -> Vec<Vec<String>> {
    let (mut rows, mut row, mut entry, mut quotes) = (Vec::new(), Vec::new(), String::new(), false);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '"' if quotes && rest.peek() == Some(&'"') => entry.extend(rest.next()),
            '"' => quotes = !quotes,
            ',' if !quotes => row.push(std::mem::take(&mut entry)),
            '\n' if !quotes => {
                row.push(std::mem::take(&mut entry));
                rows.push(std::mem::take(&mut row));
            }
            '\r' if !quotes => {}
            _ => entry.push(c),
        }
    }
    if !(row.is_empty() && entry.is_empty()) {
        row.push(entry);
        rows.push(row);
    }
    rows
}

struct Digest(XxHash3_128);

impl Digest {
    fn value(&self) -> u64 {
        self.0.finish_128() as u64
    }
}

impl std::fmt::Debug for Digest {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{:016x}", self.value())
    }
}

/// Writes `history.csv` row by row; each row is on the disk when [`History::row`] returns.
#[derive(Debug)]
pub struct History {
    path: PathBuf,
    file: BufWriter<File>,
    columns: usize,
    /// Of all that is written.
    digest: Digest,
    /// Its value before the last row, and after it.
    digests: [u64; 2],
}

impl History {
    /// A new file with its header; an old one of that name is overwritten.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(path: &Path, columns: &[Column]) -> Result<Self> {
        let file = create(path)?;
        let mut history = Self::on(path, file, columns.len(), "");
        history.line(columns.iter().map(|column| quoted(&column.header())))?;
        Ok(history)
    }

    /// Goes on with a file after a restart: keeps the rows whose first column, the time [s], is at most `time`. Whoever
    /// looks sees the old file or the new one, never half of one.
    ///
    /// # Errors
    /// If the file cannot be read or written, or is damaged.
    pub fn resume(path: &Path, columns: &[Column], time: f64) -> Result<Self> {
        let old = plain::read(path)?;
        let header = columns.iter().map(|column| quoted(&column.header())).collect::<Vec<_>>().join(",");
        let early = |line: &&str| {
            // a run that was killed may have left half a row
            let first = line.ends_with('\n').then(|| line.split(',').next()).flatten();
            first.and_then(|t| t.parse().ok()).is_some_and(|t: f64| t <= time)
        };
        let rows = old.split_inclusive('\n').skip(1).filter(early);
        let text = format!("{header}\n{}", rows.collect::<String>());
        write_whole(path, text.as_bytes())?;
        let file = File::options().append(true).open(path).map_err(io("open", path))?;
        Ok(Self::on(path, file, columns.len(), &text))
    }

    fn on(path: &Path, file: File, columns: usize, text: &str) -> Self {
        let mut digest = Digest(XxHash3_128::new());
        digest.0.write(text.as_bytes());
        let digests = [digest.value(); 2];
        Self { path: path.into(), file: BufWriter::new(file), columns, digest, digests }
    }

    /// Digests of what it holds but for the last row, and of all.
    pub fn digests(&self) -> [u64; 2] {
        self.digests
    }

    /// Whether what has its name is still this file.
    pub fn is_in_place(&self) -> bool {
        is_same(self.file.get_ref(), &self.path)
    }

    /// Waits until the disk has all rows.
    ///
    /// # Errors
    /// If it does not take them.
    pub fn sync(&self) -> Result<()> {
        self.file.get_ref().sync_data().map_err(io("write", &self.path))
    }

    /// A row whose columns between the first and the last ones are empty.
    ///
    /// # Errors
    /// As [`History::row`].
    pub fn row_of_ends(&mut self, first: &[Cell], last: &[Cell]) -> Result<()> {
        let between = self.columns.saturating_sub(first.len() + last.len());
        let empty = vec![Cell::Number(f64::NAN); between];
        self.row(&[first, &empty, last].concat())
    }

    /// Writes a row: one cell a column, in the order of the columns.
    ///
    /// # Errors
    /// If the disk is full.
    pub fn row(&mut self, cells: &[Cell]) -> Result<()> {
        debug_assert_eq!(cells.len(), self.columns, "a row has one cell a column");
        self.line(cells.iter().map(Cell::text))
    }

    fn line(&mut self, cells: impl Iterator<Item = String>) -> Result<()> {
        let line = cells.collect::<Vec<_>>().join(",");
        writeln!(self.file, "{line}").and_then(|()| self.file.flush()).map_err(io("write", &self.path))?;
        self.digest.0.write(line.as_bytes());
        self.digest.0.write(b"\n");
        self.digests = [self.digests[1], self.digest.value()];
        Ok(())
    }
}

#[cfg(unix)]
fn is_same(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let number = |found: std::fs::Metadata| (found.dev(), found.ino());
    file.metadata().ok().map(number) == std::fs::metadata(path).ok().map(number)
}

#[cfg(not(unix))]
fn is_same(_: &File, path: &Path) -> bool {
    path.is_file()
}
