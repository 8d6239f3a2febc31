//! Where stages run, and where the labels of blocks are meanwhile.
use super::Executor;
use super::ranks::halos::{Incoming, Outgoing};
use super::work::{self, Blocks, Call, Which};
use crate::data::spread::Spread;
use crate::graph::exchange::Exchange;
use crate::graph::phase::Phase;

/// Runs stages on blocks. A stage says which labels it reads and writes, and of which blocks around; a backend may have them
/// in memory of its own, and hands them to the host only where the host asks: see [`Backend::download`]. What a block is, and
/// which blocks there are, the host knows always.
///
/// Every [`Executor`] is a backend whose memory is the host's. What passes between ranks is the business of
/// [`ranks::Network`](super::ranks::Network). Work of the host that is no stage it only spreads.
pub trait Backend: Spread + Send {
    /// Number of workers, each with a scratch of its own.
    fn workers(&self) -> usize;

    /// Runs `work`, which calls the backend often, where that costs least.
    fn enter(&self, work: &mut (dyn FnMut() + Send)) {
        work();
    }

    /// Runs the stages of a phase over blocks, on some of them, each once and in any order.
    fn run(&self, call: &mut Call<'_>, phase: &Phase, which: Which<'_>, data: &mut Blocks<'_>);

    /// Packs partial sums of blocks that add to nodes of another rank.
    fn pack(&self, outgoing: &mut [Outgoing<'_>]);

    /// Puts partial sums of another rank's blocks in their place.
    fn unpack(&self, incoming: &mut [Incoming<'_>]);

    /// The host is about to read labels of blocks, and perhaps to write them.
    fn download(&self, _purpose: Purpose<'_>, _data: &mut Blocks<'_>) {}

    /// The host has read and written them.
    fn upload(&self, _purpose: Purpose<'_>, _data: &mut Blocks<'_>) {}
}

/// What the host wants labels of blocks for.
#[derive(Clone, Copy, Debug)]
pub enum Purpose<'a> {
    /// An exchange packs or unpacks its labels: of particle blocks, their partial sums; of node blocks, their values.
    Exchange(&'a Exchange),
    /// Blocks of nodes come and go: those that stay keep the labels that nodes store.
    Activation,
    /// Particles change their block: all their labels, in blocks that are marked as left.
    Relocation,
    /// A program begins or has ended: all that passes from one to the next.
    Program,
}

impl<E: Executor> Backend for E {
    fn workers(&self) -> usize {
        Executor::workers(self)
    }

    fn enter(&self, work: &mut (dyn FnMut() + Send)) {
        Executor::enter(self, work);
    }

    fn run(&self, call: &mut Call<'_>, phase: &Phase, which: Which<'_>, data: &mut Blocks<'_>) {
        match phase.is_over_nodes() {
            true => work::over_nodes(self, call, phase, which, data),
            false => work::over_particles(self, call, phase, which, data),
        }
    }

    fn pack(&self, outgoing: &mut [Outgoing<'_>]) {
        self.each(outgoing, |_, it| it.pack());
    }

    fn unpack(&self, incoming: &mut [Incoming<'_>]) {
        self.each(incoming, |_, it| it.unpack());
    }
}

impl<E: Executor> Spread for E {
    fn spread(&self, count: usize, work: &(dyn Fn(usize) + Sync)) {
        let mut numbers: Vec<usize> = (0..count).collect();
        self.each(&mut numbers, |_, &mut number| work(number));
    }
}
