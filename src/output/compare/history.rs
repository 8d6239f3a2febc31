//! Two `history.csv`, row by row.
use super::{Tolerances, tolerated};
use crate::output::history::entries;

/// The first cell in which two histories differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Row, counted from 1 below the header.
    pub row: usize,
    /// Steps taken, as the first history says.
    pub step: String,
    /// Header of the column; empty if a row is missing.
    pub column: String,
    /// On both sides; empty where a row is missing.
    pub values: [String; 2],
}

/// What a comparison found.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Comparison {
    /// Rows that both have.
    pub rows: usize,
    /// Columns of the first.
    pub columns: Vec<String>,
    /// The first difference that is not allowed.
    pub first: Option<Cell>,
}

/// Compares the texts of two files. Tolerances for `history` hold for all columns, relative to a column's largest value.
pub fn compare(one: &str, other: &str, tolerances: &Tolerances) -> Comparison {
    let [one, other] = [one, other].map(entries);
    let columns = one.first().cloned().unwrap_or_default();
    let allowed: Vec<_> = (0..columns.len()).map(|c| allowed(&one, &columns[c], c, tolerances)).collect();
    let rows = one.len().min(other.len()).saturating_sub(1);
    let mut found = Comparison { rows, columns, first: None };
    for row in 0..one.len().max(other.len()) {
        let empty = Vec::new();
        let [a, b] = [&one, &other].map(|table| table.get(row).unwrap_or(&empty));
        let differing = (0..a.len().max(b.len())).find(|&c| {
            let values = [a, b].map(|cells| cells.get(c).map_or("", String::as_str));
            !same(values, allowed.get(c).copied().flatten())
        });
        if let Some(c) = differing {
            let missing = a.is_empty() || b.is_empty();
            let cell = |cells: &[String]| cells.get(c).filter(|_| !missing).cloned().unwrap_or_default();
            let step = [a, b].iter().find_map(|cells| cells.get(1).cloned()).unwrap_or_default();
            let column = found.columns.get(c).filter(|_| !missing).cloned().unwrap_or_default();
            found.first = Some(Cell { row, step, column, values: [cell(a), cell(b)] });
            return found;
        }
    }
    found
}

fn allowed(table: &[Vec<String>], column: &str, at: usize, tolerances: &Tolerances) -> Option<f64> {
    let numbers = table.iter().skip(1).filter_map(|row| row.get(at)?.parse::<f64>().ok());
    let largest = numbers.fold(0.0, |most: f64, x| most.max(x.abs()));
    let own = tolerances.absolute.get(column).copied();
    let all = tolerances.absolute.get("history").map(|relative| relative * largest);
    own.or(all).or_else(|| tolerances.allowed(column, largest))
}

fn same([a, b]: [&str; 2], allowed: Option<f64>) -> bool {
    a == b
        || allowed.is_some_and(|_| match (a.parse(), b.parse()) {
            (Ok(a), Ok(b)) => tolerated([a, b], allowed),
            _ => false,
        })
}
