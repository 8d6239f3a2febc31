//! NEON of AArch64, which all its processors have: half a line is two registers.
#![allow(unsafe_code)]
use super::halves::{Half, Halves};
use super::{INTEGER, INVERSE_CUBE_ROOT, Mask};
use std::arch::aarch64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight `f64`.
pub type Neon = Halves<NeonHalf>;

/// Four `f64`.
#[derive(Clone, Copy)]
pub struct NeonHalf(float64x2_t, float64x2_t);

/// Wraps an intrinsic of two lanes, for both pairs.
macro_rules! op {
    (|$($x:ident),*| $e:expr) => {{
        #[inline(always)]
        fn pair($($x: float64x2_t),*) -> float64x2_t {
            // SAFETY: NEON is part of AArch64.
            unsafe { $e }
        }
        NeonHalf(pair($($x.0),*), pair($($x.1),*))
    }};
}

/// A mask of the lanes in which a comparison holds.
macro_rules! mask {
    ($compare:ident, $a:expr, $b:expr) => {{
        // SAFETY: NEON is part of AArch64.
        let (low, high) = unsafe { ($compare($a.0, $b.0), $compare($a.1, $b.1)) };
        bits(low) | bits(high) << 2
    }};
}

/// The lowest bits of two lanes.
#[inline(always)]
fn bits(lanes: uint64x2_t) -> Mask {
    // SAFETY: NEON is part of AArch64.
    unsafe { (vgetq_lane_u64::<0>(lanes) & 1) as Mask | (vgetq_lane_u64::<1>(lanes) as Mask & 1) << 1 }
}

impl Half for NeonHalf {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        // SAFETY: NEON is part of AArch64.
        let pair = unsafe { vdupq_n_f64(x) };
        NeonHalf(pair, pair)
    }
    #[inline(always)]
    fn load(from: &[f64; 4]) -> Self {
        // SAFETY: two and two numbers of a reference.
        unsafe { NeonHalf(vld1q_f64(from.as_ptr()), vld1q_f64(from[2..].as_ptr())) }
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; 4]) {
        // SAFETY: two and two numbers of a reference.
        unsafe {
            vst1q_f64(to.as_mut_ptr(), self.0);
            vst1q_f64(to[2..].as_mut_ptr(), self.1);
        }
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        let a = self;
        op!(|a, b, c| vfmaq_f64(c, a, b))
    }
    #[inline(always)]
    fn fms(self, b: Self, c: Self) -> Self {
        let a = self;
        op!(|a, b, c| vfmaq_f64(vnegq_f64(c), a, b))
    }
    #[inline(always)]
    fn fnma(self, b: Self, c: Self) -> Self {
        let a = self;
        op!(|a, b, c| vfmsq_f64(c, a, b))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let a = self;
        op!(|a| vsqrtq_f64(a))
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        let a = self;
        op!(|a, b| vbslq_f64(vcgtq_f64(a, b), a, b))
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        let a = self;
        op!(|a, b| vbslq_f64(vcltq_f64(a, b), a, b))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let a = self;
        op!(|a| vabsq_f64(a))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        let a = self;
        op!(|a| vrndmq_f64(a))
    }
    #[inline(always)]
    fn round(self) -> Self {
        let a = self;
        op!(|a| vrndnq_f64(a))
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask {
        mask!(vcgeq_f64, self, b)
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask {
        mask!(vcltq_f64, self, b)
    }
    #[inline(always)]
    fn differs(self, b: Self) -> Mask {
        !mask!(vceqq_f64, self, b) & 0b1111
    }
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        // SAFETY: NEON is part of AArch64.
        unsafe {
            let bits = vdupq_n_u64(mask.into());
            let pick =
                |lanes: [u64; 2], yes, no| vbslq_f64(vtstq_u64(bits, vld1q_u64(lanes.as_ptr())), yes, no);
            NeonHalf(pick([1, 2], yes.0, no.0), pick([4, 8], yes.1, no.1))
        }
    }
    #[inline(always)]
    fn scale_exponent(self, n: Self) -> Self {
        // 2ⁿ: n and the bias of exponents, moved from the low bits to where exponents are
        let a = self;
        op!(|a, n| {
            let biased = vaddq_f64(n, vdupq_n_f64(INTEGER + 1023.0));
            vmulq_f64(a, vreinterpretq_f64_u64(vshlq_n_u64::<52>(vreinterpretq_u64_f64(biased))))
        })
    }
    #[inline(always)]
    fn split_exponent(self) -> (Self, Self) {
        // bits of √½, so that the shifted exponent counts from there
        const ROOT_HALF: i64 = 0x3FE6_A09E_667F_3BCD;
        let a = self;
        let exponent = op!(|a| {
            let shifted = vsubq_s64(vreinterpretq_s64_f64(a), vdupq_n_s64(ROOT_HALF));
            vcvtq_f64_s64(vshrq_n_s64::<52>(shifted))
        });
        let mantissa = op!(|a| {
            let bits = vreinterpretq_s64_f64(a);
            let shifted = vsubq_s64(bits, vdupq_n_s64(ROOT_HALF));
            vreinterpretq_f64_s64(vsubq_s64(bits, vandq_s64(shifted, vdupq_n_s64(-1 << 52))))
        });
        (mantissa, exponent)
    }
    #[inline(always)]
    fn guess_inverse_cube_root(self) -> Self {
        // 2⁵² + h(x), then 2⁵² + h(x^(−1/3))
        let a = self;
        op!(|a| {
            let upper = vshrq_n_u64::<32>(vreinterpretq_u64_f64(a));
            let number = vaddq_f64(vcvtq_f64_u64(upper), vdupq_n_f64(INTEGER));
            let all = vdupq_n_f64(INTEGER + INTEGER / 3.0 + INVERSE_CUBE_ROOT);
            let guess = vfmsq_f64(all, number, vdupq_n_f64(1.0 / 3.0));
            vreinterpretq_f64_u64(vshlq_n_u64::<32>(vreinterpretq_u64_f64(guess)))
        })
    }
    #[inline(always)]
    fn transpose([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        // SAFETY: NEON is part of AArch64.
        unsafe {
            [
                NeonHalf(vzip1q_f64(a.0, b.0), vzip1q_f64(c.0, d.0)),
                NeonHalf(vzip2q_f64(a.0, b.0), vzip2q_f64(c.0, d.0)),
                NeonHalf(vzip1q_f64(a.1, b.1), vzip1q_f64(c.1, d.1)),
                NeonHalf(vzip2q_f64(a.1, b.1), vzip2q_f64(c.1, d.1)),
            ]
        }
    }
    #[inline(always)]
    fn with_last(self, last: Self) -> Self {
        // SAFETY: NEON is part of AArch64.
        unsafe { NeonHalf(self.0, vcopyq_laneq_f64::<1, 1>(self.1, last.1)) }
    }
    #[inline(always)]
    fn spread<const LANE: i32>(self) -> Self {
        // SAFETY: NEON is part of AArch64.
        let pair = unsafe {
            match LANE {
                0 => vdupq_laneq_f64::<0>(self.0),
                1 => vdupq_laneq_f64::<1>(self.0),
                2 => vdupq_laneq_f64::<0>(self.1),
                _ => vdupq_laneq_f64::<1>(self.1),
            }
        };
        NeonHalf(pair, pair)
    }
    #[inline(always)]
    fn without_first(self) -> Self {
        // SAFETY: NEON is part of AArch64.
        unsafe { NeonHalf(vextq_f64::<1>(self.0, self.1), vextq_f64::<1>(self.1, vdupq_n_f64(0.0))) }
    }
}

macro_rules! operators {
    ($($Trait:ident $method:ident $intrinsic:ident),*) => {$(
        impl $Trait for NeonHalf {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                let a = self;
                op!(|a, b| $intrinsic(a, b))
            }
        }
    )*};
}
operators!(Add add vaddq_f64, Sub sub vsubq_f64, Mul mul vmulq_f64, Div div vdivq_f64);

impl Neg for NeonHalf {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let a = self;
        op!(|a| vnegq_f64(a))
    }
}
