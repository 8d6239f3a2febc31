//! Rows of `history.csv`.
use crate::output::frame::part_names;
use crate::output::history::{Cell, Column};
use crate::simulation::failures;
use crate::simulation::report::{MaterialReport, Report};
use scene::Scene;
use scene::shown::Probe;
use tasks::recipes::{Giver, Givers};

/// The columns of a scene.
pub fn columns(scene: &Scene) -> Vec<Column> {
    let mut columns = vec![
        Column::global("time", "s"),
        Column::global("step", ""),
        Column::global("step_size", "s"),
        Column::global("limited_by", ""),
    ];
    for material in &scene.materials {
        let counts: Vec<&str> = material.counted().map(|(name, _)| name).collect();
        material_columns(&material.name, &counts, &mut columns);
        if material.is_rigid() {
            rigid_columns(&material.name, &mut columns);
        }
    }
    for part in ["friction", "impact", "transfer", "half_step", "boundary_work", "deleted", "residual"] {
        columns.push(Column::global(part, "j"));
    }
    columns.push(Column::global("deleted_particles", ""));
    for giver in Givers::of(scene).0 {
        giver_columns(&giver.name(scene), giver, &mut columns);
    }
    scene.probes.iter().for_each(|probe| probe_columns(probe, &mut columns));
    columns
}

/// The columns of what gives something to the matter; contacts do no work that is not in accounts of their own.
fn giver_columns(name: &str, giver: Giver, columns: &mut Vec<Column>) {
    for axis in ["x", "y", "z"] {
        columns.push(Column::of(name, &format!("force_{axis}"), "n"));
    }
    for axis in ["x", "y", "z"] {
        columns.push(Column::of(name, &format!("torque_{axis}"), "n_m"));
    }
    if giver.is_outside() {
        columns.push(Column::of(name, "work", "j"));
    }
    if let Giver::Drive(_) = giver {
        columns.extend(["x", "y", "z"].map(|axis| Column::of(name, &format!("displacement_{axis}"), "m")));
    }
}

/// The columns of a probe.
fn probe_columns(probe: &Probe, columns: &mut Vec<Column>) {
    let (name, shown) = (format!("probe.{}", probe.name), &probe.shown);
    // as the units of other columns are spelled: m_s for m/s
    let unit = if shown.unit == "1" {
        String::new()
    } else {
        shown.unit.to_lowercase().replace('/', "_").replace('^', "")
    };
    let parts = part_names(shown.components).iter();
    let names = parts.map(|part| format!("{}{}{part}", shown.name, if part.is_empty() { "" } else { "_" }));
    columns.extend(names.map(|what| Column { name: format!("{name}.{what}"), unit: unit.clone().into() }));
}

/// The columns of a material whose law counts these states. Those of failure are always there, zero where the law does not
/// know it.
fn material_columns(material: &str, counts: &[&str], columns: &mut Vec<Column>) {
    let mut add = |name: &str, unit| columns.push(Column::of(material, name, unit));
    for part in ["kinetic", "strain", "plastic", "fracture", "viscosity"] {
        add(part, "j");
    }
    for axis in ["x", "y", "z"] {
        add(&format!("mean_velocity_{axis}"), "m_s");
    }
    for axis in ["x", "y", "z"] {
        add(&format!("center_{axis}"), "m");
    }
    for state in failures::STATES {
        add(&format!("failed_{state}"), "");
    }
    for state in counts.iter().filter(|state| !failures::is_one(state)) {
        add(&format!("count_{state}"), "");
    }
}

/// The columns of a rigid body.
fn rigid_columns(material: &str, columns: &mut Vec<Column>) {
    for (what, unit) in [("displacement", "m"), ("angular_velocity", "rad_s")] {
        columns.extend(["x", "y", "z"].map(|axis| Column::of(material, &format!("{what}_{axis}"), unit)));
    }
}

/// What a report says in these columns.
pub fn cells(report: &Report) -> Vec<Cell<'_>> {
    let limit = report.limited_by.as_str();
    let mut cells: Vec<Cell<'_>> =
        vec![report.time.into(), report.steps.into(), report.step.into(), limit.into()];
    report.materials.iter().for_each(|m| material_cells(m, &mut cells));
    let parts = [
        report.friction,
        report.impact,
        report.transfer,
        report.half_step,
        report.boundary_work,
        report.deleted_energy,
        report.residual,
    ];
    cells.extend(parts.map(Cell::from));
    cells.push(report.deleted.into());
    for it in &report.givers {
        cells.extend(it.force.into_iter().chain(it.torque).map(Cell::from));
        cells.extend(it.giver.is_outside().then_some(Cell::from(it.work)));
        cells.extend(it.displacement.into_iter().flatten().map(Cell::from));
    }
    cells.extend(report.probes.iter().copied().map(Cell::from));
    cells
}

/// Of the `values` of all probes those of `numbers`; the others are empty.
pub fn probe_cells(scene: &Scene, values: &[f64], numbers: &[usize]) -> Vec<Cell<'static>> {
    let of = scene.probes.iter().enumerate().flat_map(|(number, probe)| vec![number; probe.shown.components]);
    let cell = |(probe, x): (usize, &f64)| Cell::Number(if numbers.contains(&probe) { *x } else { f64::NAN });
    of.zip(values).map(cell).collect()
}

fn material_cells(m: &MaterialReport, cells: &mut Vec<Cell<'_>>) {
    let e = &m.energies;
    cells.extend([e.kinetic, e.strain, e.plastic, e.fracture, e.viscous].map(Cell::from));
    cells.extend(m.velocity().map(Cell::from));
    cells.extend(m.center.map(Cell::from));
    cells.extend(failures::STATES.map(|state| Cell::from(m.count(state))));
    let others = m.counts.iter().filter(|(state, _)| !failures::is_one(state));
    cells.extend(others.map(|&(_, count)| Cell::from(count)));
    cells.extend(m.rigid.into_iter().flatten().flatten().map(Cell::from));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_s_own_counts_follow_those_of_failure() {
        let mut columns = Vec::new();
        material_columns("steel", &["yielding", "crushed", "molten"], &mut columns);
        let counts = [("yielding", 7), ("crushed", 5), ("molten", 3)].to_vec();
        let mut cells = Vec::new();
        material_cells(&MaterialReport { counts, ..MaterialReport::default() }, &mut cells);
        assert_eq!(columns.len(), cells.len());
        let row: Vec<_> = columns.iter().map(Column::header).zip(cells).collect();
        let expected = [
            ("steel.failed_matrix", 0),
            ("steel.failed_fiber", 0),
            ("steel.failed_total", 0),
            ("steel.failed_crushed", 5),
            ("steel.count_yielding", 7),
            ("steel.count_molten", 3),
        ];
        assert_eq!(row[11..], expected.map(|(name, count)| (name.to_owned(), Cell::Count(count))));
    }
}
