//! What stops a run before its end: a signal, or the time that it may take (`--wall`).
use super::fail::Failure;
use super::ranks::lost;
use super::signals::Signals;
use engine::exec::ranks::{Network, collective};
use physics::parameter::Dimension;
use sinew::input::units;
use sinew::simulation::Simulation;
use sinew::simulation::recorder::Recorder;
use std::time::{Duration, Instant};

/// The exit status of a run whose time is over, which is that of timeout(1).
const OUT_OF_TIME: u8 = 124;
/// Bytes a second to a slow disk, before a checkpoint has shown how fast it is.
const SLOW: f64 = 50e6;
/// How much longer than what was seen the next step and checkpoint may take.
const CARE: f64 = 2.0;

/// How long after a signal a step may go on: launchers and batch systems kill soon after.
const PATIENCE: Duration = Duration::from_secs(5);

/// Reasons to stop.
pub struct Stop {
    signals: Option<Signals>,
    began: Instant,
    /// The time that the run may take [s].
    wall: Option<f64>,
    late: bool,
    last: Instant,
    /// Seconds that the longest step took, with its output.
    longest: f64,
}

impl Stop {
    /// From now on, with the time that the command line allows.
    pub fn read(wall: Option<&str>) -> Result<Self, Failure> {
        let began = Instant::now();
        let seconds = |text: &str| match units::parse(text, Dimension::Time) {
            Ok(seconds) if seconds > 0.0 => Ok(seconds),
            Ok(_) => Err(Failure::usage(format!("--wall is {text:?}, and must be above 0"))),
            Err(problem) => Err(Failure::usage(format!(
                "--wall {problem}; write for example --wall \"23 h\" (units: {})",
                units::accepted(Dimension::Time)
            ))),
        };
        let wall = wall.map(seconds).transpose()?;
        Ok(Self { signals: None, began, wall, late: false, last: began, longest: 0.0 })
    }

    /// Heeds signals, now that steps begin; a step that takes long after one is ended in its middle.
    pub fn watch(&mut self, simulation: &mut Simulation) -> Result<(), Failure> {
        let signals = Signals::watch();
        let signals = signals.map_err(|error| Failure::Local(format!("cannot watch signals: {error}")))?;
        self.signals = Some(signals.clone());
        let mut since = None;
        simulation.set_impatience(Box::new(move || {
            signals.came() && since.get_or_insert_with(Instant::now).elapsed() > PATIENCE
        }));
        self.last = Instant::now();
        Ok(())
    }

    /// After a step: whether a signal came, or one more step and a checkpoint would come too late.
    pub fn wanted(&mut self, simulation: &Simulation, recorder: &Recorder) -> bool {
        let now = Instant::now();
        self.longest = self.longest.max((now - self.last).as_secs_f64());
        self.last = now;
        if let Some(wall) = self.wall {
            let written = recorder.checkpoint_s().unwrap_or_else(|| simulation.bytes().0 as f64 / SLOW);
            let left = wall - (now - self.began).as_secs_f64();
            self.late |= left < CARE * (self.longest + written);
        }
        self.late || self.signals.as_ref().is_some_and(Signals::came)
    }

    /// What to say of a run that has stopped, and its exit status. All ranks call it: one alone may have seen the reason.
    pub fn reason(&self, network: &mut dyn Network) -> Result<(&'static str, u8), Failure> {
        let signal = self.signals.as_ref().and_then(Signals::exit_status);
        let mine = signal.unwrap_or(if self.late { OUT_OF_TIME } else { 0 });
        let all = collective::share(network, &[mine.into()]).map_err(lost)?;
        // the statuses of signals are above that of the time, and come before it
        match all.iter().flatten().filter_map(|&status| u8::try_from(status).ok()).max() {
            Some(status) if status > OUT_OF_TIME => Ok(("interrupted", status)),
            _ => Ok(("out of time (--wall)", OUT_OF_TIME)),
        }
    }
}
