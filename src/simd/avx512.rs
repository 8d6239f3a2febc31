//! AVX-512. Every method is inlined into a caller that has the features (see `Isa::dispatch`).
#![allow(unsafe_code)]
use super::{INTEGER, INVERSE_CUBE_ROOT, LANES, Mask, Simd, Wide};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Private to `simd`: it exists only inside code that `Isa::dispatch` has entered.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub struct Avx512(__m512d);

/// Wraps an intrinsic.
macro_rules! op {
    ($e:expr) => {
        // SAFETY: AVX-512 was detected before any code that names `Avx512` runs, and loads and
        // stores go through references to 64-byte aligned `Wide`s.
        unsafe { Avx512($e) }
    };
}

/// Lanes that hold the force, or the velocity change, of a node line.
const FORCE: __mmask8 = 0b0111_0000;

/// Names a shuffle of two vectors. Functions, not closures: a closure is not inlined for sure, and an intrinsic that
/// is not inlined costs a call.
macro_rules! shuffles {
    ($($name:ident: $intrinsic:expr;)*) => {$(
        #[inline(always)]
        fn $name(a: Avx512, b: Avx512) -> Avx512 {
            // SAFETY: see `op!`.
            unsafe { Avx512($intrinsic(a.0, b.0)) }
        }
    )*};
}
shuffles! {
    low: _mm512_unpacklo_pd;
    high: _mm512_unpackhi_pd;
    near: _mm512_shuffle_f64x2::<0x44>;
    far: _mm512_shuffle_f64x2::<0xEE>;
    even: _mm512_shuffle_f64x2::<0x88>;
    odd: _mm512_shuffle_f64x2::<0xDD>;
}

/// Every other column of eight rows whose pairs are interleaved.
#[inline(always)]
fn even_columns(pairs: [Avx512; 4]) -> [Avx512; 4] {
    let (a, b) = (near(pairs[0], pairs[1]), near(pairs[2], pairs[3]));
    let (c, d) = (far(pairs[0], pairs[1]), far(pairs[2], pairs[3]));
    [even(a, b), odd(a, b), even(c, d), odd(c, d)]
}

impl Simd for Avx512 {
    type Upper = Self;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        op!(_mm512_set1_pd(x))
    }
    #[inline(always)]
    fn load(from: &Wide) -> Self {
        op!(_mm512_load_pd(from.0.as_ptr()))
    }
    #[inline(always)]
    fn store(self, to: &mut Wide) {
        // SAFETY: see `op!`.
        unsafe { _mm512_store_pd(to.0.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        op!(_mm512_fmadd_pd(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn fms(self, b: Self, c: Self) -> Self {
        op!(_mm512_fmsub_pd(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn fnma(self, b: Self, c: Self) -> Self {
        op!(_mm512_fnmadd_pd(self.0, b.0, c.0))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        op!(_mm512_sqrt_pd(self.0))
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        op!(_mm512_max_pd(self.0, b.0))
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        op!(_mm512_min_pd(self.0, b.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        op!(_mm512_abs_pd(self.0))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        op!(_mm512_roundscale_pd::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>(self.0))
    }
    #[inline(always)]
    fn round(self) -> Self {
        op!(_mm512_roundscale_pd::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0))
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask {
        // SAFETY: see `op!`.
        unsafe { _mm512_cmp_pd_mask::<_CMP_GE_OQ>(self.0, b.0) }
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask {
        // SAFETY: see `op!`.
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, b.0) }
    }
    #[inline(always)]
    fn differs(self, b: Self) -> Mask {
        // SAFETY: see `op!`.
        unsafe { _mm512_cmp_pd_mask::<_CMP_NEQ_UQ>(self.0, b.0) }
    }
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        op!(_mm512_mask_blend_pd(mask, no.0, yes.0))
    }
    #[inline(always)]
    fn scale_exponent(self, n: Self) -> Self {
        op!(_mm512_scalef_pd(self.0, n.0))
    }
    #[inline(always)]
    fn split_exponent(self) -> (Self, Self) {
        // bits of √½, so that the shifted exponent counts from there
        const ROOT_HALF: i64 = 0x3FE6_A09E_667F_3BCD;
        // SAFETY: see `op!`.
        let (mantissa, exponent) = unsafe {
            let bits = _mm512_castpd_si512(self.0);
            let shifted = _mm512_sub_epi64(bits, _mm512_set1_epi64(ROOT_HALF));
            let exponent = _mm512_srai_epi64::<52>(shifted);
            let mantissa = _mm512_sub_epi64(bits, _mm512_slli_epi64::<52>(exponent));
            (_mm512_castsi512_pd(mantissa), _mm512_cvtepi64_pd(exponent))
        };
        (Avx512(mantissa), Avx512(exponent))
    }
    #[inline(always)]
    fn guess_inverse_cube_root(self) -> Self {
        op!({
            // 2⁵² + h(x), then 2⁵² + h(x^(−1/3))
            let upper = _mm512_srli_epi64::<32>(_mm512_castpd_si512(self.0));
            let number = _mm512_or_si512(upper, _mm512_castpd_si512(_mm512_set1_pd(INTEGER)));
            let all = _mm512_set1_pd(INTEGER + INTEGER / 3.0 + INVERSE_CUBE_ROOT);
            let guess = _mm512_fnmadd_pd(_mm512_castsi512_pd(number), _mm512_set1_pd(1.0 / 3.0), all);
            _mm512_castsi512_pd(_mm512_slli_epi64::<32>(_mm512_castpd_si512(guess)))
        })
    }
    #[inline(always)]
    fn transpose(r: [Self; LANES]) -> [Self; LANES] {
        // pairs of rows, then quarters, then halves
        let [c0, c2, c4, c6] =
            even_columns([low(r[0], r[1]), low(r[2], r[3]), low(r[4], r[5]), low(r[6], r[7])]);
        let [c1, c3, c5, c7] =
            even_columns([high(r[0], r[1]), high(r[2], r[3]), high(r[4], r[5]), high(r[6], r[7])]);
        [c0, c1, c2, c3, c4, c5, c6, c7]
    }

    #[inline(always)]
    fn blend_force(a: Self, b: Self) -> Self {
        op!(_mm512_mask_blend_pd(FORCE, a.0, b.0))
    }
    #[inline(always)]
    fn force(self) -> Self {
        op!(_mm512_maskz_mov_pd(FORCE, self.0))
    }
    #[inline(always)]
    fn times_upper(self, t: Self) -> Self {
        self * t
    }
    #[inline(always)]
    fn fma_upper(self, b: Self, t: Self) -> Self {
        self.fma(b, t)
    }
    #[inline(always)]
    fn low_to_force(self) -> Self {
        op!(_mm512_maskz_shuffle_f64x2::<0x4E>(FORCE, self.0, self.0))
    }
    #[inline(always)]
    fn momentum_to_low(self) -> Self {
        op!(_mm512_maskz_permutexvar_pd(0b0111_0111, _mm512_set_epi64(0, 6, 5, 4, 0, 3, 2, 1), self.0))
    }
    #[inline(always)]
    fn swap_halves(self) -> Self {
        op!(_mm512_shuffle_f64x2::<0x4E>(self.0, self.0))
    }
    #[inline(always)]
    fn join_low(a: Self, b: Self) -> Self {
        op!(_mm512_shuffle_f64x2::<0x44>(a.0, b.0))
    }
    #[inline(always)]
    fn with_3_7(self, g: Self) -> Self {
        op!(_mm512_mask_permutexvar_pd(self.0, 0b1000_1000, _mm512_set_epi64(1, 0, 0, 0, 0, 0, 0, 0), g.0))
    }
    #[inline(always)]
    fn with_3(self, g: Self) -> Self {
        op!(_mm512_mask_permutexvar_pd(self.0, 0b0000_1000, _mm512_set_epi64(0, 0, 0, 0, 2, 0, 0, 0), g.0))
    }
}

macro_rules! operators {
    ($($Trait:ident $method:ident $intrinsic:ident),*) => {$(
        impl $Trait for Avx512 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                op!($intrinsic(self.0, b.0))
            }
        }
    )*};
}
operators!(Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

impl Neg for Avx512 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        op!(_mm512_xor_pd(self.0, _mm512_set1_pd(-0.0)))
    }
}
