//! A line as two halves, for instruction sets whose registers hold four doubles or fewer.
use super::{LANES, Mask, Simd, Wide};
use bytemuck::{cast_mut, cast_ref};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Four doubles: half a line. The methods are those of [`Simd`], each for four lanes; masks have four bits.
pub trait Half:
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
    fn splat(x: f64) -> Self;
    /// Four numbers that are aligned as half a line.
    fn load(from: &[f64; 4]) -> Self;
    /// To where half a line is aligned.
    fn store(self, to: &mut [f64; 4]);
    fn fma(self, b: Self, c: Self) -> Self;
    fn fms(self, b: Self, c: Self) -> Self;
    fn fnma(self, b: Self, c: Self) -> Self;
    fn sqrt(self) -> Self;
    fn max(self, b: Self) -> Self;
    fn min(self, b: Self) -> Self;
    fn abs(self) -> Self;
    fn floor(self) -> Self;
    fn round(self) -> Self;
    fn ge(self, b: Self) -> Mask;
    fn lt(self, b: Self) -> Mask;
    fn differs(self, b: Self) -> Mask;
    fn select(mask: Mask, yes: Self, no: Self) -> Self;
    fn scale_exponent(self, n: Self) -> Self;
    fn split_exponent(self) -> (Self, Self);
    fn guess_inverse_cube_root(self) -> Self;
    fn transpose(rows: [Self; 4]) -> [Self; 4];
    /// The last lane of `last`, the others of `self`.
    fn with_last(self, last: Self) -> Self;
    /// One lane in all.
    fn spread<const LANE: i32>(self) -> Self;
    /// Lanes 1–3 moved to lanes 0–2, and zero.
    fn without_first(self) -> Self;
}

/// Lanes 0–3 and 4–7.
#[derive(Clone, Copy)]
pub struct Halves<H>(H, H);

/// One half after the other.
macro_rules! both {
    ($($method:ident($($argument:ident),*);)*) => {$(
        #[inline(always)]
        fn $method(self, $($argument: Self),*) -> Self {
            Halves(self.0.$method($($argument.0),*), self.1.$method($($argument.1),*))
        }
    )*};
}
macro_rules! compared {
    ($($method:ident)*) => {$(
        #[inline(always)]
        fn $method(self, b: Self) -> Mask {
            self.0.$method(b.0) | self.1.$method(b.1) << 4
        }
    )*};
}

impl<H: Half> Simd for Halves<H> {
    type Upper = H;

    #[inline(always)]
    fn splat(x: f64) -> Self {
        let half = H::splat(x);
        Halves(half, half)
    }
    #[inline(always)]
    fn load(from: &Wide) -> Self {
        let [low, high]: &[[f64; 4]; 2] = cast_ref(&from.0);
        Halves(H::load(low), H::load(high))
    }
    #[inline(always)]
    fn store(self, to: &mut Wide) {
        let [low, high]: &mut [[f64; 4]; 2] = cast_mut(&mut to.0);
        self.0.store(low);
        self.1.store(high);
    }
    both! {
        fma(b, c);
        fms(b, c);
        fnma(b, c);
        sqrt();
        max(b);
        min(b);
        abs();
        guess_inverse_cube_root();
        floor();
        round();
        scale_exponent(n);
    }
    compared!(ge lt differs);
    #[inline(always)]
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        Halves(H::select(mask, yes.0, no.0), H::select(mask >> 4, yes.1, no.1))
    }
    #[inline(always)]
    fn split_exponent(self) -> (Self, Self) {
        let ((m0, e0), (m1, e1)) = (self.0.split_exponent(), self.1.split_exponent());
        (Halves(m0, m1), Halves(e0, e1))
    }
    #[inline(always)]
    fn transpose(rows: [Self; LANES]) -> [Self; LANES] {
        let [a, b, c, d, e, f, g, h] = rows;
        let [a0, b0, c0, d0] = H::transpose([a.0, b.0, c.0, d.0]);
        let [a1, b1, c1, d1] = H::transpose([e.0, f.0, g.0, h.0]);
        let [e0, f0, g0, h0] = H::transpose([a.1, b.1, c.1, d.1]);
        let [e1, f1, g1, h1] = H::transpose([e.1, f.1, g.1, h.1]);
        [
            Halves(a0, a1),
            Halves(b0, b1),
            Halves(c0, c1),
            Halves(d0, d1),
            Halves(e0, e1),
            Halves(f0, f1),
            Halves(g0, g1),
            Halves(h0, h1),
        ]
    }

    #[inline(always)]
    fn blend_force(a: Self, b: Self) -> Self {
        Halves(a.0, b.1.with_last(a.1))
    }
    #[inline(always)]
    fn momentum_to_low(self) -> Self {
        Halves(self.0.without_first(), self.1.with_last(H::splat(0.0)))
    }
    #[inline(always)]
    fn swap_halves(self) -> Self {
        Halves(self.1, self.0)
    }
    #[inline(always)]
    fn join_low(a: Self, b: Self) -> Self {
        Halves(a.0, b.0)
    }
    #[inline(always)]
    fn with_3_7(self, g: Self) -> Self {
        Halves(self.0.with_last(g.0.spread::<0>()), self.1.with_last(g.0.spread::<1>()))
    }
    #[inline(always)]
    fn with_3(self, g: Self) -> Self {
        Halves(self.0.with_last(g.0.spread::<2>()), self.1)
    }
    #[inline(always)]
    fn force(self) -> H {
        self.1.with_last(H::splat(0.0))
    }
    #[inline(always)]
    fn low_to_force(self) -> H {
        self.0.with_last(H::splat(0.0))
    }
    #[inline(always)]
    fn times_upper(self, t: H) -> H {
        self.1 * t
    }
    #[inline(always)]
    fn fma_upper(self, b: Self, t: H) -> Self {
        Halves(self.0 * b.0, self.1.fma(b.1, t))
    }
}

macro_rules! operators {
    ($($Trait:ident $method:ident),*) => {$(
        impl<H: Half> $Trait for Halves<H> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                Halves(self.0.$method(b.0), self.1.$method(b.1))
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl<H: Half> Neg for Halves<H> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Halves(-self.0, -self.1)
    }
}
