//! Exchanges of a wave as they are carried out: packed, sent, expected, taken in as they arrive.
use super::backend::{Backend, Purpose};
use super::ranks::halos::{Halos, Incoming, Outgoing};
use super::ranks::{Channel, Network, NetworkError};
use super::trace::Event;
use super::work::{Blocks, Call};
use crate::graph::exchange::{Exchange, Way};
use simd::Wide;

/// The messages of a wave.
pub struct Exchanges<'a> {
    backend: &'a dyn Backend,
    network: &'a mut dyn Network,
    halos: &'a Halos,
    all: &'a [Exchange],
    /// Exchanges that are expected, and the ranks whose messages have not come yet.
    outstanding: &'a mut Vec<(usize, usize)>,
}

impl<'a> Exchanges<'a> {
    /// The exchanges of a graph, between the ranks that `halos` knows. `memory` is empty.
    pub fn new(
        backend: &'a dyn Backend,
        network: &'a mut dyn Network,
        halos: &'a Halos,
        all: &'a [Exchange],
        memory: &'a mut Vec<(usize, usize)>,
    ) -> Self {
        Self { backend, network, halos, all, outstanding: memory }
    }

    /// Makes room for the messages of an exchange.
    pub fn expect(&mut self, number: usize, call: &Call<'_>) {
        let exchange = &self.all[number];
        for (rank, most) in self.halos.senders(exchange, &call.context) {
            self.network.expect(rank, Channel::Halo(number as u16), most);
            self.outstanding.push((number, rank));
        }
    }

    /// Packs and sends.
    pub fn send(&mut self, number: usize, call: &Call<'_>, data: &mut Blocks<'_>) {
        let (exchange, began) = (&self.all[number], call.watch.trace.now());
        let channel = Channel::Halo(number as u16);
        self.backend.download(Purpose::Exchange(exchange), data);
        let [messages, lines] = match exchange.way {
            Way::Partials => {
                let to = (&mut *self.network, channel);
                let pack = |outgoing: &mut [Outgoing<'_>]| self.backend.pack(outgoing);
                self.halos.send_partials(to, exchange, &call.context, data.particles, pack)
            }
            Way::Values => {
                let from = (&*data.particles, &*data.nodes);
                self.halos.send_values((&mut *self.network, channel), exchange, &call.context, from)
            }
        };
        self.backend.upload(Purpose::Exchange(exchange), data);
        if messages > 0 {
            let event = Event::halo(exchange.from.unwrap_or(exchange.to)).of_exchange(number);
            call.watch.trace.record(0, began, event.sent(messages, lines * size_of::<Wide>()));
        }
    }

    /// Takes in what has arrived of an exchange; waits for the rest if there is nothing else to do. Returns whether all is here.
    ///
    /// # Errors
    /// If a rank is gone, or a message has another length than the blocks say.
    pub fn take(
        &mut self,
        number: usize,
        call: &Call<'_>,
        data: &mut Blocks<'_>,
        wait: bool,
    ) -> Result<bool, NetworkError> {
        if !self.outstanding.iter().any(|(exchange, _)| *exchange == number) {
            return Ok(true);
        }
        let (exchange, began) = (&self.all[number], call.watch.trace.now());
        let channel = Channel::Halo(number as u16);
        let (mut at, before) = (0, self.outstanding.len());
        while at < self.outstanding.len() {
            let (which, rank) = self.outstanding[at];
            let message = match (which == number, wait) {
                (false, _) => None,
                (_, true) => {
                    let began = call.watch.trace.now();
                    let message = self.network.receive(rank, channel)?;
                    call.watch.trace.waited(0, began);
                    Some(message)
                }
                (_, false) => self.network.arrived(rank, channel)?,
            };
            let Some(message) = message else {
                at += 1;
                continue;
            };
            self.outstanding.swap_remove(at);
            let from = (rank, channel, &message[..]);
            self.backend.download(Purpose::Exchange(exchange), data);
            match exchange.way {
                Way::Partials => {
                    let unpack = |incoming: &mut [Incoming<'_>]| self.backend.unpack(incoming);
                    let into = (&mut *data.particles, unpack);
                    self.halos.unpack_partials(from, exchange, &call.context, into)?;
                }
                Way::Values => {
                    let into = (&*data.particles, &mut *data.nodes);
                    self.halos.unpack_values(from, exchange, &call.context, into)?;
                }
            }
            self.backend.upload(Purpose::Exchange(exchange), data);
            self.network.give_back(message);
        }
        // who only looked has not waited
        if self.outstanding.len() < before {
            call.watch.trace.record(0, began, Event::halo(exchange.to).of_exchange(number));
        }
        Ok(!self.outstanding.iter().any(|(exchange, _)| *exchange == number))
    }
}
