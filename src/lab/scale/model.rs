//! What the model of a machine is made of: the costs of a rank's work, and its network.
use super::step::Step;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};

/// What is simulated, but for the ranks.
#[derive(Clone)]
pub struct Setup<'a> {
    /// What happens in a step.
    pub step: &'a Step<'a>,
    /// Costs of work.
    pub costs: Costs,
    /// The network.
    pub cluster: Cluster,
    /// Workers a rank.
    pub threads: usize,
    /// Steps; the first one, in which all begin together, is not counted if there are more.
    pub steps: usize,
}

/// What the tasks of a phase cost [ns].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PhaseCost {
    /// All of it, once a tick.
    Once(f64),
    /// A particle, by material.
    Particles(Vec<f64>),
    /// A block of nodes of one field.
    Nodes(f64),
}

/// What the work of a rank costs [ns], on one worker that has the machine to itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Costs {
    /// Tasks, phase by phase.
    pub phases: Vec<PhaseCost>,
    /// What the engine does for a block of particles outside tasks.
    pub block: f64,
    /// What it does for a patch.
    pub patch: f64,
    /// What it does once a tick.
    pub step: f64,
    /// Looking for particles that leave a block.
    pub relocate: f64,
    /// Handing a slab of a phase to several workers.
    pub fork: f64,
    /// Packing or unpacking a byte.
    pub pack: f64,
    /// Merging a byte of a reduction.
    pub merge: f64,
    /// Time of tasks while all cores work, over their time alone: cores share memory.
    pub contention: f64,
}

/// A fat tree of machines with some ranks each. Messages cost as in LogGP (A. Alexandrov, M. F. Ionescu, K. E. Schauser,
/// C. Scheiman, SPAA 1995, 95–105): latency, overhead on both sides, and a time a byte.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cluster {
    /// From machine to machine below one switch [s].
    pub latency: f64,
    /// More, if the way leads through upper switches [s].
    pub hop: f64,
    /// Time of a processor for sending or receiving a message [s].
    pub overhead: f64,
    /// What a machine can send, shared by its ranks [B/s].
    pub bandwidth: f64,
    /// Within a machine [s].
    pub inner_latency: f64,
    /// Within a machine, for each rank [B/s].
    pub inner_bandwidth: f64,
    /// Ranks that share a machine.
    pub ranks: usize,
    /// Machines below one switch.
    pub machines: usize,
    /// What the machines below a switch can send over what the switch can pass on.
    pub taper: f64,
    /// Mean of the random part of the time of a rank's tasks over the rest: exponential, anew each tick.
    pub noise: f64,
}

impl Default for Cluster {
    /// A cluster of machines with two sockets on 100 Gb/s: small messages take 1 to 2 µs and long ones 12 GB/s on
    /// InfiniBand EDR, HDR100 and Omni-Path, whose trees are tapered up to 2:1 (D. Stanzione et al., PEARC 2020,
    /// 106–111, doi:10.1145/3311790.3396656, on Frontera's 22:18; <https://mvapich.cse.ohio-state.edu/benchmarks/>).
    fn default() -> Self {
        Self {
            latency: 1.5e-6,
            hop: 0.4e-6,
            overhead: 0.3e-6,
            bandwidth: 12e9,
            inner_latency: 0.5e-6,
            inner_bandwidth: 8e9,
            ranks: 8,
            machines: 32,
            taper: 2.0,
            noise: 0.0,
        }
    }
}

/// Keys of `--network` with their meaning.
pub const KEYS: [(&str, &str); 10] = [
    ("latency", "us, from machine to machine below one switch"),
    ("hop", "us, more through upper switches"),
    ("overhead", "us, of the processor for sending or receiving a message"),
    ("bandwidth", "GB/s of a machine, shared by its ranks"),
    ("inner-latency", "us, within a machine"),
    ("inner-bandwidth", "GB/s of each rank, within a machine"),
    ("ranks", "ranks that share a machine"),
    ("machines", "machines below one switch"),
    ("taper", "what machines below a switch can send over what it passes on"),
    ("noise", "mean of the random part of a rank's task time, as a fraction"),
];

impl Cluster {
    /// No time for any message.
    pub fn free() -> Self {
        let all = f64::INFINITY;
        Self {
            latency: 0.0,
            hop: 0.0,
            overhead: 0.0,
            bandwidth: all,
            inner_latency: 0.0,
            inner_bandwidth: all,
            ..Self::default()
        }
    }

    /// Factor of the time of a rank's tasks in a tick: the same for the same rank and tick (SplitMix64).
    pub fn slowness(&self, rank: u64, tick: u64) -> f64 {
        let mut z = (rank << 20 ^ tick).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ z >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        let unit = (((z ^ z >> 31) >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
        1.0 - self.noise * unit.ln()
    }

    /// Sets what `key=value` says, in the units of [`KEYS`].
    ///
    /// # Errors
    /// An unknown key, or a value that makes no sense.
    pub fn set(&mut self, pair: &str) -> Result<(), String> {
        let known = || KEYS.map(|(key, _)| key).join(", ");
        let (key, text) =
            pair.split_once('=').ok_or_else(|| format!("{pair}: write key=value with one of {}", known()))?;
        let (key, value) = (key.trim(), text.trim().parse::<f64>());
        let value = value.ok().filter(|x| x.is_finite() && *x >= 0.0);
        let value = value.ok_or_else(|| format!("{pair}: {:?} is no number from 0", text.trim()))?;
        let positive = |x: f64| if x > 0.0 { Ok(x) } else { Err(format!("{pair}: it must be more than 0")) };
        let count = |x: f64| {
            if x >= 1.0 && x.fract() == 0.0 {
                Ok(x as usize)
            } else {
                Err(format!("{pair}: a whole number from 1"))
            }
        };
        match key {
            "latency" => self.latency = 1e-6 * value,
            "hop" => self.hop = 1e-6 * value,
            "overhead" => self.overhead = 1e-6 * value,
            "bandwidth" => self.bandwidth = 1e9 * positive(value)?,
            "inner-latency" => self.inner_latency = 1e-6 * value,
            "inner-bandwidth" => self.inner_bandwidth = 1e9 * positive(value)?,
            "ranks" => self.ranks = count(value)?,
            "machines" => self.machines = count(value)?,
            "taper" => self.taper = positive(value)?,
            "noise" => self.noise = value,
            _ => return Err(format!("{pair}: there is no {key}; choose one of {}", known())),
        }
        Ok(())
    }
}

impl Display for Cluster {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let us = |x: f64| 1e6 * x;
        writeln!(
            f,
            "network        latency {:.2} us, {:.2} us more through upper switches, {:.2} us of a processor for each end of a \
             message;\n               {:.1} GB/s a machine, shared by {} ranks; {} machines a switch, taper {}:1;\n               \
             within a machine {:.2} us, {:.1} GB/s a rank",
            us(self.latency),
            us(self.hop),
            us(self.overhead),
            1e-9 * self.bandwidth,
            self.ranks,
            self.machines,
            self.taper,
            us(self.inner_latency),
            1e-9 * self.inner_bandwidth
        )?;
        if self.noise > 0.0 {
            let mean = 100.0 * self.noise;
            writeln!(
                f,
                "noise          tasks of a rank take {mean:.1} % longer in the mean, exponentially distributed"
            )?;
        }
        Ok(())
    }
}

impl Display for PhaseCost {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Once(ns) => write!(f, "{:.1} us once", 1e-3 * ns),
            Self::Particles(all) => {
                let all: Vec<String> = all.iter().map(|ns| format!("{ns:.1}")).collect();
                write!(f, "{} ns a particle (by material)", all.join("/"))
            }
            Self::Nodes(ns) => write!(f, "{ns:.0} ns a block of nodes"),
        }
    }
}

impl Display for Costs {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let phases: Vec<String> = self.phases.iter().map(ToString::to_string).collect();
        writeln!(
            f,
            "costs          of the phases: {};\n               \
             the engine: {:.0} ns a block, {:.0} ns a patch, {:.1} us a tick, {:.0} ns a block to look for who leaves;\n               \
             {:.1} us to hand a slab to several workers; {:.3} ns to pack a byte, {:.3} ns to merge one;\n               \
             tasks take {:.2} times as long while all cores work",
            phases.join(", "),
            self.block,
            self.patch,
            1e-3 * self.step,
            self.relocate,
            1e-3 * self.fork,
            self.pack,
            self.merge,
            self.contention
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn network_settings_are_read_in_their_units_and_nonsense_is_refused() {
        let mut cluster = Cluster::default();
        for pair in ["latency=2", "bandwidth = 25", "ranks=16", "noise=0.02"] {
            cluster.set(pair).expect(pair);
        }
        assert_eq!((cluster.latency, cluster.bandwidth), (2e-6, 25e9));
        assert_eq!((cluster.ranks, cluster.noise), (16, 0.02));
        for (pair, part) in [
            ("latency", "key=value"),
            ("speed=1", "latency, hop"),
            ("latency=-1", "number from 0"),
            ("latency=inf", "number from 0"),
            ("bandwidth=0", "more than 0"),
            ("ranks=1.5", "whole number"),
        ] {
            let error = cluster.set(pair).expect_err(pair);
            assert!(error.contains(part), "{error}");
        }
    }
}
