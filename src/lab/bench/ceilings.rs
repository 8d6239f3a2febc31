//! What this machine can do at most: fused multiply-adds and copies, on one core and on all at once.
use serde::{Deserialize, Serialize};
use simd::{Isa, Job, LANES, Simd, Wide};
use std::hint::black_box;
use std::sync::Barrier;
use std::thread;
use std::time::Instant;

/// What some cores can do together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ceiling {
    /// Cores at once.
    pub threads: usize,
    /// Multiply-adds in double precision, each two operations [GFLOP/s].
    pub fma_gflop_per_s: f64,
    /// Copy between arrays far larger than the last cache, bytes read and bytes written [GB/s].
    pub copy_gb_per_s: f64,
    /// The same copy with the bytes that memory moves: lines are fetched before they are overwritten [GB/s].
    pub traffic_gb_per_s: f64,
}

impl Ceiling {
    /// Measures `threads` cores with vectors of `isa`: the best of several repetitions, in about a second.
    pub fn measure(threads: usize, isa: Isa) -> Self {
        let copy_gb_per_s = copy(threads, isa);
        Self {
            threads,
            fma_gflop_per_s: fma(threads, isa),
            copy_gb_per_s,
            traffic_gb_per_s: 1.5 * copy_gb_per_s,
        }
    }
}

/// Repetitions, of which the best counts.
const REPEATS: usize = 8;

/// Seconds of the best repetition of `work`, which `threads` threads begin together, each on what it prepared.
fn best<T>(threads: usize, prepare: impl Fn() -> T + Sync, work: impl Fn(&mut T) + Sync) -> f64 {
    let barrier = Barrier::new(threads);
    let repeat = || {
        let mut own = prepare();
        let mut once = || {
            barrier.wait();
            let began = Instant::now();
            work(&mut own);
            (began, Instant::now())
        };
        (0..REPEATS).map(|_| once()).collect::<Vec<_>>()
    };
    let times: Vec<_> = thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|_| scope.spawn(repeat)).collect();
        running.into_iter().filter_map(|thread| thread.join().ok()).collect()
    });
    let span = |repeat: usize| {
        let began = times.iter().map(|own| own[repeat].0).min()?;
        times.iter().map(|own| (own[repeat].1 - began).as_secs_f64()).reduce(f64::max)
    };
    (0..REPEATS).filter_map(span).fold(f64::INFINITY, f64::min)
}

/// GFLOP/s; the number of accumulators that suits the registers of the instruction set is found by trying.
fn fma(threads: usize, isa: Isa) -> f64 {
    let rate = |accumulators: usize, seconds: f64| {
        (2 * LANES * accumulators * ROUNDS * threads) as f64 / seconds / 1e9
    };
    let tries = [
        rate(3, best(threads, || (), |()| isa.dispatch(MultiplyAdds::<3>))),
        rate(5, best(threads, || (), |()| isa.dispatch(MultiplyAdds::<5>))),
        rate(12, best(threads, || (), |()| isa.dispatch(MultiplyAdds::<12>))),
    ];
    tries.into_iter().fold(0.0, f64::max)
}

/// Multiply-adds of every accumulator.
const ROUNDS: usize = 3_000_000;

/// x ← x/2 + 1/2 in N independent chains: tends to 1, so that all numbers stay normal.
struct MultiplyAdds<const N: usize>;

impl<const N: usize> Job for MultiplyAdds<N> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let half = S::splat(black_box(0.5));
        let mut sums = [S::splat(black_box(2.0)); N];
        for _ in 0..ROUNDS {
            for sum in &mut sums {
                *sum = sum.fma(half, half);
            }
        }
        let total = sums.into_iter().fold(S::splat(0.0), |a, b| a + b);
        black_box(total.lanes());
    }
}

/// GB/s, read and written.
fn copy(threads: usize, isa: Isa) -> f64 {
    let lines = bytes_to_copy() / size_of::<Wide>() / threads;
    let prepare = || (vec![Wide([1.0; LANES]); lines], vec![Wide::default(); lines]);
    let seconds = best(threads, prepare, |(from, to)| isa.dispatch(Copying { from, to }));
    (2 * lines * size_of::<Wide>() * threads) as f64 / seconds / 1e9
}

/// Bytes of one array of all threads: eight times the last cache.
fn bytes_to_copy() -> usize {
    const MIB: usize = 1 << 20;
    last_cache().map_or(256 * MIB, |cache| (8 * cache).clamp(256 * MIB, 1024 * MIB))
}

/// Bytes of the last cache, where the system tells.
pub fn last_cache() -> Option<usize> {
    let text = std::fs::read_to_string("/sys/devices/system/cpu/cpu0/cache/index3/size").ok()?;
    text.trim().strip_suffix('K')?.parse::<usize>().ok().map(|kib| kib << 10)
}

/// to ← 1 · from. A plain copy would become a library call that may bypass the cache, as no task does.
struct Copying<'a> {
    from: &'a [Wide],
    to: &'a mut [Wide],
}

impl Job for Copying<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self) {
        let one = S::splat(black_box(1.0));
        for (to, from) in self.to.iter_mut().zip(self.from) {
            (S::load(from) * one).store(to);
        }
    }
}
