//! Eight doubles at a time.
//!
//! Storage is [`Wide`], one cache line. Arithmetic is generic over [`Simd`], so that one kernel body
//! serves every instruction set; [`Isa::dispatch`] is the only door from run-time detection to code
//! compiled for a set. All `unsafe` of the kernels lives in this folder.
mod array;
mod avx512;
pub mod counting;
pub mod math;
mod ticks;

pub use array::Array;
use avx512::Avx512;
use bytemuck::{Pod, Zeroable};
use counting::Counting;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};
pub use ticks::ticks;

/// Lanes of a vector: particles in a tile, numbers in a node line.
pub const LANES: usize = 8;

/// One cache line: eight particles of one component, or the eight numbers of one node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Wide(pub [f64; LANES]);

/// One bit a lane.
pub type Mask = u8;

/// A vector of eight `f64` in registers.
///
/// The last group of methods moves lanes of node lines, `[m, px, py, pz, fx, fy, fz, V]` and
/// `[vx, vy, vz, 0, dx, dy, dz, 0]`.
pub trait Simd:
    Copy
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The same number in every lane.
    fn splat(x: f64) -> Self;
    /// The eight numbers of a line.
    fn load(from: &Wide) -> Self;
    /// Writes all lanes.
    fn store(self, to: &mut Wide);
    /// self · b + c (rounded once where the instruction set can)
    fn fma(self, b: Self, c: Self) -> Self;
    /// self · b − c
    fn fms(self, b: Self, c: Self) -> Self;
    /// c − self · b
    fn fnma(self, b: Self, c: Self) -> Self;
    /// √self
    fn sqrt(self) -> Self;
    /// The larger of the two; `b` where either is not a number.
    fn max(self, b: Self) -> Self;
    /// The smaller of the two; `b` where either is not a number.
    fn min(self, b: Self) -> Self;
    /// |self|
    fn abs(self) -> Self;
    /// The largest integer that is not above self.
    fn floor(self) -> Self;
    /// The nearest integer, ties to even.
    fn round(self) -> Self;
    /// Lanes where self ≥ b (false where either is not a number).
    fn ge(self, b: Self) -> Mask;
    /// Lanes where self < b (false where either is not a number).
    fn lt(self, b: Self) -> Mask;
    /// Lanes where self ≠ b (true where either is not a number).
    fn differs(self, b: Self) -> Mask;
    /// `yes` in the lanes of `mask`, `no` in the others.
    fn select(mask: Mask, yes: Self, no: Self) -> Self;
    /// self · 2ⁿ for integral n
    fn scale_exponent(self, n: Self) -> Self;
    /// (m, e) with self = m · 2ᵉ and m in [√½, √2), for normal positive numbers
    fn split_exponent(self) -> (Self, Self);
    /// Lane j of row i becomes lane i of row j.
    fn transpose(rows: [Self; LANES]) -> [Self; LANES];

    /// Lanes 4–6 from `b`, the others from `a`.
    fn blend_force(a: Self, b: Self) -> Self;
    /// Lanes 0–2 moved to lanes 4–6, the others zero.
    fn low_to_force(self) -> Self;
    /// `[p, 0, f, 0]` from `[m, p, f, V]`: lanes 1–3 to 0–2, the force stays.
    fn momentum_to_low(self) -> Self;
    /// Lanes 4–7, then lanes 0–3.
    fn swap_halves(self) -> Self;
    /// `[a.low half, b.low half]`
    fn join_low(a: Self, b: Self) -> Self;
    /// Lanes 3 and 7 replaced by lanes 0 and 1 of `g`.
    fn with_3_7(self, g: Self) -> Self;
    /// Lane 3 replaced by lane 2 of `g`.
    fn with_3(self, g: Self) -> Self;

    /// The lanes as numbers (slow: for rare branches and tests).
    #[inline(always)]
    fn lanes(self) -> [f64; LANES] {
        let mut line = Wide::default();
        self.store(&mut line);
        line.0
    }
}

/// Instruction set, chosen once at run time. Only [`Isa::available`] makes those that need detection, and outside this
/// module nobody can name the AVX-512 vector: that is what makes `dispatch` sound.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Isa(Level);

#[derive(Clone, Copy, PartialEq, Eq)]
enum Level {
    Avx512,
    Avx2,
    Baseline,
    Counting,
}

impl Isa {
    /// Plain arrays: runs on every machine.
    pub const BASELINE: Isa = Isa(Level::Baseline);

    /// Counts operations instead of being fast (see [`counting::take`]). Nobody gets it who does not ask for it here.
    pub const COUNTING: Isa = Isa(Level::Counting);

    /// The sets of this machine, the best first.
    pub fn available() -> Vec<Self> {
        macro_rules! all {
            ($($feature:tt)*) => { $(is_x86_feature_detected!($feature))&&* };
        }
        let mut sets = Vec::new();
        if all!("avx512f" "avx512bw" "avx512dq" "avx512vl" "fma" "bmi1" "bmi2" "lzcnt") {
            sets.push(Isa(Level::Avx512));
        }
        if all!("avx2" "fma" "bmi1" "bmi2" "lzcnt") {
            sets.push(Isa(Level::Avx2));
        }
        sets.push(Isa::BASELINE);
        sets
    }

    /// The best set of this machine.
    pub fn detect() -> Self {
        Self::available()[0]
    }

    /// The set named by the environment variable `SINEW_ISA` (`avx512`, `avx2`, `baseline`), else the best.
    ///
    /// # Errors
    /// An unknown name, or a set that this machine lacks: the message names the choices.
    pub fn from_environment() -> Result<Self, String> {
        let available = Self::available();
        let Some(name) = std::env::var("SINEW_ISA").ok().filter(|name| !name.is_empty()) else {
            return Ok(available[0]);
        };
        available.iter().copied().find(|isa| isa.name() == name).ok_or_else(|| {
            let names: Vec<&str> = available.iter().map(|isa| isa.name()).collect();
            format!("SINEW_ISA={name}: this machine offers {}", names.join(", "))
        })
    }

    /// `avx512`, `avx2` or `baseline`; `counting` counts.
    pub fn name(self) -> &'static str {
        match self.0 {
            Level::Avx512 => "avx512",
            Level::Avx2 => "avx2",
            Level::Baseline => "baseline",
            Level::Counting => "counting",
        }
    }

    /// Runs `job` compiled for this instruction set.
    #[inline]
    #[allow(unsafe_code)]
    pub fn dispatch<J: Job>(self, job: J) -> J::Output {
        match self.0 {
            // SAFETY: only `available` makes this value, and only where all these features exist.
            Level::Avx512 => unsafe { with_avx512(job) },
            // SAFETY: as above.
            Level::Avx2 => unsafe { with_avx2(job) },
            Level::Baseline => job.run::<Array<false>>(),
            Level::Counting => counted(job),
        }
    }
}

impl fmt::Debug for Isa {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Work that is compiled once per instruction set: `run` and all it inlines see `S`'s features.
pub trait Job {
    /// What `run` returns.
    type Output;
    /// The work. Mark it, and what it calls per particle, `#[inline(always)]`.
    fn run<S: Simd>(self) -> Self::Output;
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,fma,bmi1,bmi2,lzcnt")]
fn with_avx512<J: Job>(job: J) -> J::Output {
    job.run::<Avx512>()
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt")]
fn with_avx2<J: Job>(job: J) -> J::Output {
    job.run::<Array<true>>()
}

#[cold]
#[inline(never)]
fn counted<J: Job>(job: J) -> J::Output {
    job.run::<Counting>()
}

/// Loads lines. A loop, not `map`: the standard library may be compiled as functions of its own, without the
/// instruction set of the caller.
#[inline(always)]
pub fn load<S: Simd, const N: usize>(lines: &[Wide; N]) -> [S; N] {
    let mut vectors = [S::splat(0.0); N];
    for (vector, line) in vectors.iter_mut().zip(lines) {
        *vector = S::load(line);
    }
    vectors
}

/// Stores vectors to lines; as many as there are of both.
#[inline(always)]
pub fn store<S: Simd>(vectors: &[S], lines: &mut [Wide]) {
    for (vector, line) in vectors.iter().zip(lines) {
        vector.store(line);
    }
}

/// Asks for the line `ahead` lines after the first of `lines`, inside the slice or not.
#[inline(always)]
#[allow(unsafe_code)]
pub fn prefetch(lines: &[Wide], ahead: usize) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch never faults, whatever the address.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(lines.as_ptr().wrapping_add(ahead).cast());
    }
}
