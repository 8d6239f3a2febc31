//! Messages of the model that have been sent and not yet been taken.
use super::wires::Moment;

/// What messages are about: all ranks number their exchanges and reductions in the same way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// An exchange of a tick (both counted from the beginning); `None`: travelers.
    Exchange(u32, Option<u32>),
    /// A part of a reduction (counted from the beginning), from a rank.
    Reduction(u32, u32),
}

/// Messages about the same.
#[derive(Clone, Copy, Debug)]
struct Pile {
    topic: Topic,
    count: u32,
    latest: Moment,
}

/// The messages for all ranks. Each has few at a time.
pub struct Mail(Vec<Vec<Pile>>);

impl Mail {
    /// No messages for `ranks` ranks.
    pub fn new(ranks: usize) -> Self {
        Self(vec![Vec::new(); ranks])
    }

    /// A message will arrive.
    pub fn put(&mut self, rank: usize, topic: Topic, arrival: Moment) {
        match self.0[rank].iter_mut().find(|pile| pile.topic == topic) {
            Some(pile) => (pile.count, pile.latest) = (pile.count + 1, pile.latest.or_later(arrival)),
            None => self.0[rank].push(Pile { topic, count: 1, latest: arrival }),
        }
    }

    /// When the last of `count` messages arrives, if all have been sent.
    pub fn all(&self, rank: usize, topic: Topic, count: u32) -> Option<Moment> {
        if count == 0 {
            return Some(Moment::default());
        }
        let pile = self.0[rank].iter().find(|pile| pile.topic == topic);
        pile.filter(|pile| pile.count == count).map(|pile| pile.latest)
    }

    /// The same; the messages are taken.
    pub fn take(&mut self, rank: usize, topic: Topic, count: u32) -> Option<Moment> {
        let arrival = self.all(rank, topic, count)?;
        self.0[rank].retain(|pile| pile.topic != topic);
        Some(arrival)
    }
}
