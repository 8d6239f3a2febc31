//! Measured rows and predictions as text and CSV.
use super::row::Row;
use super::series::Point;
use super::validate::Check;

/// A cell of a table.
enum Cell {
    /// As it is.
    Text(String),
    /// For people times a factor, with so many digits.
    Number(f64, f64, usize),
    /// For people with a power of ten.
    Large(f64),
}

impl Cell {
    /// All that is known.
    fn exact(&self) -> String {
        match self {
            Self::Text(text) => quoted(text),
            Self::Number(x, ..) | Self::Large(x) => x.to_string(),
        }
    }

    /// For people.
    fn rounded(&self) -> String {
        match self {
            Self::Text(text) => text.clone(),
            Self::Number(x, factor, digits) => format!("{:.digits$}", factor * x),
            Self::Large(x) => format!("{x:.4e}"),
        }
    }
}

fn count(n: usize) -> Cell {
    Cell::Text(n.to_string())
}

fn percent(x: f64) -> Cell {
    Cell::Number(x, 100.0, 1)
}

/// A column: its name in CSV, its title, and its cells.
type Column<T> = (&'static str, &'static str, fn(&T) -> Cell);

const MEASURED: [Column<Row>; 18] = [
    ("patches", "patches", |row| count(row.patches)),
    ("threads", "threads", |row| count(row.threads)),
    ("ranks", "ranks", |row| count(row.ranks)),
    ("particles", "particles", |row| Cell::Text(row.particles.to_string())),
    ("step_best_ms", "ms/step", |row| Cell::Number(row.step_ms[0], 1.0, 3)),
    ("step_median_ms", "median", |row| Cell::Number(row.step_ms[1], 1.0, 3)),
    ("updates_per_s", "M upd/s", |row| Cell::Number(row.updates_per_s, 1e-6, 2)),
    ("efficiency", "effic.", |row| Cell::Number(row.efficiency, 1.0, 3)),
    ("over_decomposition", "cuts %", |row| percent(row.over_decomposition)),
    ("overhead_ms", "engine ms", |row| Cell::Number(row.parts.overhead_ms, 1.0, 3)),
    ("bytes_a_rank", "kB/rank", |row| Cell::Number(row.parts.bytes, 1e-3, 1)),
    ("messages_a_rank", "msg/rank", |row| Cell::Number(row.parts.messages, 1.0, 1)),
    ("halo_share", "halo %", |row| percent(row.parts.halo_share)),
    ("wait_share", "wait %", |row| percent(row.parts.wait_share)),
    ("idle_share", "idle %", |row| percent(row.parts.idle_share)),
    ("imbalance", "imbal.", |row| Cell::Number(row.parts.imbalance, 1.0, 2)),
    ("peak_bytes", "peak MB", |row| Cell::Number(row.peak_bytes as f64, 1e-6, 0)),
    ("state_hash", "state", |row| Cell::Text(row.state_hash.clone())),
];

const PREDICTED: [Column<Point>; 12] = [
    ("ranks", "ranks", |point| count(point.ranks)),
    ("workers", "workers", |point| count(point.workers)),
    ("particles", "particles", |point| Cell::Large(point.particles)),
    ("step_ms", "ms/step", |point| Cell::Number(point.step_ms, 1.0, 4)),
    ("efficiency", "effic.", |point| Cell::Number(point.efficiency, 1.0, 3)),
    ("compute_share", "compute %", |point| percent(point.shares.compute)),
    ("engine_share", "engine %", |point| percent(point.shares.engine)),
    ("halo_share", "halo %", |point| percent(point.shares.halo)),
    ("travel_share", "travel %", |point| percent(point.shares.travel)),
    ("reduction_share", "reduce %", |point| percent(point.shares.reduction)),
    ("imbalance", "imbal.", |point| Cell::Number(point.imbalance, 1.0, 2)),
    ("limited_by", "limited by", |point| Cell::Text(point.limited_by.clone())),
];

const CHECKED: [Column<Check>; 9] = [
    ("", "patches", |check| count(check.patches)),
    ("", "threads", |check| count(check.threads)),
    ("", "ranks", |check| count(check.ranks)),
    ("", "measured ms", |check| Cell::Number(check.measured_ms, 1.0, 3)),
    ("", "model ms", |check| Cell::Number(check.model_ms, 1.0, 3)),
    ("", "error %", |check| Cell::Text(format!("{:+.1}", 100.0 * check.error))),
    ("", "measured kB/rank", |check| Cell::Number(check.measured_bytes, 1e-3, 1)),
    ("", "model kB/rank", |check| Cell::Number(check.model_bytes, 1e-3, 1)),
    ("", "", |check| Cell::Text(if check.fitted { "fitted" } else { "" }.to_owned())),
];

/// Names of columns in CSV.
fn names<T>(columns: &[Column<T>]) -> String {
    columns.iter().map(|(name, ..)| *name).collect::<Vec<_>>().join(",")
}

fn exact<T>(columns: &[Column<T>], row: &T) -> Vec<String> {
    columns.iter().map(|(.., cell)| cell(row).exact()).collect()
}

/// Titles and rows for people, of the rows as many cells as `whole` says.
fn lines<T>(columns: &[Column<T>], rows: &[T], whole: impl Fn(&T) -> usize) -> Vec<String> {
    let titles = columns.iter().map(|(_, title, _)| (*title).to_owned()).collect();
    let cells = |row: &T| columns[..whole(row)].iter().map(|(.., cell)| cell(row).rounded()).collect();
    aligned(&[titles].into_iter().chain(rows.iter().map(cells)).collect::<Vec<_>>())
}

/// The measured rows as CSV, errors in the last column.
pub fn csv(rows: &[Row]) -> String {
    let mut out = names(&MEASURED) + ",error\n";
    for row in rows {
        let mut cells = exact(&MEASURED, row);
        if row.error.is_some() {
            cells[3..].fill(String::new());
        }
        cells.push(quoted(row.error.as_deref().unwrap_or("")));
        out += &(cells.join(",") + "\n");
    }
    out
}

/// A text as a CSV cell (RFC 4180).
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// The measured rows as a table.
pub fn text(rows: &[Row]) -> String {
    let whole = |row: &Row| if row.error.is_none() { MEASURED.len() } else { 3 };
    let errors = [None].into_iter().chain(rows.iter().map(|row| row.error.as_ref()));
    let error = |error: Option<&String>| error.map_or(String::new(), |error| format!("  failed: {error}"));
    lines(&MEASURED, rows, whole).into_iter().zip(errors).map(|(line, it)| line + &error(it) + "\n").collect()
}

/// Cells in columns, to the right.
fn aligned(lines: &[Vec<String>]) -> Vec<String> {
    let width =
        |i: usize| lines.iter().filter_map(|l| l.get(i)).map(|c| c.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..lines.iter().map(Vec::len).max().unwrap_or(0)).map(width).collect();
    let line = |cells: &Vec<String>| {
        let cells: Vec<String> =
            cells.iter().zip(&widths).map(|(cell, &width)| format!("{cell:>width$}")).collect();
        cells.join("  ")
    };
    lines.iter().map(line).collect()
}

/// Predictions as a table.
pub fn predicted(points: &[Point]) -> String {
    lines(&PREDICTED, points, |_| PREDICTED.len()).join("\n") + "\n"
}

/// Predictions as CSV.
pub fn predicted_csv(strong: &[Point], weak: &[Point]) -> String {
    let kinds = strong.iter().map(|point| ("strong", point)).chain(weak.iter().map(|point| ("weak", point)));
    let rows = kinds.map(|(kind, point)| format!("{kind},{}\n", exact(&PREDICTED, point).join(",")));
    format!("scaling,{}\n", names(&PREDICTED)) + &rows.collect::<String>()
}

/// The model against measured rows.
pub fn checks(checks: &[Check]) -> String {
    lines(&CHECKED, checks, |_| CHECKED.len()).join("\n") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_of_the_csv_has_all_columns_and_errors_are_quoted() {
        let good = Row { patches: 8, threads: 1, ranks: 2, step_ms: [1.5, 2.0], ..Row::default() };
        let bad =
            Row { patches: 1, threads: 1, ranks: 2, error: Some("no, \"never\"".into()), ..Row::default() };
        let csv = csv(&[good.clone(), bad.clone()]);
        let lines: Vec<&str> = csv.lines().collect();
        assert_eq!(lines.len(), 3);
        assert!(
            lines[0].starts_with("patches,threads,ranks,particles,step_best_ms")
                && lines[0].ends_with(",error")
        );
        let commas = |line: &str| line.matches(',').count();
        assert_eq!(commas(lines[1]), commas(lines[0]));
        assert_eq!(commas(lines[2]), commas(lines[0]) + 1, "one is in the error");
        assert!(lines[1].starts_with("8,1,2,0,1.5,2,"));
        assert!(lines[2].ends_with("\"no, \"\"never\"\"\""));
        let text = text(&[good, bad]);
        assert!(text.lines().nth(2).is_some_and(|line| line.ends_with("failed: no, \"never\"")), "{text}");
    }
}
