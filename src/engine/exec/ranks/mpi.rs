//! Ranks as processes, by MPI: <https://www.mpi-forum.org/docs/mpi-3.1/mpi31-report.pdf>.
//!
//! All calls come from the thread that started MPI (funneled). Messages travel by nonblocking calls whose memory this
//! module owns until they are done; that is what the unsafe code here is for, because the safe interface of the crate
//! binds requests to a scope, and a step is no scope.
#![allow(unsafe_code)]
use super::threading::Threading;
use super::{Channel, Network, NetworkError};
use mpi::Count;
use mpi::datatype::{Equivalence, UserDatatype};
use mpi::environment::Universe;
use mpi::ffi::{self, MPI_Comm, MPI_Message, MPI_Request, MPI_Status};
use mpi::raw::AsRaw;
use mpi::topology::{Communicator, SimpleCommunicator};
use simd::{LANES, Wide};
use std::ffi::c_int;
use std::mem::MaybeUninit;
use std::time::{Duration, Instant};

/// How long a rank that stops waits for its last messages to leave.
const PATIENCE: Duration = Duration::from_secs(5);
/// Between two looks at a barrier.
const NAP: Duration = Duration::from_millis(1);
/// Messages whose memory is kept.
const KEPT: usize = 64;

/// The ranks of `mpirun`.
pub struct Mpi {
    world: SimpleCommunicator,
    /// On this machine.
    neighbors: usize,
    threading: Threading,
    sends: Vec<Pending>,
    receives: Vec<Posted>,
    memory: Vec<Vec<Wide>>,
    /// A message that MPI has no number for: whoever waits for anything hears of it.
    refused: Option<NetworkError>,
    /// Whether all ranks have come to their end.
    parted: bool,
    /// What messages are counted in: with numbers, those of 16 GiB would be too many for MPI to count.
    line: UserDatatype,
    /// Ends MPI when it is dropped: after everything else.
    _universe: Universe,
}

/// A send under way.
struct Pending {
    channel: Channel,
    request: MPI_Request,
    message: Vec<Wide>,
}

/// A receive under way.
struct Posted {
    from: usize,
    channel: Channel,
    request: MPI_Request,
    message: Vec<Wide>,
}

impl Mpi {
    /// Starts MPI; `None` if it was started before in this process.
    pub fn start() -> Option<Self> {
        let (universe, granted) = mpi::initialize_with_threading(mpi::Threading::Funneled)?;
        let world = universe.world();
        Some(Self {
            neighbors: world.split_shared(world.rank()).size() as usize,
            threading: granted.into(),
            world,
            sends: Vec::new(),
            receives: Vec::new(),
            memory: Vec::new(),
            refused: None,
            parted: false,
            line: UserDatatype::contiguous(LANES as Count, &f64::equivalent_datatype()),
            _universe: universe,
        })
    }

    /// Whether the launcher forgets how ranks ended once it has passed a signal on to them (Hydra, of MPICH).
    fn forgets(&self) -> bool {
        mpi::environment::library_version().is_ok_and(|name| name.contains("MPICH"))
    }

    /// What MPI grants to the threads of this process.
    pub fn threading(&self) -> Threading {
        self.threading
    }

    /// How many ranks share this machine, this one included.
    pub fn ranks_here(&self) -> usize {
        self.neighbors
    }

    fn raw(&self) -> MPI_Comm {
        self.world.as_raw()
    }

    /// Forgets sends that are done.
    fn reap(&mut self) {
        let mut at = 0;
        while at < self.sends.len() {
            let mut done = 0;
            // SAFETY: the request is one of ours and under way; MPI_Test sets it to null when it is done, and then it is
            // dropped with its memory
            unsafe { ffi::MPI_Test(&mut self.sends[at].request, &mut done, ffi::RSMPI_STATUS_IGNORE) };
            if done == 0 {
                at += 1;
                continue;
            }
            let Pending { channel, message, .. } = self.sends.swap_remove(at);
            if channel.is_of_every_tick() {
                self.give_back(message);
            }
        }
    }

    /// The receive that was posted first for a channel, if any.
    fn posted(&self, from: usize, channel: Channel) -> Option<usize> {
        self.receives.iter().position(|posted| (posted.from, posted.channel) == (from, channel))
    }

    /// A posted receive whose request is done.
    fn take(&mut self, at: usize, status: &MPI_Status) -> Result<Vec<Wide>, NetworkError> {
        let Posted { from, channel, mut message, .. } = self.receives.remove(at);
        let (_, lines) = self.count(status, from, channel)?;
        debug_assert!(lines <= message.capacity());
        // SAFETY: MPI has written this many lines to the memory of the vector, which is as large as was posted
        unsafe { message.set_len(lines) };
        Ok(message)
    }

    /// Lines of a message, as MPI counts them and as we do.
    fn count(
        &self,
        status: &MPI_Status,
        rank: usize,
        channel: Channel,
    ) -> Result<(Count, usize), NetworkError> {
        let mut count: Count = 0;
        // SAFETY: the status is that of a message that came
        unsafe { ffi::MPI_Get_count(status, self.line.as_raw(), &mut count) };
        lines_of(count).map(|lines| (count, lines)).ok_or(NetworkError::Torn { rank, channel })
    }

    /// An error that concerns whoever waits for a message.
    fn refused(&self) -> Result<(), NetworkError> {
        self.refused.map_or(Ok(()), Err)
    }

    /// Whether MPI can count the lines of a message; a refusal is told to whoever waits next, for a rank that did not
    /// send or expect what others rely on cannot go on.
    fn countable(&mut self, rank: usize, channel: Channel, lines: usize) -> Option<Count> {
        match count_of(rank, channel, lines) {
            Ok(count) => Some(count),
            Err(error) => {
                self.refused.get_or_insert(error);
                None
            }
        }
    }

    /// Receives a message that nobody expected; waits for it only if `wait`.
    fn probe(
        &mut self,
        from: usize,
        channel: Channel,
        wait: bool,
    ) -> Result<Option<Vec<Wide>>, NetworkError> {
        let mut handle = MaybeUninit::<MPI_Message>::uninit();
        let mut status = MaybeUninit::<MPI_Status>::uninit();
        let mut flag: c_int = 1;
        let (source, tag, comm) = (from as c_int, channel.tag(), self.raw());
        // SAFETY: out-parameters point to memory for one value each
        unsafe {
            match wait {
                true => ffi::MPI_Mprobe(source, tag, comm, handle.as_mut_ptr(), status.as_mut_ptr()),
                false => {
                    ffi::MPI_Improbe(source, tag, comm, &mut flag, handle.as_mut_ptr(), status.as_mut_ptr())
                }
            }
        };
        if flag == 0 {
            return Ok(None);
        }
        // SAFETY: a message was found, so the status is set
        let (count, lines) = self.count(unsafe { status.assume_init_ref() }, from, channel)?;
        let mut message = self.memory(lines);
        // SAFETY: a message was found, so both are set; the memory holds as many lines as the message
        unsafe {
            let (memory, status) = (message.as_mut_ptr().cast(), status.as_mut_ptr());
            ffi::MPI_Mrecv(memory, count, self.line.as_raw(), handle.as_mut_ptr(), status);
            message.set_len(lines);
        }
        Ok(Some(message))
    }
}

impl From<mpi::Threading> for Threading {
    fn from(level: mpi::Threading) -> Self {
        match level {
            mpi::Threading::Single => Self::Single,
            mpi::Threading::Funneled => Self::Funneled,
            mpi::Threading::Serialized => Self::Serialized,
            mpi::Threading::Multiple => Self::Multiple,
        }
    }
}

/// The lines of a message in numbers of MPI.
///
/// # Errors
/// More than it has numbers for.
fn count_of(rank: usize, channel: Channel, lines: usize) -> Result<Count, NetworkError> {
    Count::try_from(lines).map_err(|_| NetworkError::TooLong { rank, channel, lines })
}

/// The lines that MPI has counted. It answers `MPI_UNDEFINED`, which is negative, to what is no whole number of lines.
fn lines_of(count: Count) -> Option<usize> {
    usize::try_from(count).ok()
}

impl Network for Mpi {
    fn rank(&self) -> usize {
        self.world.rank() as usize
    }

    fn size(&self) -> usize {
        self.world.size() as usize
    }

    fn admits_threads(&self) -> bool {
        self.threading.admits(2)
    }

    fn send(&mut self, to: usize, channel: Channel, message: Vec<Wide>) {
        self.reap();
        let Some(count) = self.countable(to, channel, message.len()) else { return };
        let mut request = MaybeUninit::<MPI_Request>::uninit();
        let (to, tag, comm, line) = (to as c_int, channel.tag(), self.raw(), self.line.as_raw());
        // SAFETY: the vector's memory stays where it is, and is not touched, until the request is done
        let request = unsafe {
            ffi::MPI_Isend(message.as_ptr().cast(), count, line, to, tag, comm, request.as_mut_ptr());
            request.assume_init()
        };
        self.sends.push(Pending { channel, request, message });
    }

    fn expect(&mut self, from: usize, channel: Channel, most: usize) {
        let Some(count) = self.countable(from, channel, most) else { return };
        let mut message = self.memory(most);
        let mut request = MaybeUninit::<MPI_Request>::uninit();
        let (source, tag, comm, line) = (from as c_int, channel.tag(), self.raw(), self.line.as_raw());
        // SAFETY: the vector has room for `most` lines, and its memory stays where it is until the request is done
        let request = unsafe {
            let memory = message.as_mut_ptr().cast();
            ffi::MPI_Irecv(memory, count, line, source, tag, comm, request.as_mut_ptr());
            request.assume_init()
        };
        self.receives.push(Posted { from, channel, request, message });
    }

    fn arrived(&mut self, from: usize, channel: Channel) -> Result<Option<Vec<Wide>>, NetworkError> {
        self.refused()?;
        let Some(at) = self.posted(from, channel) else { return self.probe(from, channel, false) };
        let (mut done, mut status) = (0, MaybeUninit::<MPI_Status>::uninit());
        // SAFETY: the request is one of ours and under way; the status is read only if it is done
        let done = unsafe {
            ffi::MPI_Test(&mut self.receives[at].request, &mut done, status.as_mut_ptr());
            (done != 0).then(|| status.assume_init())
        };
        done.map(|status| self.take(at, &status)).transpose()
    }

    fn receive(&mut self, from: usize, channel: Channel) -> Result<Vec<Wide>, NetworkError> {
        self.refused()?;
        let Some(at) = self.posted(from, channel) else {
            return self.probe(from, channel, true)?.ok_or(NetworkError::Lost { rank: from });
        };
        let mut status = MaybeUninit::<MPI_Status>::uninit();
        // SAFETY: the request is one of ours and under way; MPI_Wait sets the status
        let status = unsafe {
            ffi::MPI_Wait(&mut self.receives[at].request, status.as_mut_ptr());
            status.assume_init()
        };
        self.take(at, &status)
    }

    fn settle(&mut self) {
        while !self.sends.is_empty() {
            self.reap();
            std::thread::yield_now();
        }
    }

    fn memory(&mut self, lines: usize) -> Vec<Wide> {
        let mut memory = self.memory.pop().unwrap_or_default();
        memory.clear();
        memory.reserve(lines);
        memory
    }

    fn message(&mut self, lines: usize) -> Vec<Wide> {
        // what an old message holds need not be cleared
        let mut message = self.memory.pop().unwrap_or_default();
        message.resize(lines, Wide::default());
        message
    }

    fn give_back(&mut self, message: Vec<Wide>) {
        if self.memory.len() < KEPT {
            self.memory.push(message);
        }
    }

    fn part(&mut self, patience: Option<Duration>) -> bool {
        if self.refused.is_some() {
            // others wait for what was never sent
            return false;
        }
        let began = Instant::now();
        let patient = || patience.is_none_or(|most| began.elapsed() < most);
        if !self.parted {
            let mut request = MaybeUninit::<MPI_Request>::uninit();
            // SAFETY: a barrier that each rank enters once, and that is complete before MPI ends
            let mut request = unsafe {
                ffi::MPI_Ibarrier(self.raw(), request.as_mut_ptr());
                request.assume_init()
            };
            let mut done = 0;
            while done == 0 && patient() {
                // SAFETY: the request is under way
                unsafe { ffi::MPI_Test(&mut request, &mut done, ffi::RSMPI_STATUS_IGNORE) };
                std::thread::sleep(NAP);
            }
            self.parted = done != 0;
        }
        while !self.sends.is_empty() && patient() {
            self.reap();
        }
        self.parted && self.sends.is_empty()
    }

    fn end_by_signal(&mut self, status: i32) {
        if self.forgets() {
            self.part(None);
            // that it does not forget
            self.world.abort(status);
        }
    }

    fn abort(&mut self, status: i32) {
        self.world.abort(status);
    }
}

impl Drop for Mpi {
    /// Drains what is under way: nobody else may write to memory that is given back.
    fn drop(&mut self) {
        for mut posted in std::mem::take(&mut self.receives) {
            // SAFETY: the request is one of ours and under way; after the wait it is done or cancelled
            unsafe {
                ffi::MPI_Cancel(&mut posted.request);
                ffi::MPI_Wait(&mut posted.request, ffi::RSMPI_STATUS_IGNORE);
            }
        }
        if std::thread::panicking() || !self.part(Some(PATIENCE)) {
            // somebody does not listen any more, and without that nobody would end
            self.world.abort(1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_as_long_as_mpi_can_count_lines() {
        let count = |lines| count_of(3, Channel::Patches, lines);
        // 2^31 numbers, which wrapped when numbers were counted, are 2^28 lines
        for lines in [0, 1, (1 << 28) - 1, 1 << 28, (1 << 29) + 1, (1 << 31) - 1] {
            let counted = count(lines).expect("few enough");
            assert_eq!(lines_of(counted), Some(lines));
        }
        for lines in [1 << 31, (1 << 31) + 1, 1 << 32, (1 << 61) + 1, usize::MAX] {
            let error = count(lines).expect_err("too many");
            assert_eq!(error, NetworkError::TooLong { rank: 3, channel: Channel::Patches, lines });
            for fact in [&lines.to_string(), "rank 3", "Patches", "2147483647", "--patches"] {
                assert!(error.to_string().contains(fact), "{error}");
            }
        }
        assert_eq!(lines_of(ffi::MPI_UNDEFINED), None);
        assert_eq!(lines_of(Count::MIN), None);
    }
}
