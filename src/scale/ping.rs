//! What messages between two ranks take.
use crate::exec::ranks::{Channel, Network, NetworkError};
use crate::simd::Wide;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// Times of messages between ranks 0 and 1, the best of several.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ping {
    /// On the way, without the work of the processors on both sides [s].
    pub latency: f64,
    /// Of a processor, to send or to receive a message [s].
    pub overhead: f64,
    /// Of long messages [B/s].
    pub bandwidth: f64,
}

/// Round trips of a batch.
const TRIPS: usize = 100;
const BATCHES: usize = 20;
/// Lines of a long message: 1 MiB.
const LONG: usize = 1 << 14;
const LONG_TRIPS: usize = 10;

/// Sends messages to and fro between ranks 0 and 1; others return at once.
///
/// # Errors
/// If a rank is gone.
pub fn ping(network: &mut dyn Network) -> Result<Option<Ping>, NetworkError> {
    if network.rank() > 1 || network.size() < 2 {
        return Ok(None);
    }
    let (mut half, mut send, mut long) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
    for _ in 0..BATCHES {
        let (trip, sending) = batch(network, 1, TRIPS)?;
        (half, send) = (half.min(0.5 * trip), send.min(sending));
        long = long.min(0.5 * batch(network, LONG, LONG_TRIPS)?.0);
    }
    let bytes = (LONG * size_of::<Wide>()) as f64;
    let overhead = send.min(0.5 * half);
    let bandwidth = bytes / (long - half).max(1e-9);
    Ok(Some(Ping { latency: (half - 2.0 * overhead).max(0.0), overhead, bandwidth }))
}

/// Seconds of a round trip of messages of some lines, and of sending one; seen from rank 0.
fn batch(network: &mut dyn Network, lines: usize, trips: usize) -> Result<(f64, f64), NetworkError> {
    let first = network.rank() == 0;
    let peer = usize::from(first);
    let mut message = vec![Wide::default(); lines];
    let (began, mut sending) = (Instant::now(), 0.0);
    for _ in 0..trips {
        if !first {
            message = network.receive(peer, Channel::Output)?;
        }
        let leaves = Instant::now();
        network.send(peer, Channel::Output, std::mem::take(&mut message));
        sending += leaves.elapsed().as_secs_f64();
        if first {
            message = network.receive(peer, Channel::Output)?;
        }
    }
    let trips = trips as f64;
    Ok((began.elapsed().as_secs_f64() / trips, sending / trips))
}
