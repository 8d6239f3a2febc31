//! Eight doubles at a time.
//!
//! Storage is [`Wide`], one cache line. Arithmetic is generic over [`Simd`], so that one kernel body
//! serves every instruction set; [`Isa::dispatch`] is the only door from run-time detection to code
//! compiled for a set. All `unsafe` of the kernels lives in this folder.
mod array;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
pub mod counting;
mod halves;
mod isa;
pub mod math;
#[cfg(target_arch = "aarch64")]
mod neon;
mod ticks;

pub use array::Array;
use bytemuck::{Pod, Zeroable};
pub use isa::{Isa, Job};
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

/// 2⁵²: added to an integer below it, it leaves that integer in the low bits.
const INTEGER: f64 = (1u64 << 52) as f64;
/// The upper halves h(x) of doubles are about linear in log₂ x: h(x^(−1/3)) ≈ this − h(x)/3, where it errs as far up as down.
const INVERSE_CUBE_ROOT: f64 = 0x553E_F0EC as f64;

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
    /// Lanes 4–7 alone: what a node has of forces. A half line where registers are no longer, so that nothing is spent on
    /// lanes that are zero.
    type Upper: Copy + Add<Output = Self::Upper> + Sub<Output = Self::Upper>;

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
    /// self · 2ⁿ for integral n with |n| ≤ 1022
    fn scale_exponent(self, n: Self) -> Self;
    /// (m, e) with self = m · 2ᵉ and m in [√½, √2), for normal positive numbers
    fn split_exponent(self) -> (Self, Self);
    /// Within 4 % of self^(−1/3), for normal positive numbers (see [`math::inverse_cube_root`]).
    fn guess_inverse_cube_root(self) -> Self;
    /// Lane j of row i becomes lane i of row j.
    fn transpose(rows: [Self; LANES]) -> [Self; LANES];

    /// Lanes 4–6 from `b`, the others from `a`.
    fn blend_force(a: Self, b: Self) -> Self;
    /// Lanes 4–6 of the upper half, lane 7 zero.
    fn force(self) -> Self::Upper;
    /// Lanes 0–2 moved to lanes 4–6 of the upper half, lane 7 zero.
    fn low_to_force(self) -> Self::Upper;
    /// self · t in the upper half, for finite self: registers that hold a line multiply zeros in the lower one.
    fn times_upper(self, t: Self::Upper) -> Self::Upper;
    /// self · b, and in the upper half self · b + t.
    fn fma_upper(self, b: Self, t: Self::Upper) -> Self;
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
pub fn prefetch(lines: &[Wide], ahead: usize) {
    prefetch_at(lines.as_ptr().wrapping_add(ahead));
}

/// Asks for the line at an address, whatever it is.
#[inline(always)]
pub fn prefetch_at<T>(line: *const T) {
    ask::<T, false>(line);
}

/// As [`prefetch_at`], for what is wanted later: it comes to the second-level cache, and takes no place in the first one.
#[inline(always)]
pub fn prefetch_later<T>(line: *const T) {
    ask::<T, true>(line);
}

#[inline(always)]
#[allow(unsafe_code)]
fn ask<T, const LATER: bool>(line: *const T) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch never faults, whatever the address.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _MM_HINT_T1, _mm_prefetch};
        match LATER {
            true => _mm_prefetch::<_MM_HINT_T1>(line.cast()),
            false => _mm_prefetch::<_MM_HINT_T0>(line.cast()),
        }
    }
    #[cfg(target_arch = "aarch64")]
    // SAFETY: as above.
    unsafe {
        use std::arch::asm;
        match LATER {
            true => asm!("prfm pldl2keep, [{}]", in(reg) line, options(nostack, preserves_flags, readonly)),
            false => asm!("prfm pldl1keep, [{}]", in(reg) line, options(nostack, preserves_flags, readonly)),
        }
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    let _ = line;
}
