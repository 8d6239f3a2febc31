//! What the time of a run went to, in sums.
use super::trace::{Event, Kind, NONE};

/// What the time of a worker, or of several, went to [ticks].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    kinds: [u64; Kind::ALL.len()],
    /// Waiting for other ranks.
    waiting: u64,
    /// Of tasks by graph, and by the first line of their stage in the recipe.
    stages: Vec<Vec<u64>>,
}

impl Spent {
    /// Adds a piece of work, of which a part was `waited`.
    #[inline]
    pub fn add(&mut self, event: &Event, waited: u64) {
        let worked = event.duration.saturating_sub(waited);
        self.waiting += waited;
        match event.kind {
            Kind::ReduceWait => self.waiting += worked,
            Kind::Task if event.place != NONE => {
                *self.slot(event.graph as usize, event.place as usize) += worked
            }
            kind => self.kinds[kind as usize] += worked,
        }
    }

    fn slot(&mut self, graph: usize, place: usize) -> &mut u64 {
        if self.stages.len() <= graph {
            self.stages.resize(graph + 1, Vec::new());
        }
        let places = &mut self.stages[graph];
        if places.len() <= place {
            places.resize(place + 1, 0);
        }
        &mut places[place]
    }

    /// Adds what another worker has done.
    pub fn merge(&mut self, other: &Spent) {
        self.kinds.iter_mut().zip(other.kinds).for_each(|(sum, more)| *sum += more);
        self.waiting += other.waiting;
        for (graph, places) in other.stages.iter().enumerate() {
            places.iter().enumerate().for_each(|(place, more)| *self.slot(graph, place) += more);
        }
    }

    /// Work on a stage: number of its graph, and the first of its lines in the recipe.
    pub fn stage(&self, graph: usize, place: usize) -> u64 {
        self.stages.get(graph).and_then(|places| places.get(place)).copied().unwrap_or(0)
    }

    /// Packing and unpacking what ranks send one another.
    pub fn exchange(&self) -> u64 {
        self.kinds[Kind::HaloWait as usize]
    }

    /// Waiting for other ranks.
    pub fn waiting(&self) -> u64 {
        self.waiting
    }

    /// Moving particles to other blocks and ranks.
    pub fn relocation(&self) -> u64 {
        self.kinds[Kind::Relocate as usize] + self.kinds[Kind::Arrange as usize]
    }

    /// Workers that had nothing to do while others of their rank worked.
    pub fn idle(&self) -> u64 {
        self.kinds[Kind::Idle as usize]
    }

    /// Writing results.
    pub fn output(&self) -> u64 {
        self.kinds[Kind::Output as usize]
    }
}
