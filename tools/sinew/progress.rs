//! Progress of a run: a bar on a terminal, plain lines elsewhere, or objects for programs.
use super::fail::Failure;
use super::say::tell;
use super::voice::{Voice, event};
use engine::exec::ranks::collective;
use indicatif::{ProgressBar, ProgressStyle};
use sinew::lab::figure::axis::{SECONDS, in_unit};
use sinew::simulation::{RunError, Simulation};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Ticks of the bar.
const TICKS: u64 = 1000;

/// Shows how far a run has come.
pub struct Progress {
    bar: Option<ProgressBar>,
    voice: Voice,
    /// Of several ranks the first, which talks.
    first: bool,
    began: Instant,
    shown: Instant,
    next_line: f64,
    /// Simulated time at which it is done [s].
    until: f64,
    /// The part that was done, and the particles moved, before it began.
    before: (f64, u64),
    /// The part of all particles that is on this rank.
    share: f64,
}

impl Progress {
    /// Announces the run.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn begin(title: &str, simulation: &mut Simulation, voice: Voice) -> Result<Self, Failure> {
        let mine = simulation.warehouse.particle_count();
        let mut count = [mine as u64];
        let ranks = simulation.network().size();
        collective::sum(simulation.network(), &mut count).map_err(RunError::from)?;
        let first = simulation.network().rank() == 0;
        let voice = if first { voice } else { Voice::Quiet };
        let people = matches!(voice, Voice::Plain | Voice::Verbose);
        let bar = (people && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(TICKS);
            if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}") {
                bar.set_style(style);
            }
            bar
        });
        let [a, b, c] = simulation.warehouse.decomposition.counts;
        if voice == Voice::Json {
            event(
                "begin",
                serde_json::json!({
                    "title": title, "particles": count[0], "patches": [a, b, c], "ranks": ranks,
                    "threads": simulation.threads(), "isa": simulation.isa().name(),
                    "step": simulation.steps(), "time_s": simulation.clock().time,
                    "until_s": simulation.scene.run.until,
                }),
            );
        } else if people {
            tell!("{title}");
            tell!(
                "{} particles, {a}x{b}x{c} patches, {}{} threads, {}",
                count[0],
                if ranks > 1 { format!("{ranks} ranks of ") } else { String::new() },
                simulation.threads(),
                simulation.isa().name()
            );
        }
        let now = Instant::now();
        let until = simulation.scene.run.until;
        let before = (fraction(simulation, until), simulation.updates());
        let share = mine as f64 / count[0].max(1) as f64;
        Ok(Self {
            bar,
            voice,
            first,
            began: now,
            shown: now,
            next_line: before.0 + lines(voice).0,
            until,
            before,
            share,
        })
    }

    /// Counts to a time before the end of the run [s].
    pub fn until(self, until: f64) -> Self {
        Self { until, ..self }
    }

    /// After a step.
    pub fn step(&mut self, simulation: &Simulation) {
        if self.voice == Voice::Quiet {
            return;
        }
        let done = fraction(simulation, self.until);
        let (part, silence) = lines(self.voice);
        let due = match self.bar {
            Some(_) => self.shown.elapsed() > Duration::from_millis(200),
            None => done >= self.next_line || self.shown.elapsed() > silence,
        };
        if !due {
            return;
        }
        self.shown = Instant::now();
        self.next_line = done + part;
        let spent = self.began.elapsed().as_secs_f64();
        let left = spent * (1.0 - done) / (done - self.before.0).max(1e-9);
        let clock = simulation.clock();
        let rate = (simulation.updates() - self.before.1) as f64 / self.share / spent;
        if self.voice == Voice::Json {
            return event(
                "progress",
                serde_json::json!({
                    "step": simulation.steps(), "time_s": clock.time, "step_s": clock.tick, "done": done,
                    "updates_per_s": rate, "left_s": left,
                }),
            );
        }
        let message = format!(
            "step {}  t {}  dt {}  {:.2} M updates/s  {} left",
            simulation.steps(),
            seconds(clock.time),
            seconds(clock.tick),
            rate / 1e6,
            duration(left)
        );
        match &self.bar {
            Some(bar) => {
                bar.set_position((done * TICKS as f64) as u64);
                bar.set_message(message);
            }
            None => tell!("{:>3.0} %  {message}", 100.0 * done),
        }
    }

    /// Warnings of a run, also of a quiet one.
    pub fn warn<'a>(&self, warnings: impl Iterator<Item = &'a str>) {
        for warning in warnings.filter(|_| self.first) {
            match &self.bar {
                _ if self.voice == Voice::Json => event("warning", serde_json::json!({ "text": warning })),
                Some(bar) => bar.suspend(|| tell!("warning: {warning}")),
                None => tell!("warning: {warning}"),
            }
        }
    }

    /// Takes the bar away.
    pub fn end(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}

/// How often lines come: after which part of the run, and at the latest after how long.
fn lines(voice: Voice) -> (f64, Duration) {
    match voice {
        Voice::Verbose => (0.01, Duration::from_secs(5)),
        _ => (0.05, Duration::from_secs(20)),
    }
}

/// The part of a run until a time [s] that is done.
fn fraction(simulation: &Simulation, until: f64) -> f64 {
    let by_time = simulation.clock().time / until;
    let by_steps =
        simulation.scene.run.steps.map_or(0.0, |most| simulation.steps() as f64 / most.max(1) as f64);
    by_time.max(by_steps).min(1.0)
}

/// Simulated time in its unit: `0.8 ms`.
pub fn seconds(time: f64) -> String {
    in_unit(time, &SECONDS, 5)
}

/// Seconds in words: `42 s`, `3 min 5 s`, `2 h 4 min`.
pub fn duration(seconds: f64) -> String {
    match seconds.round() as u64 {
        s if s < 60 => format!("{s} s"),
        s if s < 3600 => format!("{} min {} s", s / 60, s % 60),
        s => format!("{} h {} min", s / 3600, s / 60 % 60),
    }
}
