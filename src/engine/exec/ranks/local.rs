//! Ranks as threads of one process: for tests, and where there is no MPI.
use super::{Channel, Network, NetworkError};
use simd::Wide;
use std::collections::{HashMap, VecDeque};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

type Letter = (Channel, Vec<Wide>);

/// One of several ranks in a process.
#[derive(Debug)]
pub struct Local {
    rank: usize,
    to: Vec<Sender<Letter>>,
    from: Vec<Receiver<Letter>>,
    /// Messages that came before one of another channel.
    early: HashMap<(usize, Channel), VecDeque<Vec<Wide>>>,
}

impl Local {
    /// `size` ranks that know each other.
    pub fn crew(size: usize) -> Vec<Local> {
        let (mut to, mut from): (Vec<_>, Vec<_>) = (0..size).map(|_| (Vec::new(), Vec::new())).unzip();
        for sender in 0..size {
            for receiver in &mut from {
                let (send, receive) = channel();
                to[sender].push(send);
                Vec::push(receiver, receive);
            }
        }
        let ranks = to.into_iter().zip(from).enumerate();
        ranks.map(|(rank, (to, from))| Local { rank, to, from, early: HashMap::new() }).collect()
    }

    fn kept(&mut self, from: usize, channel: Channel) -> Option<Vec<Wide>> {
        self.early.get_mut(&(from, channel))?.pop_front()
    }

    /// The letter, if it is on the channel; others are kept.
    fn sort(&mut self, from: usize, wanted: Channel, (channel, message): Letter) -> Option<Vec<Wide>> {
        if channel == wanted {
            return Some(message);
        }
        self.early.entry((from, channel)).or_default().push_back(message);
        None
    }
}

impl Network for Local {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn send(&mut self, to: usize, channel: Channel, message: Vec<Wide>) {
        // a rank that is gone is noticed by whoever waits for it
        let _ = self.to[to].send((channel, message));
    }

    fn expect(&mut self, _from: usize, _channel: Channel, _most: usize) {}

    fn arrived(&mut self, from: usize, channel: Channel) -> Result<Option<Vec<Wide>>, NetworkError> {
        if let Some(message) = self.kept(from, channel) {
            return Ok(Some(message));
        }
        loop {
            match self.from[from].try_recv() {
                Ok(letter) => {
                    if let Some(message) = self.sort(from, channel, letter) {
                        return Ok(Some(message));
                    }
                }
                Err(TryRecvError::Empty) => return Ok(None),
                Err(TryRecvError::Disconnected) => return Err(NetworkError::Lost { rank: from }),
            }
        }
    }

    fn receive(&mut self, from: usize, channel: Channel) -> Result<Vec<Wide>, NetworkError> {
        if let Some(message) = self.kept(from, channel) {
            return Ok(message);
        }
        loop {
            let letter = self.from[from].recv().map_err(|_| NetworkError::Lost { rank: from })?;
            if let Some(message) = self.sort(from, channel, letter) {
                return Ok(message);
            }
        }
    }

    fn settle(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exec::ranks::{collective, pack, unpack};

    /// Runs `work` on `size` ranks.
    fn together<T: Send>(size: usize, work: impl Fn(Local) -> T + Sync) -> Vec<T> {
        std::thread::scope(|scope| {
            let threads: Vec<_> =
                Local::crew(size).into_iter().map(|rank| scope.spawn(|| work(rank))).collect();
            threads.into_iter().map(|thread| thread.join().expect("a rank ends")).collect()
        })
    }

    #[test]
    fn collectives_give_all_ranks_the_same() {
        for size in 1..=9 {
            let results = together(size, |mut rank| {
                let me = rank.rank() as u64;
                let mut sums = [1, me, u64::MAX];
                collective::sum(&mut rank, &mut sums).expect("all are here");
                let mut word = pack(&[me + 7]);
                collective::broadcast(&mut rank, &mut word).expect("all are here");
                let lists = collective::share(&mut rank, &vec![me; me as usize]).expect("all are here");
                (sums, unpack(&word).to_vec(), lists)
            });
            let n = size as u64;
            let lists: Vec<Vec<u64>> = (0..n).map(|r| vec![r; r as usize]).collect();
            for result in results {
                assert_eq!(result, ([n, n * (n - 1) / 2, 0u64.wrapping_sub(n)], vec![7], lists.clone()));
            }
        }
    }

    #[test]
    fn a_rank_that_is_gone_is_named() {
        let results = together(2, |mut rank| match rank.rank() {
            0 => rank.receive(1, Channel::Halo(0)).map(|_| ()),
            _ => Ok(()),
        });
        assert_eq!(results[0], Err(NetworkError::Lost { rank: 1 }));
    }
}
