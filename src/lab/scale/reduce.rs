//! The rounds of a reduction in the model: those of `exec::ranks::collective::reduce`.
use super::wires::Moment;

/// What a rank does next in a reduction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// Sends to a rank; the message goes to [`Rounds::place`] of its inbox.
    Send(usize),
    /// Takes the message of [`Rounds::place`].
    Receive,
    /// Both reductions are done.
    End,
}

/// Where a rank is in the two reductions of a tick.
///
/// Its acts are numbered: place 0 is what happens before the rounds between ranks beyond the last power of two and their
/// partners, places 1, 2, … are the rounds, and the last one is what happens after them; in each, sending comes first.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rounds {
    act: u16,
    /// The second reduction of the tick.
    pub second: bool,
    done: bool,
    /// Whether the message of this act is about to leave.
    pub sending: bool,
    /// Whether the rank waits for a message.
    pub stuck: bool,
}

/// Places of a reduction in an inbox: before the rounds, 30 rounds, after them.
const PLACES: usize = 32;
const AFTER: usize = PLACES - 1;

impl Rounds {
    /// The beginning.
    pub fn begin(rank: usize, ranks: usize) -> Self {
        let mut rounds = Self::default();
        rounds.settle(rank, ranks);
        rounds
    }

    /// Which place of an inbox this act is about.
    pub fn place(&self) -> usize {
        self.number() + if self.second { PLACES } else { 0 }
    }

    fn number(&self) -> usize {
        usize::from(self.act / 2)
    }

    /// What comes now.
    pub fn act(&self, rank: usize, ranks: usize) -> Act {
        let whole = 1usize << ranks.ilog2();
        match (self.done, self.act % 2) {
            (true, _) => Act::End,
            (_, 1) => Act::Receive,
            _ if (1..AFTER).contains(&self.number()) => Act::Send(rank ^ 1 << (self.number() - 1)),
            _ if rank >= whole => Act::Send(rank - whole),
            _ => Act::Send(rank + whole),
        }
    }

    /// On to the next act.
    pub fn step(&mut self, rank: usize, ranks: usize) {
        self.act += 1;
        self.settle(rank, ranks);
    }

    /// Skips acts that are not this rank's.
    fn settle(&mut self, rank: usize, ranks: usize) {
        let whole = 1usize << ranks.ilog2();
        let (extra, rounds) = (ranks - whole, whole.ilog2() as usize);
        let beyond = rank >= whole;
        while !self.done {
            let (number, sends) = (self.number(), self.act.is_multiple_of(2));
            let mine = match number {
                0 => (beyond && sends) || (rank < extra && !sends),
                AFTER => (beyond && !sends) || (rank < extra && sends),
                round => !beyond && round <= rounds,
            };
            if mine {
                return;
            }
            self.act += 1;
            if self.number() > AFTER {
                (self.act, self.done, self.second) = (0, self.second, true);
            }
        }
    }
}

/// Messages of reductions that are on their way or wait for their receiver.
pub struct Inbox {
    /// `[rank][tick % 2][place]`: index in `moments`, or [`NOTHING`].
    places: Vec<u32>,
    moments: Vec<Moment>,
    free: Vec<u32>,
}

const NOTHING: u32 = u32::MAX;

impl Inbox {
    /// Empty.
    pub fn new(ranks: usize) -> Self {
        Self { places: vec![NOTHING; ranks * 4 * PLACES], moments: Vec::new(), free: Vec::new() }
    }

    fn at(rank: usize, tick: usize, place: usize) -> usize {
        (2 * rank + tick % 2) * 2 * PLACES + place
    }

    /// A message arrives at some moment.
    pub fn put(&mut self, rank: usize, tick: usize, place: usize, arrival: Moment) {
        let index = self.free.pop().unwrap_or_else(|| {
            self.moments.push(Moment::default());
            self.moments.len() as u32 - 1
        });
        self.moments[index as usize] = arrival;
        self.places[Self::at(rank, tick, place)] = index;
    }

    /// The message, if it was sent.
    pub fn take(&mut self, rank: usize, tick: usize, place: usize) -> Option<Moment> {
        let place = &mut self.places[Self::at(rank, tick, place)];
        let index = std::mem::replace(place, NOTHING);
        (index != NOTHING).then(|| {
            self.free.push(index);
            self.moments[index as usize]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Acts of a rank in both reductions, with their places.
    fn acts(rank: usize, ranks: usize) -> Vec<(Act, usize)> {
        let mut rounds = Rounds::begin(rank, ranks);
        let mut acts = Vec::new();
        while rounds.act(rank, ranks) != Act::End {
            acts.push((rounds.act(rank, ranks), rounds.place()));
            rounds.step(rank, ranks);
        }
        acts
    }

    #[test]
    fn every_message_is_sent_once_and_received_once_in_its_place() {
        for ranks in 1..40 {
            let (mut sent, mut received) = (Vec::new(), Vec::new());
            for rank in 0..ranks {
                for (act, place) in acts(rank, ranks) {
                    match act {
                        Act::Send(to) => sent.push((to, place)),
                        Act::Receive => received.push((rank, place)),
                        Act::End => {}
                    }
                }
            }
            let whole = 1usize << ranks.ilog2();
            assert_eq!(sent.len(), 2 * (whole * whole.ilog2() as usize + 2 * (ranks - whole)), "{ranks}");
            sent.sort_unstable();
            received.sort_unstable();
            assert_eq!(sent, received, "{ranks}");
        }
    }
}
