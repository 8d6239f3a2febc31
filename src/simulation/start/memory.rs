//! Whether the particles of all ranks fit into the memory of their machines.
use crate::input::{BYTES_PER_PARTICLE, available_memory};
use crate::simulation::RunError;
use engine::exec::ranks::{Network, NetworkError, collective, launch};
use twox_hash::XxHash3_128;

/// What a rank has to hold, and where.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// A number of its machine.
    pub machine: u64,
    /// Memory that new work can take there [B]; `u64::MAX`: nobody knows.
    pub available: u64,
    /// Particles.
    pub particles: u64,
}

impl Share {
    /// That of this rank.
    pub fn here(particles: u64) -> Self {
        let available = available_memory().map_or(u64::MAX, |bytes| bytes as u64);
        Self { machine: machine(), available, particles }
    }
}

/// A number of this machine.
fn machine() -> u64 {
    XxHash3_128::oneshot(launch::host().as_bytes()) as u64
}

/// The shares of all ranks.
///
/// # Errors
/// If a rank is gone.
pub fn shares(mine: Share, network: &mut dyn Network) -> Result<Vec<Share>, NetworkError> {
    let words = [mine.machine, mine.available, mine.particles];
    let share = |words: &Vec<u64>| match words[..] {
        [machine, available, particles] => Share { machine, available, particles },
        _ => mine,
    };
    Ok(collective::share(network, &words)?.iter().map(share).collect())
}

/// Memory of all machines together that new work can take [B], if it is known.
///
/// # Errors
/// If a rank is gone.
pub fn of_all_machines(network: &mut dyn Network) -> Result<Option<usize>, NetworkError> {
    let all = shares(Share::here(0), network)?;
    let first = |&rank: &usize| all[..rank].iter().all(|other| other.machine != all[rank].machine);
    let sum = (0..all.len()).filter(first).fold(0u64, |sum, rank| sum.saturating_add(all[rank].available));
    Ok((sum < u64::MAX).then(|| usize::try_from(sum).unwrap_or(usize::MAX)))
}

/// Whether each machine holds what its ranks have to.
///
/// # Errors
/// The first rank whose machine does not.
pub fn fits(shares: &[Share]) -> Result<(), RunError> {
    let bytes = |particles: u64| particles.saturating_mul(BYTES_PER_PARTICLE as u64);
    for (rank, share) in shares.iter().enumerate() {
        let beside: Vec<&Share> = shares.iter().filter(|other| other.machine == share.machine).collect();
        let all = beside.iter().map(|other| other.particles).fold(0, u64::saturating_add);
        if bytes(all) > share.available {
            return Err(RunError::Memory {
                rank,
                ranks: beside.len(),
                particles: share.particles,
                gigabytes: [share.particles, all].map(|n| bytes(n) as f64 / 1e9),
                available: share.available as f64 / 1e9,
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::exec::ranks::Alone;

    fn share(machine: u64, available: u64, particles: u64) -> Share {
        Share { machine, available, particles }
    }

    #[test]
    fn a_share_is_held_against_the_memory_of_its_machine() {
        let each = BYTES_PER_PARTICLE as u64;
        // on machines of their own, each with room for its share
        assert!(fits(&[share(1, 100 * each, 100), share(2, 100 * each, 90)]).is_ok());
        // on one machine they share it
        let error = fits(&[share(1, 100 * each, 40), share(2, 300 * each, 150), share(2, 300 * each, 151)]);
        let error = error.expect_err("too many").to_string();
        for fact in ["rank 1 ", "150 particles", "2 ranks", "--set domain.cell", "more machines"] {
            assert!(error.contains(fact), "{fact:?} is not in: {error}");
        }
        assert!(fits(&[share(1, u64::MAX, 1 << 60)]).is_ok(), "nobody knows");
        let mine = Share::here(17);
        assert_eq!(shares(mine, &mut Alone).expect("one rank"), [mine]);
        assert_eq!(of_all_machines(&mut Alone).expect("one rank"), available_memory());
    }
}
