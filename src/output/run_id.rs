//! Who wrote a file: each run has an identity, which its index, its frames and its checkpoints carry, so that none of them
//! passes for another run's.
use super::stored::word;
use engine::exec::ranks::{Network, NetworkError, collective};
use hdf5::types::VarLenUnicode;
use hdf5::{Error, Group};
use std::fmt;
use std::hash::{BuildHasher, RandomState};
use std::time::SystemTime;
use twox_hash::XxHash3_128;

/// Under which name files state whose they are.
pub const NAME: &str = "run";

/// The identity of a run, the same after its restarts; written as 32 hexadecimal digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct RunId(u128);

impl RunId {
    /// A new one, which no other run has.
    pub fn new() -> Self {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        // the keys of hash maps are the randomness that the standard library gives
        let random = RandomState::new().hash_one(std::process::id());
        let mut words = now.as_nanos().to_le_bytes().to_vec();
        words.extend(random.to_le_bytes());
        Self(XxHash3_128::oneshot(&words))
    }

    /// The one that rank 0 makes, on all ranks.
    ///
    /// # Errors
    /// If a rank is gone.
    pub fn common(network: &mut dyn Network) -> Result<Self, NetworkError> {
        let bytes = collective::bytes_from_first(network, &Self::new().0.to_le_bytes())?;
        Ok(Self(u128::from_le_bytes(bytes.try_into().unwrap_or_default())))
    }

    /// States it in a file or a group.
    ///
    /// # Errors
    /// If HDF5 cannot write it.
    pub fn write(self, group: &Group) -> hdf5::Result<()> {
        self.write_as(group, NAME)
    }

    /// The same under another name.
    ///
    /// # Errors
    /// If HDF5 cannot write it.
    pub fn write_as(self, group: &Group, name: &str) -> hdf5::Result<()> {
        group.new_attr::<VarLenUnicode>().create(name)?.write_scalar(&word(&self.to_string())?)
    }

    /// What a file or a group states.
    ///
    /// # Errors
    /// If it states none.
    pub fn read(group: &Group) -> hdf5::Result<Self> {
        Self::read_as(group, NAME)
    }

    /// The same under another name.
    ///
    /// # Errors
    /// If it states none.
    pub fn read_as(group: &Group, name: &str) -> hdf5::Result<Self> {
        let text = group.attr(name)?.read_scalar::<VarLenUnicode>()?.to_string();
        let number = u128::from_str_radix(&text, 16);
        number.map(Self).map_err(|_| Error::Internal(format!("{text:?} is no identity of a run")))
    }
}

impl fmt::Display for RunId {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_are_the_same() {
        let all: std::collections::HashSet<_> = (0..10_000).map(|_| RunId::new()).collect();
        assert_eq!(all.len(), 10_000);
    }
}
