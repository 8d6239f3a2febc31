//! Rows of `history.csv`.
use crate::output::history::{Cell, Column};
use crate::simulation::ledger::Report;
use scene::Scene;

/// The columns of a scene.
pub fn columns(scene: &Scene) -> Vec<Column> {
    let mut columns = vec![
        Column::global("time", "s"),
        Column::global("step", ""),
        Column::global("step_size", "s"),
        Column::global("limited_by", ""),
    ];
    for material in &scene.materials {
        let mut add = |name: &str, unit| columns.push(Column::of(&material.name, name, unit));
        for part in ["kinetic", "strain", "plastic", "fracture", "viscosity"] {
            add(part, "j");
        }
        for axis in ["x", "y", "z"] {
            add(&format!("mean_velocity_{axis}"), "m_s");
        }
        for axis in ["x", "y", "z"] {
            add(&format!("center_{axis}"), "m");
        }
        for kind in ["matrix", "fiber", "total", "crushed"] {
            add(&format!("failed_{kind}"), "");
        }
    }
    for part in ["friction", "impact", "transfer", "boundary_work", "deleted", "residual"] {
        columns.push(Column::global(part, "j"));
    }
    columns.push(Column::global("deleted_particles", ""));
    columns
}

/// What a report says in these columns.
pub fn cells(report: &Report) -> Vec<Cell<'_>> {
    let limit = report.limited_by.as_str();
    let mut cells: Vec<Cell<'_>> =
        vec![report.time.into(), report.steps.into(), report.step.into(), limit.into()];
    for m in &report.materials {
        let e = &m.energies;
        cells.extend([e.kinetic, e.strain, e.plastic, e.fracture, e.viscous].map(Cell::from));
        cells.extend(m.velocity().map(Cell::from));
        cells.extend(m.center.map(Cell::from));
        cells.extend(m.failed.map(Cell::from));
    }
    let parts = [
        report.friction,
        report.impact,
        report.transfer,
        report.boundary_work,
        report.deleted_energy,
        report.residual,
    ];
    cells.extend(parts.map(Cell::from));
    cells.push(report.deleted.into());
    cells
}
