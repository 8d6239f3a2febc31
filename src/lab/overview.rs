//! What one looks at first of a run's history: where its energy is and goes, and forces over the ways of what pulls and presses.
use super::figure::axis::Quantity;
use super::plot::{Line, Plot};
use crate::output::history::Table;

/// Where energy is, and what comes from outside: parts of materials end in `.NAME_j`.
const HELD: [&str; 3] = ["kinetic", "strain", "boundary_work"];
/// Where it goes.
const SPENT: [&str; 7] = ["plastic", "fracture", "viscosity", "friction", "impact", "transfer", "residual"];
/// A part that never exceeds this share of the largest of a plot is not drawn; the residual always is.
const SMALL: f64 = 1e-3;
/// More forces than these are too many for one plot.
const MOST: usize = 7;

/// The plots, as far as the history has what they show.
pub fn plots(table: &Table, title: &str) -> Vec<Plot> {
    let held = energies(table, &HELD, title);
    let spent = energies(table, &SPENT, "Energy spent, and what the balance does not explain");
    [held, spent, forces(table)].into_iter().flatten().collect()
}

fn energies(table: &Table, names: &[&'static str], title: &str) -> Option<Plot> {
    let time = table.column("time_s")?;
    // of the whole run, or the sum over materials
    let sum = |part: &str| {
        let (whole, end) = (format!("{part}_j"), format!(".{part}_j"));
        let columns = table.header.iter().filter(|header| **header == whole || header.ends_with(&end));
        let columns = columns.filter_map(|header| table.column(header));
        columns.reduce(|a, b| a.iter().zip(b).map(|(a, b)| a + b).collect())
    };
    let parts: Vec<(&str, Vec<f64>)> = names.iter().filter_map(|part| Some((*part, sum(part)?))).collect();
    let largest = |numbers: &[f64]| numbers.iter().map(|x| x.abs()).fold(0.0, f64::max);
    let most = parts.iter().map(|(_, numbers)| largest(numbers)).fold(0.0, f64::max);
    let shown = |(name, numbers): &&(&str, Vec<f64>)| *name == "residual" || largest(numbers) > SMALL * most;
    let line = |(name, numbers): &(&str, Vec<f64>)| Line {
        name: name.replace('_', " "),
        points: time.iter().zip(numbers).map(|(t, e)| [*t, *e]).collect(),
    };
    Some(Plot {
        title: title.to_owned(),
        axes: [Quantity::of_column("time_s"), Quantity { words: "energy".into(), unit: "J".into() }],
        log: [false; 2],
        marks: false,
        lines: parts.iter().filter(shown).map(line).collect(),
    })
}

/// Forces of drives and tools that move, along the axis on which they do so most, over their way.
fn forces(table: &Table) -> Option<Plot> {
    let givers = table.header.iter().filter_map(|header| header.strip_suffix(".force_x_n"));
    let mut lines: Vec<Line> = givers.filter_map(|giver| force(table, giver)).collect();
    lines.truncate(MOST);
    if lines.is_empty() {
        return None;
    }
    let [along, up] = ["displacement", "force on the matter"].map(str::to_owned);
    Some(Plot {
        title: "Forces over displacements".to_owned(),
        axes: [Quantity { words: along, unit: "m".into() }, Quantity { words: up, unit: "N".into() }],
        log: [false; 2],
        marks: false,
        lines,
    })
}

fn force(table: &Table, giver: &str) -> Option<Line> {
    // the way of a rigid body stands under its material's name
    let mover = giver.strip_prefix("rigid.").unwrap_or(giver);
    let way = |axis: &str| table.column(&format!("{mover}.displacement_{axis}_m"));
    let longest =
        |numbers: &[f64]| numbers.iter().filter(|x| x.is_finite()).map(|x| x.abs()).fold(0.0, f64::max);
    let ways = ["x", "y", "z"].map(|axis| way(axis).map(|way| (axis, longest(&way), way)));
    let (axis, most, way) = ways.into_iter().flatten().max_by(|a, b| a.1.total_cmp(&b.1))?;
    if most == 0.0 {
        return None;
    }
    let force = table.column(&format!("{giver}.force_{axis}_n"))?;
    Some(Line {
        name: format!("{giver} along {axis}"),
        points: way.into_iter().zip(force).map(|(x, f)| [x, f]).collect(),
    })
}
