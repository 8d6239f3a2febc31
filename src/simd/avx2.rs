//! AVX2. Every method is inlined into a caller that has the features (see `Isa::dispatch`).
#![allow(unsafe_code)]
use super::halves::{Half, Halves};
use super::{INTEGER, INVERSE_CUBE_ROOT, Mask};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Private to `simd`: it exists only inside code that `Isa::dispatch` has entered.
pub type Avx2 = Halves<Avx2Half>;

/// Four `f64`.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct Avx2Half(__m256d);

/// Wraps an intrinsic.
macro_rules! op {
    ($e:expr) => {
        // SAFETY: AVX2 and FMA were detected before any code that names `Avx2Half` runs, and loads and stores go through
        // references to halves of 64-byte aligned `Wide`s.
        unsafe { Avx2Half($e) }
    };
}

impl Half for Avx2Half {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        op!(_mm256_set1_pd(x))
    }
    #[inline(always)]
    fn load(from: &[f64; 4]) -> Self {
        op!(_mm256_load_pd(from.as_ptr()))
    }
    #[inline(always)]
    fn store(self, to: &mut [f64; 4]) {
        // SAFETY: see `op!`.
        unsafe { _mm256_store_pd(to.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        op!(_mm256_fmadd_pd(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn fms(self, b: Self, c: Self) -> Self {
        op!(_mm256_fmsub_pd(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn fnma(self, b: Self, c: Self) -> Self {
        op!(_mm256_fnmadd_pd(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        op!(_mm256_sqrt_pd(self.0))
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        op!(_mm256_max_pd(self.0, b.0))
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        op!(_mm256_min_pd(self.0, b.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        op!(_mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        op!(_mm256_round_pd::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0))
    }
    #[inline(always)]
    fn round(self) -> Self {
        op!(_mm256_round_pd::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0))
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask {
        // SAFETY: see `op!`.
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GE_OQ>(self.0, b.0)) as Mask }
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask {
        // SAFETY: see `op!`.
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, b.0)) as Mask }
    }
    #[inline(always)]
    fn differs(self, b: Self) -> Mask {
        // SAFETY: see `op!`.
        unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_NEQ_UQ>(self.0, b.0)) as Mask }
    }
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        // a blend looks at the highest bit of a lane
        op!({
            let bits = _mm256_sllv_epi64(_mm256_set1_epi64x(mask.into()), _mm256_setr_epi64x(63, 62, 61, 60));
            _mm256_blendv_pd(no.0, yes.0, _mm256_castsi256_pd(bits))
        })
    }
    #[inline(always)]
    fn scale_exponent(self, n: Self) -> Self {
        // 2ⁿ: n and the bias of exponents, moved from the low bits to where exponents are
        op!({
            let biased = _mm256_add_pd(n.0, _mm256_set1_pd(INTEGER + 1023.0));
            let power = _mm256_slli_epi64::<52>(_mm256_castpd_si256(biased));
            _mm256_mul_pd(self.0, _mm256_castsi256_pd(power))
        })
    }
    #[inline(always)]
    fn split_exponent(self) -> (Self, Self) {
        // bits of √½, so that the shifted exponent counts from there
        const ROOT_HALF: i64 = 0x3FE6_A09E_667F_3BCD;
        // there is no signed shift: the exponent is made positive, and read as the low bits of 2⁵² + n
        const POSITIVE: i64 = 1024 << 52;
        // SAFETY: see `op!`.
        let (mantissa, exponent) = unsafe {
            let bits = _mm256_castpd_si256(self.0);
            let shifted = _mm256_sub_epi64(bits, _mm256_set1_epi64x(ROOT_HALF));
            let exponent = _mm256_and_si256(shifted, _mm256_set1_epi64x(-1 << 52));
            let mantissa = _mm256_sub_epi64(bits, exponent);
            let positive = _mm256_srli_epi64::<52>(_mm256_add_epi64(exponent, _mm256_set1_epi64x(POSITIVE)));
            let number = _mm256_or_si256(positive, _mm256_castpd_si256(_mm256_set1_pd(INTEGER)));
            let number = _mm256_sub_pd(_mm256_castsi256_pd(number), _mm256_set1_pd(INTEGER + 1024.0));
            (_mm256_castsi256_pd(mantissa), number)
        };
        (Avx2Half(mantissa), Avx2Half(exponent))
    }
    #[inline(always)]
    fn guess_inverse_cube_root(self) -> Self {
        op!({
            // 2⁵² + h(x), then 2⁵² + h(x^(−1/3))
            let upper = _mm256_srli_epi64::<32>(_mm256_castpd_si256(self.0));
            let number = _mm256_or_si256(upper, _mm256_castpd_si256(_mm256_set1_pd(INTEGER)));
            let all = _mm256_set1_pd(INTEGER + INTEGER / 3.0 + INVERSE_CUBE_ROOT);
            let guess = _mm256_fnmadd_pd(_mm256_castsi256_pd(number), _mm256_set1_pd(1.0 / 3.0), all);
            _mm256_castsi256_pd(_mm256_slli_epi64::<32>(_mm256_castpd_si256(guess)))
        })
    }
    #[inline(always)]
    fn transpose([a, b, c, d]: [Self; 4]) -> [Self; 4] {
        // SAFETY: see `op!`.
        unsafe {
            let (ab0, ab1) = (_mm256_unpacklo_pd(a.0, b.0), _mm256_unpackhi_pd(a.0, b.0));
            let (cd0, cd1) = (_mm256_unpacklo_pd(c.0, d.0), _mm256_unpackhi_pd(c.0, d.0));
            [
                Avx2Half(_mm256_permute2f128_pd::<0x20>(ab0, cd0)),
                Avx2Half(_mm256_permute2f128_pd::<0x20>(ab1, cd1)),
                Avx2Half(_mm256_permute2f128_pd::<0x31>(ab0, cd0)),
                Avx2Half(_mm256_permute2f128_pd::<0x31>(ab1, cd1)),
            ]
        }
    }
    #[inline(always)]
    fn with_last(self, last: Self) -> Self {
        op!(_mm256_blend_pd::<0b1000>(self.0, last.0))
    }
    #[inline(always)]
    fn spread<const LANE: i32>(self) -> Self {
        op!(match LANE {
            0 => _mm256_permute4x64_pd::<0x00>(self.0),
            1 => _mm256_permute4x64_pd::<0x55>(self.0),
            2 => _mm256_permute4x64_pd::<0xAA>(self.0),
            _ => _mm256_permute4x64_pd::<0xFF>(self.0),
        })
    }
    #[inline(always)]
    fn without_first(self) -> Self {
        op!(_mm256_blend_pd::<0b1000>(_mm256_permute4x64_pd::<0b11_11_10_01>(self.0), _mm256_setzero_pd()))
    }
}

macro_rules! operators {
    ($($Trait:ident $method:ident $intrinsic:ident),*) => {$(
        impl $Trait for Avx2Half {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                op!($intrinsic(self.0, b.0))
            }
        }
    )*};
}
operators!(Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

impl Neg for Avx2Half {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        op!(_mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)))
    }
}
