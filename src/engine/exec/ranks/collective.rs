//! What all ranks do together, made of messages between two. All of them must call it, in the same order.
use super::words::{put, take};
use super::{Channel, Network, NetworkError, pack, unpack};
use simd::Wide;

/// What a rank does in a reduction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// Sends what it has.
    Send(usize),
    /// Receives what another rank has, and merges it.
    Merge(usize),
    /// Receives the result.
    Receive(usize),
}

/// The acts of a rank in a reduction, by number, in order; `None`: it is done. Recursive doubling; R. Thakur, R. Rabenseifner,
/// W. Gropp, IJHPCA 19, 2005, 49–66. Ranks beyond the last power of two have a partner below it.
pub fn act(rank: usize, size: usize, number: usize) -> Option<Act> {
    let whole = 1usize << size.ilog2();
    let rounds = 2 * whole.ilog2() as usize;
    if rank >= whole {
        return [Act::Send(rank - whole), Act::Receive(rank - whole)].get(number).copied();
    }
    let partner = Some(rank + whole).filter(|&partner| partner < size);
    let number = match (partner, number) {
        (Some(partner), 0) => return Some(Act::Merge(partner)),
        (Some(_), number) => number - 1,
        (None, number) => number,
    };
    if number < rounds {
        let peer = rank ^ 1 << (number / 2);
        return Some(if number.is_multiple_of(2) { Act::Send(peer) } else { Act::Merge(peer) });
    }
    partner.filter(|_| number == rounds).map(Act::Send)
}

/// All acts of a rank in a reduction.
pub fn acts(rank: usize, size: usize) -> impl Iterator<Item = Act> {
    (0..).map_while(move |number| act(rank, size, number))
}

/// Merges the messages of all ranks: afterwards each has the result. `merge` must commute and associate exactly, then all
/// have the same bits.
///
/// # Errors
/// If a rank is gone.
pub fn reduce(
    network: &mut dyn Network,
    message: &mut Vec<Wide>,
    mut merge: impl FnMut(&mut [Wide], &[Wide]),
) -> Result<(), NetworkError> {
    for act in acts(network.rank(), network.size()) {
        match act {
            Act::Send(to) => {
                let mut copy = network.memory(message.len());
                copy.extend_from_slice(message);
                network.send(to, Channel::Reduction, copy);
            }
            Act::Merge(from) => {
                let part = network.receive(from, Channel::Reduction)?;
                merge(message, &part);
                network.give_back(part);
            }
            Act::Receive(from) => *message = network.receive(from, Channel::Reduction)?,
        }
    }
    Ok(())
}

/// Number by number, the sums of what the ranks have (wrapping).
///
/// # Errors
/// If a rank is gone.
pub fn sum(network: &mut dyn Network, words: &mut [u64]) -> Result<(), NetworkError> {
    if network.size() == 1 {
        return Ok(());
    }
    let mut message = pack(words);
    reduce(network, &mut message, |into, from| {
        let into: &mut [u64] = bytemuck::cast_slice_mut(into);
        let pairs = into.iter_mut().zip(bytemuck::cast_slice::<_, u64>(from));
        pairs.skip(1).for_each(|(a, &b)| *a = a.wrapping_add(b));
    })?;
    words.copy_from_slice(unpack(&message));
    Ok(())
}

/// Gives the message of rank 0 to all.
///
/// # Errors
/// If a rank is gone.
pub fn broadcast(network: &mut dyn Network, message: &mut Vec<Wide>) -> Result<(), NetworkError> {
    let (rank, size) = (network.rank(), network.size());
    if rank > 0 {
        // from the rank without this one's lowest bit
        *message = network.receive(rank & (rank - 1), Channel::Reduction)?;
    }
    let bits = if rank == 0 { usize::BITS } else { rank.trailing_zeros() };
    let to = (0..bits).rev().map_while(|bit| rank.checked_add(1usize.checked_shl(bit)?));
    for to in to.filter(|&to| to < size) {
        network.send(to, Channel::Reduction, message.clone());
    }
    Ok(())
}

/// Brings the messages of all ranks to rank 0, which takes them in the order of ranks.
///
/// # Errors
/// If a rank is gone.
pub fn gather(
    network: &mut dyn Network,
    message: Vec<Wide>,
    mut take: impl FnMut(usize, &[Wide]),
) -> Result<(), NetworkError> {
    if network.rank() > 0 {
        network.send(0, Channel::Reduction, message);
        return Ok(());
    }
    take(0, &message);
    for rank in 1..network.size() {
        take(rank, &network.receive(rank, Channel::Reduction)?);
    }
    Ok(())
}

/// The messages of all ranks, on each of them: for small ones.
///
/// # Errors
/// If a rank is gone.
pub fn share(network: &mut dyn Network, words: &[u64]) -> Result<Vec<Vec<u64>>, NetworkError> {
    let mut all = Vec::new();
    gather(network, pack(words), |_, message| {
        let words = unpack(message);
        all.push(words.len() as u64);
        all.extend_from_slice(words);
    })?;
    let mut message = pack(&all);
    broadcast(network, &mut message)?;
    let mut rest = unpack(&message);
    let mut lists = Vec::with_capacity(network.size());
    while let Some((&count, after)) = rest.split_first() {
        let (list, others) = after.split_at((count as usize).min(after.len()));
        lists.push(list.to_vec());
        rest = others;
    }
    Ok(lists)
}

/// What rank 0 says, on all ranks.
///
/// # Errors
/// If a rank is gone.
pub fn bytes_from_first(network: &mut dyn Network, bytes: &[u8]) -> Result<Vec<u8>, NetworkError> {
    let mut words = Vec::new();
    put(&mut words, bytes);
    let mut message = pack(&words);
    broadcast(network, &mut message)?;
    Ok(take::<u8>(&mut unpack(&message)))
}

/// The first rank that failed, and why, if one did; the same on all ranks.
///
/// # Errors
/// If a rank is gone.
pub fn first_error(
    network: &mut dyn Network,
    mine: Option<&str>,
) -> Result<Option<(usize, String)>, NetworkError> {
    let mut words = Vec::new();
    if let Some(text) = mine {
        put(&mut words, text.as_bytes());
    }
    let all = share(network, &words)?;
    let failed = all.iter().enumerate().find(|(_, words)| !words.is_empty());
    Ok(failed.map(|(rank, words)| (rank, text_of(words))))
}

fn text_of(mut words: &[u64]) -> String {
    String::from_utf8_lossy(&take::<u8>(&mut words)).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_message_of_a_reduction_is_sent_once_and_received_once() {
        for size in 1..40 {
            let (mut sent, mut received) = (Vec::new(), Vec::new());
            for rank in 0..size {
                for act in acts(rank, size) {
                    match act {
                        Act::Send(to) => sent.push((rank, to)),
                        Act::Merge(from) | Act::Receive(from) => received.push((from, rank)),
                    }
                }
            }
            let whole = 1usize << size.ilog2();
            assert_eq!(sent.len(), whole * whole.ilog2() as usize + 2 * (size - whole), "{size}");
            sent.sort_unstable();
            received.sort_unstable();
            assert_eq!(sent, received, "{size}");
            sent.dedup();
            assert_eq!(sent.len(), received.len(), "two ranks meet once: {size}");
        }
    }
}
