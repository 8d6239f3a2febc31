//! Measured rows and predictions as text and CSV.
use super::row::Row;
use super::series::Point;
use super::validate::Check;

/// Columns of measured rows, as CSV and table name them.
const COLUMNS: [(&str, &str); 18] = [
    ("patches", "patches"),
    ("threads", "threads"),
    ("ranks", "ranks"),
    ("particles", "particles"),
    ("step_best_ms", "ms/step"),
    ("step_median_ms", "median"),
    ("updates_per_s", "M upd/s"),
    ("efficiency", "effic."),
    ("over_decomposition", "cuts %"),
    ("overhead_ms", "engine ms"),
    ("bytes_a_rank", "kB/rank"),
    ("messages_a_rank", "msg/rank"),
    ("halo_share", "halo %"),
    ("wait_share", "wait %"),
    ("idle_share", "idle %"),
    ("imbalance", "imbal."),
    ("peak_bytes", "peak MB"),
    ("state_hash", "state"),
];

/// The cells of a row as numbers that lose nothing.
fn exact(row: &Row) -> Vec<String> {
    let p = &row.parts;
    let mut cells: Vec<String> = [row.patches, row.threads, row.ranks].map(|n| n.to_string()).into();
    cells.push(row.particles.to_string());
    let numbers = [
        row.step_ms[0],
        row.step_ms[1],
        row.updates_per_s,
        row.efficiency,
        row.over_decomposition,
        p.overhead_ms,
        p.bytes,
        p.messages,
        p.halo_share,
        p.wait_share,
        p.idle_share,
        p.imbalance,
    ];
    cells.extend(numbers.map(|x| x.to_string()));
    cells.extend([row.peak_bytes.to_string(), row.state_hash.clone()]);
    cells
}

/// The same for people.
fn rounded(row: &Row) -> Vec<String> {
    let p = &row.parts;
    let percent = |x: f64| format!("{:.1}", 100.0 * x);
    let mut cells: Vec<String> = [row.patches, row.threads, row.ranks].map(|n| n.to_string()).into();
    cells.extend([
        row.particles.to_string(),
        format!("{:.3}", row.step_ms[0]),
        format!("{:.3}", row.step_ms[1]),
        format!("{:.2}", 1e-6 * row.updates_per_s),
        format!("{:.3}", row.efficiency),
        percent(row.over_decomposition),
        format!("{:.3}", p.overhead_ms),
        format!("{:.1}", 1e-3 * p.bytes),
        format!("{:.1}", p.messages),
        percent(p.halo_share),
        percent(p.wait_share),
        percent(p.idle_share),
        format!("{:.2}", p.imbalance),
        format!("{:.0}", 1e-6 * row.peak_bytes as f64),
        row.state_hash.clone(),
    ]);
    cells
}

/// The measured rows as CSV, errors in the last column.
pub fn csv(rows: &[Row]) -> String {
    let names: Vec<&str> = COLUMNS.iter().map(|(name, _)| *name).chain(["error"]).collect();
    let mut out = names.join(",") + "\n";
    for row in rows {
        let mut cells = exact(row);
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
    let mut lines = vec![COLUMNS.map(|(_, name)| name.to_owned()).to_vec()];
    lines.extend(rows.iter().map(|row| match &row.error {
        None => rounded(row),
        Some(_) => rounded(row)[..3].to_vec(),
    }));
    let mut out = String::new();
    for (n, line) in aligned(&lines).into_iter().enumerate() {
        let error = n.checked_sub(1).and_then(|n| rows[n].error.as_ref());
        out += &line;
        out += &error.map_or(String::new(), |error| format!("  failed: {error}"));
        out += "\n";
    }
    out
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

const PREDICTED: [&str; 12] = [
    "ranks",
    "workers",
    "particles",
    "ms/step",
    "effic.",
    "compute %",
    "engine %",
    "halo %",
    "travel %",
    "reduce %",
    "imbal.",
    "limited by",
];

/// Predictions as a table.
pub fn predicted(points: &[Point]) -> String {
    let mut lines = vec![PREDICTED.map(str::to_owned).to_vec()];
    lines.extend(points.iter().map(|point| {
        let percent = |x: f64| format!("{:.1}", 100.0 * x);
        let s = &point.shares;
        vec![
            point.ranks.to_string(),
            point.workers.to_string(),
            format!("{:.4e}", point.particles),
            format!("{:.4}", point.step_ms),
            format!("{:.3}", point.efficiency),
            percent(s.compute),
            percent(s.engine),
            percent(s.halo),
            percent(s.travel),
            percent(s.reduction),
            format!("{:.2}", point.imbalance),
            point.limited_by.clone(),
        ]
    }));
    aligned(&lines).join("\n") + "\n"
}

/// Predictions as CSV.
pub fn predicted_csv(strong: &[Point], weak: &[Point]) -> String {
    let mut out = "scaling,ranks,workers,particles,step_ms,efficiency,compute_share,engine_share,halo_share,\
                   travel_share,reduction_share,imbalance,limited_by\n"
        .to_owned();
    for (kind, point) in strong.iter().map(|p| ("strong", p)).chain(weak.iter().map(|p| ("weak", p))) {
        let s = &point.shares;
        let numbers = [
            point.particles,
            point.step_ms,
            point.efficiency,
            s.compute,
            s.engine,
            s.halo,
            s.travel,
            s.reduction,
            point.imbalance,
        ];
        let numbers = numbers.map(|x| x.to_string()).join(",");
        out += &format!("{kind},{},{},{numbers},{}\n", point.ranks, point.workers, quoted(&point.limited_by));
    }
    out
}

/// The model against measured rows.
pub fn checks(checks: &[Check]) -> String {
    let mut lines = vec![
        [
            "patches",
            "threads",
            "ranks",
            "measured ms",
            "model ms",
            "error %",
            "measured kB/rank",
            "model kB/rank",
            "",
        ]
        .map(str::to_owned)
        .to_vec(),
    ];
    lines.extend(checks.iter().map(|check| {
        vec![
            check.patches.to_string(),
            check.threads.to_string(),
            check.ranks.to_string(),
            format!("{:.3}", check.measured_ms),
            format!("{:.3}", check.model_ms),
            format!("{:+.1}", 100.0 * check.error),
            format!("{:.1}", 1e-3 * check.measured_bytes),
            format!("{:.1}", 1e-3 * check.model_bytes),
            if check.fitted { "fitted" } else { "" }.to_owned(),
        ]
    }));
    aligned(&lines).join("\n") + "\n"
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
