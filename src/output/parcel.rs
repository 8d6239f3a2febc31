//! Arrays in messages to the rank that writes.
use super::frame::Piece;
use engine::exec::ranks::words::{put, take};
use engine::exec::ranks::{Channel, Network, NetworkError, pack, unpack};

/// Something that travels to rank 0.
pub trait Parcel: Sized {
    /// As words, at least one.
    fn words(&self) -> Vec<u64>;
    /// From its words.
    fn from_words(words: &[u64]) -> Self;
}

/// Brings the parcels of all ranks to rank 0, where `take` gets them one by one: its own first, then those of rank 1, 2, ….
/// `each` makes this rank's parcels; no rank holds more than one of them.
///
/// # Errors
/// If a rank is gone.
pub fn collect<P: Parcel>(
    network: &mut dyn Network,
    each: impl FnOnce(&mut dyn FnMut(P)),
    mut take: impl FnMut(P),
) -> Result<(), NetworkError> {
    if network.rank() > 0 {
        hand_over(network, each);
        return Ok(());
    }
    each(&mut take);
    (1..network.size()).try_for_each(|rank| receive(network, rank, &mut take))
}

/// Sends parcels to rank 0, which [`receive`]s them.
pub fn hand_over<P: Parcel>(network: &mut dyn Network, each: impl FnOnce(&mut dyn FnMut(P))) {
    each(&mut |parcel: P| {
        network.send(0, Channel::Output, pack(&parcel.words()));
        network.settle();
    });
    network.send(0, Channel::Output, pack(&[]));
}

/// Gives the parcels of a rank to `take`, one by one.
///
/// # Errors
/// If that rank is gone.
pub fn receive<P: Parcel>(
    network: &mut dyn Network,
    rank: usize,
    mut take: impl FnMut(P),
) -> Result<(), NetworkError> {
    loop {
        let message = network.receive(rank, Channel::Output)?;
        let words = unpack(&message);
        if words.is_empty() {
            return Ok(());
        }
        take(P::from_words(words));
    }
}

impl Parcel for Piece {
    fn words(&self) -> Vec<u64> {
        let mut words = Vec::new();
        put(&mut words, &self.identities);
        put(&mut words, &self.materials);
        put(&mut words, &self.positions);
        self.columns.iter().for_each(|column| put(&mut words, column));
        words
    }

    fn from_words(mut words: &[u64]) -> Self {
        let words = &mut words;
        let (identities, materials, positions) = (take(words), take(words), take(words));
        let mut columns = Vec::new();
        while !words.is_empty() {
            columns.push(take(words));
        }
        Piece { identities, materials, positions, columns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::exec::ranks::local::Local;

    fn piece(rank: u64, rows: u64) -> Piece {
        Piece {
            identities: (0..rows).map(|i| 100 * rank + i).collect(),
            materials: vec![300 + rank as u16; rows as usize],
            positions: (0..rows).map(|i| [i as f32, rank as f32, 0.5]).collect(),
            columns: vec![vec![1.0; 3 * rows as usize], vec![f32::NAN; rows as usize]],
        }
    }

    #[test]
    fn rank_0_gets_every_parcel_in_the_order_of_ranks() {
        let got = std::thread::scope(|scope| {
            let work = |mut network: Local| {
                let rank = network.rank() as u64;
                let mut got = Vec::new();
                let each = |give: &mut dyn FnMut(Piece)| (1..=rank).for_each(|rows| give(piece(rank, rows)));
                collect(&mut network, each, |piece| got.push(piece)).expect("all are here");
                got
            };
            let ranks: Vec<_> = Local::crew(4).into_iter().map(|n| scope.spawn(move || work(n))).collect();
            ranks.into_iter().map(|rank| rank.join().expect("a rank ends")).collect::<Vec<_>>()
        });
        let all: Vec<Piece> = (1..4).flat_map(|rank| (1..=rank).map(move |rows| piece(rank, rows))).collect();
        assert_eq!(format!("{:?}", got[0]), format!("{all:?}"));
        assert!(got[1..].iter().all(Vec::is_empty));
    }
}
