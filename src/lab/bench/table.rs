//! The report for people.
use super::ceilings::Ceiling;
use super::report::{FLOP_AN_UPDATE, Report, Row, Timing};
use std::fmt::{self, Display, Formatter};

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (machine, state) = (&self.machine, &self.state);
        let cache = machine.last_cache_bytes >> 20;
        writeln!(f, "machine        {}, {cache} MiB last cache, {}", machine.processor, machine.isa)?;
        writeln!(f, "one core       {}", Shown(&self.one_core))?;
        writeln!(f, "{:<14} {}", format!("{} cores", self.all_cores.threads), Shown(&self.all_cores))?;
        writeln!(
            f,
            "state          {} at {:.4} ms, after {} steps: {} particles, {:.1} % failed, {:.1} % near another material",
            state.scene,
            state.time_ms,
            state.steps_before,
            state.particles,
            100.0 * state.failed,
            100.0 * state.near
        )?;
        writeln!(
            f,
            "               {} blocks, {:.1} % of lanes filled, {} patches, {:.0} MB of data",
            state.blocks,
            100.0 * state.lanes,
            state.patches,
            state.data_mb
        )?;
        writeln!(f, "one thread     {}", Shown(&self.one_thread))?;
        let all = format!("{} threads", self.all_threads.threads);
        writeln!(f, "{all:<14} {}, {:.2} times one", Shown(&self.all_threads), self.speedup)?;
        self.disturbance().iter().try_for_each(|note| writeln!(f, "{note}"))?;
        writeln!(f)?;
        self.rows(f)?;
        writeln!(f)?;
        writeln!(
            f,
            "Time is core time an update of the sweep's particles, in metered steps (they take {:.3} of the time of others);\n\
             flop are operations in vectors, idle lanes and all, counted in one step; scalar code is not (-). slots: multiply-adds,\n\
             additions and multiplications over the ceiling. Bytes are declared columns, node lines and partial sums, with\n\
             write-allocate; above the ceiling they come from cache. Shares of ceilings are those of one core, on one thread.",
            self.meter
        )
    }
}

/// Cores that do not share units make less than this share of their rates alone only if something else runs on them.
const UNDISTURBED: f64 = 0.85;

impl Report {
    /// What to know before rates on all threads are believed.
    fn disturbance(&self) -> Option<String> {
        let alone = self.one_core.fma_gflop_per_s * self.all_cores.threads as f64;
        let share = self.all_cores.fma_gflop_per_s / alone;
        (share < UNDISTURBED).then(|| {
            format!(
                "note           all cores together make {:.0} % of the multiply-adds that they make alone: other work runs, \
                 or they share units; rates on all threads are lower than on an idle machine",
                100.0 * share
            )
        })
    }

    fn rows(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let all = format!("ns on {}", self.all_threads.threads);
        writeln!(
            f,
            "{:<26} {:>8} {:>8} {:>7} {:>8} {:>7} {:>8} {:>6} {:>6} {:>7} {:>6} {:>6}",
            "",
            "ns",
            all,
            "step %",
            "M upd/s",
            "flop",
            "GFLOP/s",
            "FMA %",
            "slot %",
            "bytes",
            "GB/s",
            "copy %"
        )?;
        for sweep in &self.sweeps {
            line(f, &sweep.name, &sweep.total)?;
            if sweep.rows.len() > 1 {
                sweep.rows.iter().try_for_each(|row| line(f, &format!("  {}", row.name), row))?;
            }
        }
        let (sorting, rest) = (&self.sorting, &self.rest);
        let ns = sorting.relocation_ns + sorting.activation_ns;
        writeln!(
            f,
            "{:<26} {ns:>8.3} {:>8} {:>7.2}   (find and move {:.3}, rebuild lists {:.3})",
            "sorting",
            "",
            100.0 * sorting.share,
            sorting.relocation_ns,
            sorting.activation_ns
        )?;
        let (one, all, share) = (rest.one_thread_ns, rest.all_threads_ns, 100.0 * rest.share);
        writeln!(f, "{:<26} {one:>8.3} {all:>8.3} {share:>7.2}   (reductions, checks, waiting)", "rest")?;
        self.order.iter().try_for_each(|order| {
            let (fixed, free) = (order.fixed_ns, order.free_ns);
            let share = 100.0 * (fixed - free) / self.one_thread.best_update_ns;
            writeln!(
                f,
                "{:<26} {:>8.3} {:>8} {share:>7.2}   (P2G and node sums: fixed order {fixed:.3}, any order {free:.3})",
                "fixed order",
                fixed - free,
                ""
            )
        })
    }
}

fn line(f: &mut Formatter<'_>, name: &str, row: &Row) -> fmt::Result {
    let (one, all, share, rate) =
        (row.one_thread_ns, row.all_threads_ns, 100.0 * row.share, row.updates_per_s / 1e6);
    write!(f, "{name:<26} {one:>8.3} {all:>8.3} {share:>7.2} {rate:>8.1}")?;
    match row.flop > 0.0 {
        true => write!(
            f,
            " {:>7.0} {:>8.1} {:>6.1} {:>6.1}",
            row.flop,
            row.gflop_per_s,
            100.0 * row.fma_share,
            100.0 * row.slot_share
        )?,
        false => write!(f, " {:>7} {:>8} {:>6} {:>6}", "-", "-", "-", "-")?,
    }
    match row.bytes > 0.0 {
        true => writeln!(f, " {:>7.1} {:>6.1} {:>6.1}", row.bytes, row.gb_per_s, 100.0 * row.copy_share),
        false => writeln!(f, " {:>7} {:>6} {:>6}", "-", "-", "-"),
    }
}

/// One line of words.
struct Shown<'a, T>(&'a T);

impl Display for Shown<'_, Ceiling> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "multiply-adds {:.1} GFLOP/s, copy {:.1} GB/s read and written ({:.1} with write-allocate)",
            self.0.fma_gflop_per_s, self.0.copy_gb_per_s, self.0.traffic_gb_per_s
        )
    }
}

impl Display for Shown<'_, Timing> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.2} million updates/s at best, {:.2} in the median; {:.1} ns an update, {:.1} % of the multiply-adds at {:.0} an update",
            self.0.best_updates_per_s / 1e6,
            self.0.median_updates_per_s / 1e6,
            self.0.best_update_ns,
            100.0 * self.0.fma_share,
            FLOP_AN_UPDATE
        )
    }
}
