//! The rim of a rank: blocks that give to other ranks come first, and those that wait for other ranks as soon as the
//! messages are here; the interior is worked on meanwhile.
use super::Executor;
use super::ranks::ghosts::Ghosts;
use super::ranks::{Channel, Network, NetworkError};
use super::trace::Event;
use super::work::{Blocks, Which, Work};
use crate::data::labels::LabelId;
use crate::graph::fuse::Phase;
use crate::graph::task::Domain;
use crate::simd::Wide;
use std::ops::Range;

/// How far the rim is in a wave.
pub struct Border<'a> {
    network: &'a mut dyn Network,
    ghosts: &'a Ghosts,
    /// Number of the first phase in the graph, and the phases.
    phases: (usize, &'a [Phase]),
    /// All layers of the level.
    layers: Range<i32>,
    /// The phase that the rim comes to next.
    next: usize,
    /// The channel and the ranks whose messages that phase waits for.
    outstanding: Vec<(Channel, usize)>,
}

/// How a halo travels.
fn channel(label: LabelId) -> Channel {
    if label == LabelId::NodeMotion { Channel::Motion } else { Channel::Sums }
}

impl<'a> Border<'a> {
    /// The rim before the first of `phases`, of which the first has a number in the graph.
    pub fn new(
        network: &'a mut dyn Network,
        ghosts: &'a Ghosts,
        phases: (usize, &'a [Phase]),
        layers: Range<i32>,
    ) -> Self {
        Self { network, ghosts, phases, layers, next: 0, outstanding: Vec::new() }
    }

    /// Works on the rim as far as messages are here. Unless `last`, the interior goes on afterwards.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn advance<E: Executor>(
        &mut self,
        work: &mut Work<'_, E>,
        data: &mut Blocks<'_>,
        last: bool,
    ) -> Result<(), NetworkError> {
        while let Some(phase) = self.phases.1.get(self.next) {
            let over_nodes = phase.stages.first().is_some_and(|stage| stage.domain == Domain::Nodes);
            // particles read the motion of interior nodes too
            if self.next > 0 && !over_nodes && !last {
                return Ok(());
            }
            self.collect(work, data, last)?;
            if !self.outstanding.is_empty() {
                return Ok(());
            }
            work.over(phase, Which::Rim(&self.layers), data);
            self.send(phase, work, data);
            self.next += 1;
            self.await_next(work);
        }
        Ok(())
    }

    /// The messages that the next phase needs.
    pub fn await_next<E: Executor>(&mut self, work: &Work<'_, E>) {
        let Some(phase) = self.phases.1.get(self.next) else { return };
        let mut channels: Vec<Channel> = phase.halos.iter().map(|&label| channel(label)).collect();
        channels.dedup();
        for channel in channels {
            let schedule = work.context.schedule;
            let senders: Vec<(usize, usize)> = match channel {
                Channel::Motion => self.ghosts.showers(schedule).collect(),
                _ => self.ghosts.givers(schedule).collect(),
            };
            for (rank, most) in senders {
                self.network.expect(rank, channel, most);
                self.outstanding.push((channel, rank));
            }
        }
    }

    /// Takes in what has arrived; waits for the rest if there is nothing else to do.
    fn collect<E: Executor>(
        &mut self,
        work: &mut Work<'_, E>,
        data: &mut Blocks<'_>,
        wait: bool,
    ) -> Result<(), NetworkError> {
        if self.outstanding.is_empty() {
            return Ok(());
        }
        let began = work.watch.trace.now();
        for (channel, rank) in std::mem::take(&mut self.outstanding) {
            let message = match wait {
                true => Some(self.network.receive(rank, channel)?),
                false => self.network.arrived(rank, channel)?,
            };
            let Some(message) = message else {
                self.outstanding.push((channel, rank));
                continue;
            };
            let (schedule, from) = (work.context.schedule, (rank, &message[..]));
            match channel {
                Channel::Motion => self.ghosts.see(from, schedule, data.particles, data.nodes)?,
                _ => {
                    let workers = (work.executor, work.context.buffers);
                    self.ghosts.take(from, schedule, data.particles, workers)?;
                }
            }
            self.network.give_back(message);
        }
        work.watch.trace.record(0, began, Event::halo(self.phases.0 + self.next));
        Ok(())
    }

    /// Sends what a phase is the last to write.
    fn send<E: Executor>(&mut self, phase: &Phase, work: &Work<'_, E>, data: &Blocks<'_>) {
        let mut channels: Vec<Channel> = phase.sends.iter().map(|&label| channel(label)).collect();
        channels.dedup();
        for channel in channels {
            let (schedule, began) = (work.context.schedule, work.watch.trace.now());
            let [messages, lines] = match channel {
                Channel::Motion => self.ghosts.show(self.network, schedule, data.particles, data.nodes),
                _ => self.ghosts.give(self.network, schedule, data.particles, work.executor),
            };
            let event = Event::halo(self.phases.0 + self.next).sent(messages, lines * size_of::<Wide>());
            work.watch.trace.record(0, began, event);
        }
    }
}
