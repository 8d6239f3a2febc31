//! Frames of a run. Each rank takes a copy of its rows, and writes them as a part of the frame beside the steps; rank 0 gets
//! their counts and digests when all parts are there, and names them in the index, beside the steps, too. One frame is on its
//! way at most. Ranks that do not see the folder send their rows to rank 0, which has them in its part.
use super::seen;
use crate::output::beside::Beside;
use crate::output::frame::{Head, Piece};
use crate::output::run_id::RunId;
use crate::output::vtkhdf::{self, CHUNK, FileId, Part, PartFile, Writer};
use crate::output::{self, parcel, seal, together};
use crate::simulation::{Simulation, Snapshot};
use engine::exec::ranks::{Network, collective};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::Instant;

/// Pieces of other ranks that wait for the disk at most, beside those of this one.
const WAITING: usize = 2;

/// The frames of a run, as a rank sees them. All ranks call what is here, unless it says otherwise.
pub struct Frames {
    index: PathBuf,
    run: RunId,
    /// Of this start of the run: whose parts belong together.
    writing: RunId,
    /// Which ranks write their own rows.
    sees: Vec<bool>,
    /// Number of the next frame.
    next: u64,
    /// How many of the first frames are there, with none missing between them.
    whole: u64,
    /// The step of the last frame that is there.
    last: Option<u64>,
    flight: Flight,
    /// On rank 0, while it is not at work.
    writer: Option<Writer>,
    /// Parts of this rank of which the disk may not have all.
    unsynced: Vec<PathBuf>,
}

/// What is on its way. All ranks are in the same phase.
enum Flight {
    Nothing,
    /// The parts of a frame; this rank's, if it has one.
    Parts {
        number: u64,
        head: Head,
        mine: Option<(FileId, Job<output::Result<Part>>)>,
    },
    /// The index, on rank 0.
    Index {
        number: u64,
        step: u64,
        job: Option<Job<(Writer, output::Result<()>)>>,
    },
}

/// One that has begun, or why it could not.
type Job<T> = output::Result<Beside<T>>;

fn is_done<T: Send + 'static>(job: &Job<T>) -> bool {
    job.as_ref().map_or(true, Beside::is_done)
}

impl Frames {
    /// Those from number `next` on, of a run in a folder; rank 0 has the writer.
    ///
    /// # Errors
    /// If the folder cannot be written, or a rank is gone.
    pub fn new(
        network: &mut dyn Network,
        index: &Path,
        run: RunId,
        next: u64,
        writer: Option<Writer>,
    ) -> output::Result<Self> {
        let writing = RunId::common(network)?;
        let sees = seen::folder(network, index, writing)?;
        let (index, unsynced) = (index.into(), Vec::new());
        let flight = Flight::Nothing;
        Ok(Self { index, run, writing, sees, next, whole: next, last: None, flight, writer, unsynced })
    }

    /// Number of frames that were begun so far, whether all are still there or not.
    pub fn begun(&self) -> u64 {
        self.next
    }

    /// Whether the first `count` frames are written and named.
    pub fn has(&self, count: u64) -> bool {
        self.whole >= count
    }

    /// Whether this start of the run has written a frame of a step.
    pub fn shows(&self, step: u64) -> bool {
        self.last == Some(step)
    }

    /// Whether something is on its way, and this rank has done its part of that. For one rank.
    pub fn is_done(&self) -> bool {
        match &self.flight {
            Flight::Nothing => false,
            Flight::Parts { mine, .. } => mine.as_ref().is_none_or(|(_, job)| is_done(job)),
            Flight::Index { job, .. } => job.as_ref().is_none_or(is_done),
        }
    }

    /// Begins a frame, when the one before is written, and if the folder is `held`.
    ///
    /// # Errors
    /// If the frame before could not be written, or this one cannot be begun: on all ranks.
    pub fn begin(
        &mut self,
        simulation: &mut Simulation,
        held: &dyn Fn() -> output::Result<()>,
    ) -> output::Result<()> {
        self.settle(simulation.network(), held)?;
        let (time, step) = (simulation.clock().time, simulation.steps());
        let Simulation { scene, warehouse, network, .. } = simulation;
        let network = &mut **network;
        let snapshot = Snapshot::new(scene, warehouse);
        let columns = snapshot.columns();
        let admitted = || self.writer.as_ref().map_or(Ok(()), |writer| writer.admits(&columns));
        together::agree(network, held().and_then(|()| admitted()))?;
        let counts = collective::share(network, &[snapshot.particles() as u64])?;
        let counts: Vec<usize> = counts.iter().map(|count| count[0] as usize).collect();
        let head = Head { time, step, particles: counts.iter().sum(), columns };
        let number = self.next;
        self.next += 1;
        let mine = self.write(network, &snapshot, &counts, (number, &head))?;
        self.flight = Flight::Parts { number, head, mine };
        Ok(())
    }

    /// Begins this rank's part, and gives it all its rows.
    fn write(
        &self,
        network: &mut dyn Network,
        snapshot: &Snapshot,
        counts: &[usize],
        (number, head): (u64, &Head),
    ) -> output::Result<Option<(FileId, Job<output::Result<Part>>)>> {
        let rank = network.rank();
        let sends = |other: usize| !self.sees[other] && counts[other] > 0;
        if sends(rank) {
            let before = (0..rank).filter(|&other| other == 0 || sends(other));
            parcel::hand_over(network, |give| snapshot.pieces(before.map(|other| counts[other]).sum(), give));
            return Ok(None);
        }
        let rows = rows(counts, &self.sees);
        let writers: Vec<usize> = (0..rows.len()).filter(|&other| rows[other] > 0).collect();
        // a frame of no particles is a file of rank 0
        let writers = if writers.is_empty() { vec![0] } else { writers };
        let Some(part) = writers.iter().position(|&writer| writer == rank) else { return Ok(None) };
        let id = FileId { number, parts: writers.len(), part };
        let threads = network.admits_threads();
        let pieces = |rows: usize| rows.div_ceil(CHUNK);
        // where nobody takes them meanwhile all must find room
        let all = || counts.iter().map(|&count| pieces(count) + 1).sum();
        let most = if threads { pieces(snapshot.particles()) + WAITING } else { all() };
        let (give, pieces) = sync_channel(most);
        let (index, runs) = (self.index.clone(), [self.run, self.writing]);
        let head = Head { particles: rows[rank], ..head.clone() };
        let job =
            Beside::begin(&id.path(&self.index), threads, move || part_file(&index, id, runs, head, pieces));
        // one that has failed takes nothing more, and says so at its end
        let mut give = |piece: Piece| drop(give.send(piece));
        snapshot.pieces(0, &mut give);
        if rank == 0 {
            let mut others = (1..counts.len()).filter(|&other| sends(other));
            others.try_for_each(|other| parcel::receive(network, other, &mut give))?;
        }
        Ok(Some((id, job)))
    }

    /// Waits until all that was begun is written and named, as far as the index is to name it at once.
    ///
    /// # Errors
    /// If it cannot be written: on all ranks.
    pub fn settle(
        &mut self,
        network: &mut dyn Network,
        held: &dyn Fn() -> output::Result<()>,
    ) -> output::Result<()> {
        while !matches!(self.flight, Flight::Nothing) {
            self.advance(network, held)?;
        }
        Ok(())
    }

    /// Waits for what is on its way, and begins what comes after it.
    ///
    /// # Errors
    /// If it could not be written: on all ranks.
    pub fn advance(
        &mut self,
        network: &mut dyn Network,
        held: &dyn Fn() -> output::Result<()>,
    ) -> output::Result<()> {
        match std::mem::replace(&mut self.flight, Flight::Nothing) {
            Flight::Nothing => Ok(()),
            Flight::Parts { number, head, mine } => {
                let path = mine.as_ref().map(|(id, _)| id.path(&self.index));
                let written = mine.map(|(_, job)| job.and_then(|job| job.end().transpose()));
                let written = written.transpose().map(Option::flatten);
                together::agree(network, held())?;
                let part = match together::agree(network, written) {
                    Ok(part) => part,
                    Err(error) => {
                        // best effort: a part of a frame of which others are missing
                        path.iter().for_each(|path| drop(output::create::remove(path)));
                        return Err(error);
                    }
                };
                self.unsynced.extend(path);
                let parts = gather(network, part)?;
                let step = head.step;
                let job = self.name(network.admits_threads(), (number, head), parts);
                self.flight = Flight::Index { number, step, job };
                Ok(())
            }
            Flight::Index { number, step, job } => {
                let named = job.map_or(Ok(()), |job| {
                    let (writer, named) = job?.end().unzip();
                    self.writer = writer;
                    named.unwrap_or(Ok(()))
                });
                together::agree(network, named)?;
                self.whole += u64::from(number == self.whole);
                self.last = Some(step);
                Ok(())
            }
        }
    }

    /// Begins to name a frame in the index, on rank 0.
    fn name(
        &mut self,
        threads: bool,
        (number, head): (u64, Head),
        parts: Vec<Part>,
    ) -> Option<Job<(Writer, output::Result<()>)>> {
        let mut writer = self.writer.take()?;
        writer.add(number, head, parts);
        Some(Beside::begin(&self.index, threads, move || {
            let named = writer.name_soon();
            (writer, named)
        }))
    }

    /// Waits until the disk has all frames, and the index names them.
    ///
    /// # Errors
    /// If it does not take them: on all ranks.
    pub fn sync(
        &mut self,
        network: &mut dyn Network,
        held: &dyn Fn() -> output::Result<()>,
    ) -> output::Result<()> {
        self.settle(network, held)?;
        let mut parts = || -> output::Result<()> {
            if self.unsynced.is_empty() {
                return Ok(());
            }
            self.unsynced.drain(..).try_for_each(|path| seal::sync(&path))?;
            seal::sync(&vtkhdf::folder(&self.index))
        };
        together::agree(network, parts())?;
        together::agree(network, self.writer.as_mut().map_or(Ok(()), Writer::sync))
    }
}

/// Writes a part of a frame, as its pieces come.
fn part_file(
    index: &Path,
    id: FileId,
    runs: [RunId; 2],
    head: Head,
    pieces: Receiver<Piece>,
) -> output::Result<Part> {
    let began = Instant::now();
    let mut file = PartFile::create(index, id, runs, head)?;
    for piece in pieces {
        file.piece(&piece)?;
    }
    let part = file.finish()?;
    tracing::debug!(
        file = id.name(),
        seconds = began.elapsed().as_secs_f64(),
        "a part of a frame is written"
    );
    Ok(part)
}

/// How many rows each rank writes.
fn rows(counts: &[usize], sees: &[bool]) -> Vec<usize> {
    let mut rows: Vec<usize> =
        counts.iter().zip(sees).map(|(&count, &sees)| if sees { count } else { 0 }).collect();
    rows[0] += counts.iter().sum::<usize>() - rows.iter().sum::<usize>();
    rows
}

/// The parts of all ranks, in their order, on rank 0.
fn gather(network: &mut dyn Network, part: Option<Part>) -> output::Result<Vec<Part>> {
    use engine::exec::ranks::{pack, unpack};
    let halves = |digest: u128| [(digest >> 64) as u64, digest as u64];
    let words = part.map(|part| {
        let [high, low] = halves(part.digest);
        [part.particles as u64, high, low]
    });
    let mut parts = Vec::new();
    collective::gather(network, pack(words.as_ref().map_or(&[], |words| &words[..])), |_, message| {
        if let &[particles, high, low] = unpack(message) {
            let digest = u128::from(high) << 64 | u128::from(low);
            parts.push(Part { particles: particles as usize, digest });
        }
    })?;
    Ok(parts)
}
