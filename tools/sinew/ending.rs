//! What a run says when it is over: its numbers, and where its time went.
use super::progress::seconds;
use super::say::say;
use super::voice::{Voice, event};
use sinew::output::summary::{Summary, Timing};

/// Rows of the table of times below this share of all time are one, unless all are wanted.
const SHOWN: f64 = 0.01;

/// Says what a run did; `place` is where its results lie.
pub fn tell(summary: &Summary, place: &str, voice: Voice) {
    if voice == Voice::Json {
        let about = serde_json::json!({ "status": summary.status, "folder": place, "summary": summary });
        return event("end", about);
    }
    numbers(summary, place);
    if voice == Voice::Verbose {
        reactions(summary);
    }
    times(&summary.timing, summary.ranks, if voice == Voice::Verbose { 0.0 } else { SHOWN });
    say!("state hash     {}", summary.state_hash);
}

fn numbers(summary: &Summary, place: &str) {
    let e = &summary.energy_j;
    say!("results        {place}");
    say!("simulated      {} in {} steps", seconds(summary.time_s), summary.steps);
    say!(
        "wall time      {:.1} s, {:.2} million particle updates a second and core ({}, {} threads)",
        summary.wall_s,
        summary.updates_per_s_per_core / 1e6,
        summary.isa,
        summary.threads
    );
    say!(
        "energy [J]     kinetic {:.4e}, strain {:.4e}, plastic {:.4e}, fracture {:.4e}, friction {:.4e}, impact {:.4e}, transfer {:.4e}, residual {:+.4e} ({:+.2} % of what was turned over)",
        e.kinetic,
        e.strain,
        e.plastic,
        e.fracture,
        e.friction,
        e.impact,
        e.transfer,
        e.residual,
        if e.turnover > 0.0 { 100.0 * e.residual / e.turnover } else { 0.0 }
    );
    for (name, material) in &summary.materials {
        let [x, y, z] = material.mean_velocity_m_s;
        let failed = material
            .failed_fraction
            .as_ref()
            .map_or(String::new(), |f| format!(", failed {:.2} %", 100.0 * f.any));
        let collapsed = material.more.get("counts").and_then(|counts| counts["collapsed"].as_u64());
        let collapsed = collapsed.filter(|&n| n > 0);
        let collapsed = collapsed.map_or(String::new(), |n| format!(", {n} particles collapsed (J < 0.1)"));
        say!(
            "{name:<14} {} particles, mean velocity ({x:.3}, {y:.3}, {z:.3}) m/s{failed}{collapsed}",
            material.particles
        );
    }
    if summary.deleted_particles > 0 {
        say!("left           {} particles left the domain", summary.deleted_particles);
    }
}

/// What each giver gave in the whole run.
fn reactions(summary: &Summary) {
    let width = summary.reactions.keys().map(|name| name.chars().count()).max().unwrap_or(0).max(14);
    for (name, it) in &summary.reactions {
        let [x, y, z] = it.impulse_n_s;
        let work = it.work_j;
        say!("{name:<width$} impulse ({x:.4e}, {y:.4e}, {z:.4e}) N s, work {work:.4e} J");
    }
}

/// Where the time went: a table with the most first.
fn times(all: &[Timing], ranks: usize, shown: f64) {
    let (rows, rest): (Vec<&Timing>, Vec<&Timing>) = all.iter().partition(|row| row.share >= shown);
    if rows.is_empty() {
        return;
    }
    let sum = |of: fn(&Timing) -> f64| rest.iter().copied().map(of).sum::<f64>();
    let small = Timing {
        what: format!("{} more", rest.len()),
        share: sum(|row| row.share),
        mean_s: sum(|row| row.mean_s),
        least_s: sum(|row| row.least_s),
        most_s: sum(|row| row.most_s),
    };
    let rows: Vec<&Timing> = rows.into_iter().chain((!rest.is_empty()).then_some(&small)).collect();
    let width = rows.iter().map(|row| row.what.chars().count()).max().unwrap_or(0);
    let over = if ranks > 1 { "     mean [s]    least     most" } else { "          [s]" };
    say!("{:<width$}    share{over}", "time");
    for Timing { what, share, mean_s, least_s, most_s } in rows {
        let over = if ranks > 1 { format!("{least_s:>9.3}{most_s:>9.3}") } else { String::new() };
        say!("  {what:<width$}{:>7.1} %{mean_s:>11.3}{over}", 100.0 * share);
    }
}
