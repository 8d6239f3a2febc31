//! What `summary.json` says about a run.
use crate::output;
use crate::output::run_id::RunId;
use crate::output::summary::{
    self, Energy, FirstFailure, MaterialSummary, Reaction, Status, Summary, Timing,
};
use crate::simulation::report::{FirstEvent, GiverReport, MaterialReport, Report};
use crate::simulation::{Simulation, failures};
use engine::exec::ranks::{Network, collective};
use std::collections::BTreeMap;

/// How a run ended, and the seconds that it took.
pub struct Ending {
    /// Whose it is.
    pub run: RunId,
    /// How.
    pub status: Status,
    /// The error that ended it.
    pub error: Option<String>,
    /// What it has warned of.
    pub warnings: Vec<String>,
    /// Seconds on the clock, with those before a restart.
    pub wall_s: f64,
    /// Seconds of these that steps took.
    pub stepping_s: f64,
    /// Where the seconds since the last start went.
    pub timing: Vec<Timing>,
}

/// The summary, the same on all ranks.
///
/// # Errors
/// If a rank is gone.
pub fn summarize(simulation: &mut Simulation, ending: Ending) -> output::Result<Summary> {
    let Ending { run, status, error, warnings, wall_s, stepping_s, timing } = ending;
    let report = simulation.report()?;
    let energy = report.energy();
    let [particle_bytes, node_bytes, peak_bytes, updates] = over_ranks(simulation)?;
    let (state_hash, ranks) = (simulation.state_hash(), simulation.network().size());
    let rate = updates as f64 / stepping_s.max(f64::MIN_POSITIVE);
    let total = |part: fn(&MaterialReport) -> [f64; 3]| {
        report.materials.iter().map(part).fold([0.0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]])
    };
    let failing: Vec<&MaterialReport> = report.materials.iter().filter(|m| failures::known(m)).collect();
    let balance = simulation.balance();
    let balance = serde_json::json!({
        "moves": balance.moves, "patches": balance.patches, "imbalance": balance.imbalance,
    });
    let is_failure = |event: &str| failures::EVENTS.contains(&event);
    let mut more = BTreeMap::from([
        ("run", run.to_string().into()),
        ("memory_bytes", serde_json::json!({ "particles": particle_bytes, "nodes": node_bytes })),
        ("peak_bytes", peak_bytes.into()),
        ("balance", balance),
        ("deleted_j", report.deleted_energy.into()),
        ("stepping_s", stepping_s.into()),
        ("ticks", simulation.ticks().into()),
        ("updates", updates.into()),
    ]);
    if !warnings.is_empty() {
        more.insert("warnings", serde_json::json!(warnings));
    }
    let others = first_events(&report, |event| !is_failure(event));
    if !others.is_empty() {
        more.insert("first_event", serde_json::json!(others));
    }
    Ok(Summary {
        status,
        error,
        scene: simulation.scene.name.clone(),
        steps: report.steps,
        time_s: report.time,
        wall_s,
        timing,
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
        angular_momentum_lost_in_transfer_kg_m2_s: report.spin_lost,
        energy_j: Energy {
            kinetic: energy.kinetic,
            strain: energy.strain,
            plastic: energy.plastic,
            fracture: energy.fracture,
            friction: report.friction,
            impact: report.impact,
            transfer: report.transfer,
            half_step: report.half_step,
            viscosity: energy.viscous,
            boundary_work: report.boundary_work,
            residual: report.residual,
            turnover: report.turnover,
        },
        failed_fraction: failures::fractions(&failing),
        first_failure: first_events(&report, is_failure),
        deleted_particles: report.deleted,
        crushed_particles: failures::total(&report, "crushed"),
        reactions: reactions(&report),
        materials: materials(simulation, &report),
        more: more.into_iter().map(|(k, v)| (k.to_owned(), v)).collect(),
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

/// The first of each event that is `wanted`, over all materials.
fn first_events(report: &Report, wanted: impl Fn(&str) -> bool) -> BTreeMap<String, FirstFailure> {
    let names = report.materials.iter().flat_map(|m| &m.first).map(|&(name, _)| name);
    let place = |f: FirstEvent| FirstFailure { time_s: f.time, position_m: f.position, particle: f.particle };
    let first = |name: &str| Some((name.to_owned(), place(failures::first(report, name)?)));
    names.filter(|name| wanted(name)).filter_map(first).collect()
}

/// What the law of a material counts beside failure.
fn counts(m: &MaterialReport) -> BTreeMap<String, serde_json::Value> {
    let others = m.counts.iter().filter(|(state, _)| !failures::is_one(state));
    let counts: BTreeMap<_, _> = others.copied().collect();
    let all = (!counts.is_empty()).then(|| ("counts".to_owned(), serde_json::json!(counts)));
    all.into_iter().collect()
}

fn reactions(report: &Report) -> BTreeMap<String, Reaction> {
    let one = |it: &GiverReport| Reaction {
        impulse_n_s: it.impulse,
        torque_impulse_n_m_s: it.torque_impulse,
        work_j: it.work,
    };
    report.givers.iter().map(|it| (it.name.clone(), one(it))).collect()
}

/// The largest of what its law keeps, as far as that is a number.
fn largest(m: &MaterialReport) -> BTreeMap<String, f64> {
    let numbers = m.largest.iter().filter(|(_, number)| number.is_finite());
    numbers.map(|&(name, number)| (name.to_owned(), number)).collect()
}

fn materials(simulation: &Simulation, report: &Report) -> BTreeMap<String, MaterialSummary> {
    let pairs = simulation.scene.materials.iter().zip(&report.materials);
    let one = |m: &MaterialReport| MaterialSummary {
        particles: m.particles,
        mass_kg: m.mass,
        mean_velocity_m_s: m.velocity(),
        center_of_mass_m: m.center,
        extent_m: m.extent,
        displacement_m: m.rigid.map(|[gone, _]| gone),
        angular_velocity_rad_s: m.rigid.map(|[_, turn]| turn),
        largest: largest(m),
        failed_fraction: failures::known(m).then(|| failures::fractions(&[m])),
        more: counts(m),
    };
    pairs.map(|(material, m)| (material.name.clone(), one(m))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_s_own_events_and_counts_are_told_by_name() {
        let at = |time, particle| Some(FirstEvent { time, particle, position: [1.0, 2.0, 3.0] });
        let material = |counts: &[_], first: &[_]| MaterialReport {
            counts: counts.to_vec(),
            first: first.to_vec(),
            particles: 10,
            ..MaterialReport::default()
        };
        let tissue = material(&[("matrix", 1), ("crushed", 2)], &[("matrix", at(4.0, 1)), ("fiber", None)]);
        let steel = material(&[("molten", 3)], &[("melts", at(2.0, 7))]);
        assert!(failures::known(&tissue) && !failures::known(&steel));
        assert_eq!(failures::fractions(&[&tissue]).any, 0.1 + 0.2);
        assert!(counts(&tissue).is_empty());
        assert_eq!(counts(&steel)["counts"], serde_json::json!({ "molten": 3 }));
        let materials =
            vec![tissue, steel.clone(), MaterialReport { first: vec![("melts", at(1.0, 9))], ..steel }];
        let report = Report { materials, ..Report::default() };
        let told = first_events(&report, |_| true);
        assert_eq!(told.keys().collect::<Vec<_>>(), ["matrix", "melts"]);
        assert_eq!((told["melts"].time_s, told["melts"].particle), (1.0, 9));
        assert_eq!(failures::total(&report, "crushed"), 2);
    }
}
