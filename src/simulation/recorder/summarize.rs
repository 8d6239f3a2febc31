//! What `summary.json` says about a run.
use crate::output;
use crate::output::summary::{self, Energy, Failed, FirstFailure, MaterialSummary, Status, Summary};
use crate::simulation::Simulation;
use crate::simulation::ledger::{MaterialReport, Report};
use engine::exec::ranks::Network;
use engine::exec::ranks::collective;
use std::collections::BTreeMap;

fn failed(reports: &[&MaterialReport]) -> Failed {
    let particles = reports.iter().map(|m| m.particles).sum::<u64>().max(1) as f64;
    let kind = |i: usize| reports.iter().map(|m| m.failed[i]).sum::<u64>() as f64 / particles;
    let [matrix, fiber, total] = [kind(0), kind(1), kind(2) + kind(3)];
    Failed { matrix, fiber, total, any: matrix + fiber + total }
}

/// How a run ended, and the seconds that it took.
pub struct Ending {
    /// How.
    pub status: Status,
    /// The error that ended it.
    pub error: Option<String>,
    /// Seconds on the clock, with those before a restart.
    pub wall_s: f64,
    /// Seconds of these that steps took.
    pub stepping_s: f64,
}

/// The summary, the same on all ranks.
///
/// # Errors
/// If a rank is gone.
pub fn summarize(simulation: &mut Simulation, ending: Ending) -> output::Result<Summary> {
    let Ending { status, error, wall_s, stepping_s } = ending;
    let report = simulation.report()?;
    let energy = report.energy();
    let [particle_bytes, node_bytes, peak_bytes, updates] = over_ranks(simulation)?;
    let (state_hash, ranks) = (simulation.state_hash(), simulation.network().size());
    let rate = updates as f64 / stepping_s.max(f64::MIN_POSITIVE);
    let total = |part: fn(&MaterialReport) -> [f64; 3]| {
        report.materials.iter().map(part).fold([0.0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]])
    };
    let failing: Vec<&MaterialReport> = report.materials.iter().filter(|m| m.fails).collect();
    let balance = simulation.balance();
    let balance = serde_json::json!({
        "moves": balance.moves, "patches": balance.patches, "imbalance": balance.imbalance,
    });
    let more = [
        ("memory_bytes", serde_json::json!({ "particles": particle_bytes, "nodes": node_bytes })),
        ("peak_bytes", peak_bytes.into()),
        ("balance", balance),
        ("deleted_j", report.deleted_energy.into()),
        ("stepping_s", stepping_s.into()),
        ("ticks", simulation.ticks().into()),
        ("updates", updates.into()),
    ];
    Ok(Summary {
        status,
        error,
        scene: simulation.scene.name.clone(),
        steps: report.steps,
        time_s: report.time,
        wall_s,
        particles: report.materials.iter().map(|m| m.particles).sum(),
        updates_per_s: rate,
        updates_per_s_per_core: rate / (ranks * simulation.threads()) as f64,
        ranks,
        threads: simulation.threads(),
        patches: simulation.warehouse.decomposition.counts,
        isa: simulation.isa().name().to_owned(),
        state_hash: summary::hex(state_hash),
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

/// Bytes of particles, of nodes and of all that a process ever had (0: unknown), the most of a rank, and the particles
/// moved by all.
fn over_ranks(simulation: &mut Simulation) -> output::Result<[u64; 4]> {
    let ((particles, nodes), updates) = (simulation.bytes(), simulation.updates());
    let network: &mut dyn Network = simulation.network();
    let all = collective::share(network, &[particles as u64, nodes as u64, peak_bytes(), updates])?;
    let column = |i: usize| all.iter().map(move |numbers| numbers[i]);
    let most = |i: usize| column(i).max().unwrap_or(0);
    Ok([most(0), most(1), most(2), column(3).sum()])
}

/// The most memory that this process has had [B], where the system says so; else 0.
fn peak_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    number.map_or(0, |kilobytes| 1024 * kilobytes)
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
