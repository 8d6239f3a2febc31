//! The network of the model: which message arrives when.
use super::model::Cluster;

/// A moment on the way that leads to it, and what the time on that way went into.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// When [s].
    pub time: f64,
    /// Seconds by [`Cause`].
    pub parts: [f32; Cause::COUNT],
}

/// What time on the critical path goes into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Cause {
    /// Tasks.
    Compute,
    /// The engine outside tasks.
    Engine,
    /// Packing, unpacking, merging, and the processor's part of messages.
    Handling,
    /// Messages on their way.
    Latency,
    /// Bytes on their way, and waiting for those of others.
    Bandwidth,
}

impl Cause {
    /// Number of causes.
    pub const COUNT: usize = 5;
    /// Their names.
    pub const NAMES: [&str; Self::COUNT] = ["tasks", "engine", "message handling", "latency", "bandwidth"];
}

impl Moment {
    /// Some time later.
    #[inline]
    pub fn after(mut self, seconds: f64, cause: Cause) -> Self {
        self.time += seconds;
        self.parts[cause as usize] += seconds as f32;
        self
    }

    /// The later of two.
    #[inline]
    pub fn or_later(self, other: Self) -> Self {
        if other.time > self.time { other } else { self }
    }
}

/// The wires, and until when they are busy.
pub struct Wires {
    cluster: Cluster,
    machines: Vec<f64>,
    switches: Vec<f64>,
}

impl Wires {
    /// Idle wires between `ranks` ranks.
    pub fn new(cluster: &Cluster, ranks: usize) -> Self {
        let machines = ranks.div_ceil(cluster.ranks);
        let switches = machines.div_ceil(cluster.machines);
        Self { cluster: *cluster, machines: vec![0.0; machines], switches: vec![0.0; switches] }
    }

    /// When a message of some bytes that leaves `from` at `sent` is at `to`. Calls come in the order of `sent`.
    pub fn arrival(&mut self, from: usize, to: usize, bytes: f64, sent: Moment) -> Moment {
        let c = &self.cluster;
        let (here, there) = (from / c.ranks, to / c.ranks);
        if here == there {
            return sent
                .after(bytes / c.inner_bandwidth, Cause::Bandwidth)
                .after(c.inner_latency, Cause::Latency);
        }
        let begin = self.machines[here].max(sent.time);
        let mut end = begin + bytes / c.bandwidth;
        self.machines[here] = end;
        let (switch, other) = (here / c.machines, there / c.machines);
        let mut latency = c.latency;
        if switch != other {
            let rate = c.bandwidth * c.machines as f64 / c.taper;
            let through = self.switches[switch].max(begin) + bytes / rate;
            self.switches[switch] = through;
            end = end.max(through);
            latency += c.hop;
        }
        sent.after(end - sent.time, Cause::Bandwidth).after(latency, Cause::Latency)
    }
}
