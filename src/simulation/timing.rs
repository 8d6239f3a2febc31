//! Where the time of a run went: by stage, and by what is no stage, over ranks.
use super::Simulation;
use crate::output::summary::Timing;
use engine::exec::ranks::{NetworkError, collective};
use std::time::Instant;

/// Writing results has begun.
pub struct Output {
    clock: Instant,
    tick: u64,
}

impl Simulation {
    /// Results are written from now on: graphs that run until [`Simulation::end_output`] are no part of a step.
    pub fn begin_output(&self) -> Output {
        self.engine.trace().pause(true);
        Output { clock: Instant::now(), tick: self.engine.trace().now() }
    }

    /// They are written; seconds that it took.
    pub fn end_output(&self, output: &Output) -> f64 {
        use engine::exec::trace::{Event, Kind};
        self.engine.trace().pause(false);
        self.engine.trace().record(0, output.tick, Event::other(Kind::Output));
        output.clock.elapsed().as_secs_f64()
    }

    /// Where the last `wall_s` seconds went, with the most first: of each row the mean, the least and the most over ranks. Stages of
    /// several materials and graphs that have the same tasks are one. A second of one of several threads is a part of a second.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn timing(&mut self, wall_s: f64) -> Result<Vec<Timing>, NetworkError> {
        let (spent, ns_per_tick) = self.engine.trace().spent();
        let seconds = |ticks: u64| 1e-9 * ns_per_tick * ticks as f64;
        let each = 1.0 / self.threads() as f64;
        let mut rows: Vec<(String, f64)> = Vec::new();
        for (number, graph) in self.program.graphs().into_iter().enumerate() {
            for stage in graph.phases.iter().flat_map(|phase| &phase.stages) {
                let Some(&place) = stage.entries.first() else { continue };
                let (name, took) = (graph.name_of(stage), each * seconds(spent.stage(number, place)));
                match rows.iter_mut().find(|(known, _)| *known == name) {
                    Some((_, sum)) => *sum += took,
                    None => rows.push((name, took)),
                }
            }
        }
        let others = [
            ("particles to other blocks", seconds(spent.relocation())),
            ("packing for other ranks", seconds(spent.exchange())),
            ("waiting for other ranks", seconds(spent.waiting())),
            ("waiting for threads", each * seconds(spent.idle())),
            ("output", seconds(spent.output())),
        ];
        rows.extend(others.map(|(name, took)| (name.to_owned(), took)));
        let known: f64 = rows.iter().map(|(_, took)| took).sum();
        rows.push(("other".to_owned(), (wall_s - known).max(0.0)));
        self.over_ranks(rows)
    }

    fn over_ranks(&mut self, rows: Vec<(String, f64)>) -> Result<Vec<Timing>, NetworkError> {
        let bits: Vec<u64> = rows.iter().map(|(_, took)| took.to_bits()).collect();
        let ranks = collective::share(self.network(), &bits)?;
        let of = |row: usize| ranks.iter().map(move |bits| f64::from_bits(bits[row]));
        let mean = |row: usize| of(row).sum::<f64>() / ranks.len() as f64;
        let total: f64 = (0..rows.len()).map(mean).sum();
        let timing = |(row, (what, _)): (usize, (String, f64))| Timing {
            what,
            share: mean(row) / total.max(f64::MIN_POSITIVE),
            mean_s: mean(row),
            least_s: of(row).fold(f64::INFINITY, f64::min),
            most_s: of(row).fold(0.0, f64::max),
        };
        let mut timings: Vec<Timing> = rows.into_iter().enumerate().map(timing).collect();
        timings.retain(|timing| timing.most_s > 0.0);
        timings.sort_by(|a, b| b.mean_s.total_cmp(&a.mean_s));
        Ok(timings)
    }
}
