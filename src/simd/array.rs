//! Plain arrays: run everywhere, and are the reference for the other instruction sets.
use super::{INTEGER, INVERSE_CUBE_ROOT, LANES, Mask, Simd, Wide};
use std::array::from_fn;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Eight `f64` as an array; the compiler makes vectors of what all machines have of it.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Array([f64; LANES]);

#[inline(always)]
fn lanes(f: impl FnMut(usize) -> f64) -> Array {
    Array(from_fn(f))
}

#[inline(always)]
fn mask(f: impl Fn(usize) -> bool) -> Mask {
    (0..LANES).fold(0, |bits, i| bits | u8::from(f(i)) << i)
}

impl Simd for Array {
    type Upper = Self;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        Array([x; LANES])
    }
    #[inline(always)]
    fn load(from: &Wide) -> Self {
        Array(from.0)
    }
    #[inline(always)]
    fn store(self, to: &mut Wide) {
        to.0 = self.0;
    }
    // two roundings: `mul_add` would be a library call
    #[inline(always)]
    fn fma(self, b: Self, c: Self) -> Self {
        lanes(|i| self.0[i] * b.0[i] + c.0[i])
    }
    #[inline(always)]
    fn fms(self, b: Self, c: Self) -> Self {
        lanes(|i| self.0[i] * b.0[i] - c.0[i])
    }
    #[inline(always)]
    fn fnma(self, b: Self, c: Self) -> Self {
        lanes(|i| c.0[i] - self.0[i] * b.0[i])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        lanes(|i| self.0[i].sqrt())
    }
    #[inline(always)]
    fn max(self, b: Self) -> Self {
        lanes(|i| if self.0[i] > b.0[i] { self.0[i] } else { b.0[i] })
    }
    #[inline(always)]
    fn min(self, b: Self) -> Self {
        lanes(|i| if self.0[i] < b.0[i] { self.0[i] } else { b.0[i] })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        lanes(|i| self.0[i].abs())
    }
    #[inline(always)]
    fn floor(self) -> Self {
        lanes(|i| self.0[i].floor())
    }
    #[inline(always)]
    fn round(self) -> Self {
        lanes(|i| self.0[i].round_ties_even())
    }
    #[inline(always)]
    fn ge(self, b: Self) -> Mask {
        mask(|i| self.0[i] >= b.0[i])
    }
    #[inline(always)]
    fn lt(self, b: Self) -> Mask {
        mask(|i| self.0[i] < b.0[i])
    }
    #[inline(always)]
    fn differs(self, b: Self) -> Mask {
        mask(|i| self.0[i] != b.0[i])
    }
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        lanes(|i| if mask >> i & 1 == 1 { yes.0[i] } else { no.0[i] })
    }
    #[inline(always)]
    fn scale_exponent(self, n: Self) -> Self {
        lanes(|i| self.0[i] * f64::from_bits(((1023.0 + n.0[i]) as u64) << 52))
    }
    #[inline(always)]
    fn split_exponent(self) -> (Self, Self) {
        // bits of √½, so that the shifted exponent counts from there
        const ROOT_HALF: u64 = 0x3FE6_A09E_667F_3BCD;
        let exponent = |x: f64| (x.to_bits().wrapping_sub(ROOT_HALF) as i64) >> 52;
        let mantissa = |x: f64| f64::from_bits(x.to_bits().wrapping_sub((exponent(x) as u64) << 52));
        (lanes(|i| mantissa(self.0[i])), lanes(|i| exponent(self.0[i]) as f64))
    }
    #[inline(always)]
    fn guess_inverse_cube_root(self) -> Self {
        let all = INTEGER + INTEGER / 3.0 + INVERSE_CUBE_ROOT;
        lanes(|i| {
            // 2⁵² + h(x), then 2⁵² + h(x^(−1/3))
            let number = INTEGER + (self.0[i].to_bits() >> 32) as f64;
            f64::from_bits((all - number * (1.0 / 3.0)).to_bits() << 32)
        })
    }
    #[inline(always)]
    fn transpose(rows: [Self; LANES]) -> [Self; LANES] {
        from_fn(|j| lanes(|i| rows[i].0[j]))
    }

    #[inline(always)]
    fn blend_force(a: Self, b: Self) -> Self {
        lanes(|i| if (4..7).contains(&i) { b.0[i] } else { a.0[i] })
    }
    #[inline(always)]
    fn force(self) -> Self {
        lanes(|i| if (4..7).contains(&i) { self.0[i] } else { 0.0 })
    }
    #[inline(always)]
    fn low_to_force(self) -> Self {
        lanes(|i| if (4..7).contains(&i) { self.0[i - 4] } else { 0.0 })
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
    fn momentum_to_low(self) -> Self {
        let s = self.0;
        Array([s[1], s[2], s[3], 0.0, s[4], s[5], s[6], 0.0])
    }
    #[inline(always)]
    fn swap_halves(self) -> Self {
        lanes(|i| self.0[(i + 4) % 8])
    }
    #[inline(always)]
    fn join_low(a: Self, b: Self) -> Self {
        lanes(|i| if i < 4 { a.0[i] } else { b.0[i - 4] })
    }
    #[inline(always)]
    fn with_3_7(mut self, g: Self) -> Self {
        (self.0[3], self.0[7]) = (g.0[0], g.0[1]);
        self
    }
    #[inline(always)]
    fn with_3(mut self, g: Self) -> Self {
        self.0[3] = g.0[2];
        self
    }
}

macro_rules! operators {
    ($($Trait:ident $method:ident),*) => {$(
        impl $Trait for Array {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                lanes(|i| self.0[i].$method(b.0[i]))
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl Neg for Array {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        lanes(|i| -self.0[i])
    }
}
