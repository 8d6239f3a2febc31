//! What the ranks of the model have to do and to send.
use super::model::{PhaseCost, Setup};
use super::step::Tick;
use engine::exec::order::Part;
use engine::exec::wave::GRAIN;
use engine::graph::phase::Phase;
use engine::graph::traffic::{LINE, Pairs, Traffic};

/// The work of a rank in a tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Load {
    /// Tasks by phase, on the rim and in the interior [ns on one worker].
    pub work: Vec<[f64; 2]>,
    /// Blocks of particles on the rim and in the interior.
    pub blocks: [f64; 2],
    /// What the engine does before the first task [ns].
    pub lists: f64,
    /// Looking for particles that leave [ns].
    pub relocate: f64,
    /// Slabs that the interior is worked on in.
    pub slabs: usize,
}

/// A message.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Message {
    /// To whom.
    pub to: u32,
    /// Its length [B].
    pub bytes: f32,
}

/// The ranks and who is beside whom. Ticks are known by their kind.
pub trait Ranks {
    /// How many.
    fn count(&self) -> usize;

    /// The work of one of them.
    fn load(&self, rank: usize, kind: usize) -> &Load;

    /// What it sends in an exchange; `None`: its travelers.
    fn sends(&self, rank: usize, kind: usize, exchange: Option<usize>, messages: &mut Vec<Message>);
}

/// Bytes of a message of travelers: they are few, and their number is a line.
pub const TRAVELERS: f32 = LINE as f32;

/// A rank's counts, before they are costs. Pairs are of the rim and of the interior.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Counts {
    /// Particles by material.
    pub particles: Vec<[f64; 2]>,
    /// Blocks of particles by material.
    pub blocks: Vec<[f64; 2]>,
    /// Blocks of nodes, by the materials of the fields that they hold.
    pub nodes: Vec<(Vec<usize>, [f64; 2])>,
    /// Patches.
    pub patches: f64,
}

/// What comes to a rank in an exchange.
#[derive(Clone, Copy, Debug, Default)]
pub struct Coming {
    /// Messages.
    pub messages: u32,
    /// Their bytes.
    pub bytes: f32,
}

/// What comes to each rank in a kind of tick, by exchange; travelers are the last.
pub fn coming<R: Ranks + ?Sized>(ranks: &R, exchanges: usize, kind: usize) -> Vec<Vec<Coming>> {
    let mut messages = Vec::new();
    let of = |exchange| {
        let mut coming = vec![Coming::default(); ranks.count()];
        for rank in 0..ranks.count() {
            ranks.sends(rank, kind, exchange, &mut messages);
            for message in &messages {
                let to = &mut coming[message.to as usize];
                *to = Coming { messages: to.messages + 1, bytes: to.bytes + message.bytes };
            }
        }
        coming
    };
    (0..exchanges).map(Some).chain([None]).map(of).collect()
}

impl Load {
    /// Seconds of a phase on some blocks, `slow` times as slow as they are, as the workers of a rank share them: the last of
    /// them ends half a block after the mean.
    pub fn seconds(&self, setup: &Setup<'_>, phase: usize, part: Part, slow: f64) -> f64 {
        let (costs, workers) = (&setup.costs, setup.threads as f64);
        let (which, slabs) = match part {
            Part::Slab(_) | Part::Interior(_) => (1, self.slabs as f64),
            Part::Rim => (0, 1.0),
        };
        if self.work[phase][which] <= 0.0 {
            return 0.0;
        }
        let alone = self.work[phase][which] / slabs * costs.contention * slow;
        let block = alone * slabs / self.blocks[which].max(1.0);
        let uneven = match setup.threads {
            1 => 0.0,
            _ => costs.fork + 0.5 * block * (workers - 1.0) / workers,
        };
        1e-9 * (alone / workers + uneven).min(alone + costs.fork)
    }
}

impl Counts {
    /// What it costs in a tick.
    pub fn load(&self, setup: &Setup<'_>, tick: &Tick) -> Load {
        let costs = &setup.costs;
        let sum = |some: &dyn Fn(usize) -> bool| {
            let some = self.blocks.iter().enumerate().filter(|(m, _)| some(*m));
            some.fold([0.0; 2], |sum, (_, blocks)| add(sum, *blocks, 1.0))
        };
        let [all, acting, ending] =
            [sum(&|_| true), sum(&|m| tick.acts(m)), sum(&|m| tick.schedule.ends(m))].map(|it| it[0] + it[1]);
        // as `exec::wave` does, which cuts between layers
        let slabs = if 2.0 * acting > all { (all / (GRAIN * setup.threads) as f64) as usize } else { 1 };
        Load {
            work: self.work(setup, tick),
            blocks: sum(&|m| tick.acts(m)),
            lists: costs.step + costs.block * acting + costs.patch * self.patches,
            relocate: costs.relocate * ending,
            slabs: slabs.max(1),
        }
    }

    fn work(&self, setup: &Setup<'_>, tick: &Tick) -> Vec<[f64; 2]> {
        let phases = setup.step.graph.phases.iter().zip(&setup.costs.phases);
        let one = |(phase, cost): (&Phase, &PhaseCost)| match cost {
            PhaseCost::Once(ns) => [0.0, *ns],
            PhaseCost::Particles(ns) => {
                let acting = self.particles.iter().zip(ns).enumerate().filter(|(m, _)| tick.works(phase, *m));
                acting.fold([0.0; 2], |sum, (_, (count, ns))| add(sum, *count, *ns))
            }
            PhaseCost::Nodes(ns) => {
                let some = |of: &[usize]| of.iter().any(|&m| tick.works(phase, m));
                let acting = self.nodes.iter().filter(|(of, _)| some(of));
                acting.fold([0.0; 2], |sum, (of, count)| add(sum, *count, of.len() as f64 * ns))
            }
        };
        phases.map(one).collect()
    }
}

fn add(sum: [f64; 2], more: [f64; 2], factor: f64) -> [f64; 2] {
    [sum[0] + factor * more[0], sum[1] + factor * more[1]]
}

/// Ranks that are listed one by one.
#[derive(Clone, Debug, Default)]
pub struct Listed {
    /// Their work, by kind of tick and rank.
    pub loads: Vec<Vec<Load>>,
    /// What they send, by kind of tick, exchange and rank.
    pub sends: Vec<Vec<Vec<Vec<Message>>>>,
    /// Who is in sight of each.
    pub beside: Vec<Vec<u32>>,
}

impl Listed {
    /// Ranks with their counts, and what they send each other.
    pub fn new(counts: &[Counts], traffic: &Traffic, setup: &Setup<'_>) -> Self {
        let (kinds, exchanges) = (&setup.step.kinds, &setup.step.graph.exchanges);
        let by_sender = |pairs: Pairs| {
            let mut sends = vec![Vec::new(); counts.len()];
            for ((from, to), messages) in pairs {
                sends[from].push(Message { to: to as u32, bytes: messages.bytes as f32 });
            }
            sends
        };
        let sends = |tick: &Tick| {
            let pairs = exchanges.iter().map(|it| traffic.exchange(it, |material| tick.sends(it, material)));
            pairs.map(by_sender).collect()
        };
        let mut beside = vec![Vec::new(); counts.len()];
        traffic.neighbors.iter().for_each(|&(from, to)| beside[from].push(to as u32));
        let loads = |tick| counts.iter().map(|it| it.load(setup, tick)).collect();
        Self { loads: kinds.iter().map(loads).collect(), sends: kinds.iter().map(sends).collect(), beside }
    }
}

impl Ranks for Listed {
    fn count(&self) -> usize {
        self.beside.len()
    }

    fn load(&self, rank: usize, kind: usize) -> &Load {
        &self.loads[kind][rank]
    }

    fn sends(&self, rank: usize, kind: usize, exchange: Option<usize>, messages: &mut Vec<Message>) {
        messages.clear();
        match exchange {
            Some(exchange) => messages.extend_from_slice(&self.sends[kind][exchange][rank]),
            None => messages.extend(self.beside[rank].iter().map(|&to| Message { to, bytes: TRAVELERS })),
        }
    }
}
