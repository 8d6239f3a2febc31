//! What messages between two ranks take.
use engine::exec::ranks::{Channel, Network, NetworkError};
use serde::{Deserialize, Serialize};
use simd::Wide;
use std::time::Instant;

/// Times of messages between ranks 0 and 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ping {
    /// On the way, without the work of the processors on both sides [s].
    pub latency: f64,
    /// Of a processor, to send or to receive a message [s].
    pub overhead: f64,
    /// Of long messages [B/s].
    pub bandwidth: f64,
}

/// Round trips of one line, and of [`LONG`] lines.
const TRIPS: usize = 2000;
const LONG_TRIPS: usize = 200;
/// Lines of a long message: 1 MiB.
const LONG: usize = 1 << 14;

/// Sends messages to and fro between ranks 0 and 1; others return at once.
///
/// # Errors
/// If a rank is gone.
pub fn ping(network: &mut dyn Network) -> Result<Option<Ping>, NetworkError> {
    if network.rank() > 1 || network.size() < 2 {
        return Ok(None);
    }
    let [short, send] = trips(network, 1, TRIPS)?;
    let [long, _] = trips(network, LONG, LONG_TRIPS)?;
    let (half, bytes) = (0.5 * short, (LONG * size_of::<Wide>()) as f64);
    let overhead = send.min(0.5 * half);
    // where other work gets in between, what is short may take as long as what is long
    let bandwidth = bytes / (0.5 * long - half).max(0.25 * long);
    Ok(Some(Ping { latency: (half - 2.0 * overhead).max(0.0), overhead, bandwidth }))
}

/// Seconds of a round trip of messages of some lines, and of sending one; seen from rank 0. One trip in ten is quicker:
/// interruptions only add.
fn trips(network: &mut dyn Network, lines: usize, count: usize) -> Result<[f64; 2], NetworkError> {
    let first = network.rank() == 0;
    let peer = usize::from(first);
    let mut message = vec![Wide::default(); lines];
    let mut times = [Vec::with_capacity(count), Vec::with_capacity(count)];
    for _ in 0..count {
        let began = Instant::now();
        if !first {
            message = network.receive(peer, Channel::Output)?;
        }
        let leaves = Instant::now();
        network.send(peer, Channel::Output, std::mem::take(&mut message));
        times[1].push(leaves.elapsed().as_secs_f64());
        if first {
            message = network.receive(peer, Channel::Output)?;
        }
        times[0].push(began.elapsed().as_secs_f64());
    }
    Ok(times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 10).copied().unwrap_or_default()
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::exec::ranks::local::Local;

    #[test]
    fn two_ranks_answer_and_a_third_does_not_take_part() {
        let answers: Vec<Option<Ping>> = std::thread::scope(|scope| {
            let ranks = Local::crew(3).into_iter();
            let threads: Vec<_> = ranks.map(|mut rank| scope.spawn(move || ping(&mut rank))).collect();
            let answers = threads.into_iter().map(|thread| thread.join().expect("a rank ends"));
            answers.map(|answer| answer.expect("nobody is gone")).collect()
        });
        assert_eq!(answers[2], None);
        let ping = answers[0].expect("an answer");
        assert!(ping.latency >= 0.0 && ping.overhead > 0.0 && ping.bandwidth.is_finite());
    }
}
