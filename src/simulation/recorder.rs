//! The folder of a run: scene, history, frames and summary.
use super::Simulation;
use super::ledger::{MaterialReport, Report};
use crate::output::frame::Frame;
use crate::output::history::{Cell, Column, History};
use crate::output::summary::{self, Energy, Failed, FirstFailure, MaterialSummary, Status, Summary};
use crate::output::{self, vtkhdf};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Writes what a run leaves behind.
pub struct Recorder {
    folder: PathBuf,
    history: History,
    particles: Option<vtkhdf::Writer>,
    frames: usize,
    began: Instant,
    /// Seconds spent on output.
    pub output_s: f64,
}

/// The files that make a folder a run's.
const FILES: [&str; 4] = ["scene.toml", "summary.json", "history.csv", "particles.vtkhdf"];

/// Whether a folder holds a run.
pub fn holds_run(folder: &Path) -> bool {
    FILES.iter().any(|file| folder.join(file).exists())
}

impl Recorder {
    /// Makes the folder, writes `scene.toml` and the first row and frame.
    ///
    /// # Errors
    /// If the folder or a file in it cannot be written.
    pub fn create(folder: &Path, simulation: &mut Simulation) -> output::Result<Self> {
        let cannot = |source| output::Error::Io { action: "create", path: folder.into(), source };
        std::fs::create_dir_all(folder).map_err(cannot)?;
        for file in FILES.iter().map(|file| folder.join(file)).filter(|file| file.exists()) {
            std::fs::remove_file(&file).map_err(cannot)?;
        }
        summary::write_whole(&folder.join("scene.toml"), simulation.scene.resolved.as_bytes())?;
        let history = History::create(&folder.join("history.csv"), &columns(simulation))?;
        let particles = match simulation.scene.output.frames {
            0 => None,
            _ => Some(vtkhdf::Writer::create(&folder.join("particles.vtkhdf"))?),
        };
        let (folder, began) = (folder.to_owned(), Instant::now());
        let mut recorder = Self { folder, history, particles, frames: 0, began, output_s: 0.0 };
        recorder.row(simulation)?;
        recorder.frame(simulation)?;
        Ok(recorder)
    }

    /// After a step: a row and a frame, if they are due.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn step(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        let finished = simulation.finished();
        if finished || simulation.steps().is_multiple_of(simulation.scene.output.history_every.max(1)) {
            self.row(simulation)?;
        }
        let every = simulation.scene.run.until / simulation.scene.output.frames.max(1) as f64;
        // a hair early rather than a step late
        let due = simulation.clock().time >= self.frames as f64 * every * (1.0 - 1e-12);
        if self.frames > 0 && (finished || due) {
            self.frame(simulation)?;
        }
        Ok(())
    }

    fn row(&mut self, simulation: &mut Simulation) -> output::Result<()> {
        let began = Instant::now();
        let report = simulation.report()?;
        self.history.row(&cells(&report))?;
        self.output_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    fn frame(&mut self, simulation: &Simulation) -> output::Result<()> {
        let began = Instant::now();
        if let Some(writer) = &mut self.particles {
            writer.append(&simulation.snapshot())?;
            self.frames += 1;
        }
        self.output_s += began.elapsed().as_secs_f64();
        Ok(())
    }

    /// Closes all files and writes `summary.json`.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn finish(mut self, simulation: &mut Simulation, error: Option<String>) -> output::Result<Summary> {
        if error.is_some() && self.frames > 0 {
            self.frame(simulation)?;
        }
        if let Some(writer) = self.particles.take() {
            writer.close()?;
        }
        let wall = self.began.elapsed().as_secs_f64();
        let summary = summarize(simulation, wall, wall - self.output_s, error)?;
        summary.write(&self.folder.join("summary.json"))?;
        Ok(summary)
    }
}

fn columns(simulation: &Simulation) -> Vec<Column> {
    let mut columns = vec![
        Column::global("time", "s"),
        Column::global("step", ""),
        Column::global("step_size", "s"),
        Column::global("limited_by", ""),
    ];
    for material in &simulation.scene.materials {
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

fn cells(report: &Report) -> Vec<Cell<'_>> {
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

fn failed(reports: &[&MaterialReport]) -> Failed {
    let particles = reports.iter().map(|m| m.particles).sum::<u64>().max(1) as f64;
    let kind = |i: usize| reports.iter().map(|m| m.failed[i]).sum::<u64>() as f64 / particles;
    let [matrix, fiber, total] = [kind(0), kind(1), kind(2) + kind(3)];
    Failed { matrix, fiber, total, any: matrix + fiber + total }
}

fn summarize(
    simulation: &mut Simulation,
    wall_s: f64,
    stepping_s: f64,
    error: Option<String>,
) -> output::Result<Summary> {
    let report = simulation.report()?;
    let energy = report.energy();
    let rate = simulation.updates() as f64 / stepping_s.max(f64::MIN_POSITIVE);
    let total = |part: fn(&MaterialReport) -> [f64; 3]| {
        report.materials.iter().map(part).fold([0.0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]])
    };
    let failing: Vec<&MaterialReport> = report.materials.iter().filter(|m| m.fails).collect();
    let (particle_bytes, node_bytes) = simulation.bytes();
    let more = [
        ("memory_bytes", serde_json::json!({ "particles": particle_bytes, "nodes": node_bytes })),
        ("deleted_j", report.deleted_energy.into()),
        ("stepping_s", stepping_s.into()),
        ("ticks", simulation.ticks().into()),
        ("updates", simulation.updates().into()),
    ];
    Ok(Summary {
        status: if error.is_some() { Status::Failed } else { Status::Completed },
        error,
        scene: simulation.scene.name.clone(),
        steps: report.steps,
        time_s: report.time,
        wall_s,
        particles: simulation.snapshot().particles() as u64,
        updates_per_s: rate,
        updates_per_s_per_core: rate / simulation.threads() as f64,
        ranks: 1,
        threads: simulation.threads(),
        patches: simulation.warehouse.decomposition.counts,
        isa: simulation.isa().name().to_owned(),
        state_hash: summary::hex(simulation.state_hash()),
        mass_kg: report.materials.iter().map(|m| m.mass).sum(),
        momentum_kg_m_s: total(|m| m.momentum),
        angular_momentum_kg_m2_s: total(|m| m.angular_momentum),
        energy_j: Energy {
            kinetic: energy.kinetic,
            strain: energy.strain,
            plastic: energy.plastic,
            fracture: energy.fracture,
            friction: report.friction,
            impact: report.impact,
            transfer: report.transfer,
            viscosity: energy.viscous,
            boundary_work: report.boundary_work,
            residual: report.residual,
        },
        failed_fraction: failed(&failing),
        first_failure: first_failures(&report),
        deleted_particles: report.deleted,
        crushed_particles: report.materials.iter().map(|m| m.failed[3]).sum(),
        materials: materials(simulation, &report),
        more: more.map(|(k, v)| (k.to_owned(), v)).into(),
    })
}

fn first_failures(report: &Report) -> BTreeMap<String, FirstFailure> {
    let kinds = ["matrix", "fiber"].into_iter().enumerate();
    let first = |kind: usize| {
        let all = report.materials.iter().filter_map(|m| m.first_failure[kind]);
        all.min_by(|a, b| a.time.total_cmp(&b.time))
    };
    kinds
        .filter_map(|(i, name)| {
            let f = first(i)?;
            let first = FirstFailure { time_s: f.time, position_m: f.position, particle: f.particle };
            Some((name.to_owned(), first))
        })
        .collect()
}

fn materials(simulation: &Simulation, report: &Report) -> BTreeMap<String, MaterialSummary> {
    let pairs = simulation.scene.materials.iter().zip(&report.materials);
    let one = |m: &MaterialReport| MaterialSummary {
        particles: m.particles,
        mass_kg: m.mass,
        mean_velocity_m_s: m.velocity(),
        center_of_mass_m: m.center,
        failed_fraction: m.fails.then(|| failed(&[m])),
        more: BTreeMap::new(),
    };
    pairs.map(|(material, m)| (material.name.clone(), one(m))).collect()
}
