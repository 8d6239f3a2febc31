//! A vector that counts what is done with it: operations of a kernel are counted by running it, not estimated.
use super::{Array, LANES, Mask, Simd, Wide};
use std::cell::Cell;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// Vector operations, each on eight lanes, whether these hold particles or not.
///
/// Not counted: `splat`, because constants are kept in registers, and arithmetic on plain `f64`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Multiplications fused with an addition.
    pub fused: u64,
    /// Additions, subtractions, multiplications.
    pub simple: u64,
    /// Divisions and roots.
    pub slow: u64,
    /// Minima, comparisons, selections, roundings, signs, and what moves lanes (a transpose moves 24 vectors).
    pub other: u64,
    /// Lines loaded.
    pub loads: u64,
    /// Lines stored.
    pub stores: u64,
}

impl Counts {
    /// Floating-point operations: a fused one is two.
    pub fn flop(&self) -> u64 {
        LANES as u64 * (2 * self.fused + self.simple + self.slow)
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, more: Self) {
        self.fused += more.fused;
        self.simple += more.simple;
        self.slow += more.slow;
        self.other += more.other;
        self.loads += more.loads;
        self.stores += more.stores;
    }
}

#[derive(Clone, Copy)]
enum Kind {
    Fused,
    Simple,
    Slow,
    Other,
    Load,
    Store,
}

thread_local! {
    static COUNTS: [Cell<u64>; 6] = const { [const { Cell::new(0) }; 6] };
}

// A function of its own, so that kernels over `Counting` stay small.
#[inline(never)]
fn count(kind: Kind, times: u64) {
    COUNTS.with(|counts| counts[kind as usize].set(counts[kind as usize].get() + times));
}

/// What this thread has counted since it was last asked.
pub fn take() -> Counts {
    let [fused, simple, slow, other, loads, stores] =
        COUNTS.with(|counts| std::array::from_fn(|kind| counts[kind].take()));
    Counts { fused, simple, slow, other, loads, stores }
}

/// Eight `f64` that count, for the thread that computes with them. Slow.
#[derive(Clone, Copy)]
pub struct Counting(Array);

/// Methods that count once and do what arrays do.
macro_rules! counted {
    ($($method:ident($($argument:ident),*) -> $output:ty, $kind:ident;)*) => {$(
        #[inline(never)]
        fn $method(self, $($argument: Self),*) -> $output {
            count(Kind::$kind, 1);
            Counted::wrap(self.0.$method($($argument.0),*))
        }
    )*};
}

/// Results of arrays as results of `Counting`.
trait Counted<T> {
    fn wrap(from: T) -> Self;
}
impl Counted<Array> for Counting {
    fn wrap(from: Array) -> Self {
        Counting(from)
    }
}
impl Counted<Mask> for Mask {
    fn wrap(from: Mask) -> Self {
        from
    }
}

impl Simd for Counting {
    type Upper = Self;

    fn splat(x: f64) -> Self {
        Counting(Array::splat(x))
    }
    #[inline(never)]
    fn load(from: &Wide) -> Self {
        count(Kind::Load, 1);
        Counting(Array::load(from))
    }
    #[inline(never)]
    fn store(self, to: &mut Wide) {
        count(Kind::Store, 1);
        self.0.store(to);
    }
    counted! {
        fma(b, c) -> Self, Fused;
        fms(b, c) -> Self, Fused;
        fnma(b, c) -> Self, Fused;
        sqrt() -> Self, Slow;
        max(b) -> Self, Other;
        min(b) -> Self, Other;
        abs() -> Self, Other;
        floor() -> Self, Other;
        round() -> Self, Other;
        ge(b) -> Mask, Other;
        lt(b) -> Mask, Other;
        differs(b) -> Mask, Other;
        swap_halves() -> Self, Other;
        scale_exponent(n) -> Self, Other;
        force() -> Self, Other;
        low_to_force() -> Self, Other;
        times_upper(t) -> Self, Simple;
        fma_upper(b, t) -> Self, Fused;
        momentum_to_low() -> Self, Other;
        with_3_7(g) -> Self, Other;
        with_3(g) -> Self, Other;
    }
    fn select(mask: Mask, yes: Self, no: Self) -> Self {
        count(Kind::Other, 1);
        Counting(Array::select(mask, yes.0, no.0))
    }
    fn split_exponent(self) -> (Self, Self) {
        // as AVX-512: a difference, two shifts, a difference, a conversion
        count(Kind::Other, 5);
        let (mantissa, exponent) = self.0.split_exponent();
        (Counting(mantissa), Counting(exponent))
    }
    fn guess_inverse_cube_root(self) -> Self {
        // a product and a difference, two shifts, and a union of bits
        count(Kind::Fused, 1);
        count(Kind::Other, 3);
        Counting(self.0.guess_inverse_cube_root())
    }
    fn transpose(rows: [Self; LANES]) -> [Self; LANES] {
        count(Kind::Other, 24);
        Array::transpose(rows.map(|row| row.0)).map(Counting)
    }
    fn blend_force(a: Self, b: Self) -> Self {
        count(Kind::Other, 1);
        Counting(Array::blend_force(a.0, b.0))
    }
    fn join_low(a: Self, b: Self) -> Self {
        count(Kind::Other, 1);
        Counting(Array::join_low(a.0, b.0))
    }
}

macro_rules! operators {
    ($($Trait:ident $method:ident $kind:ident),*) => {$(
        impl $Trait for Counting {
            type Output = Self;
            #[inline(never)]
            fn $method(self, b: Self) -> Self {
                count(Kind::$kind, 1);
                Counting(self.0.$method(b.0))
            }
        }
    )*};
}
operators!(Add add Simple, Sub sub Simple, Mul mul Simple, Div div Slow);

impl Neg for Counting {
    type Output = Self;
    #[inline(never)]
    fn neg(self) -> Self {
        count(Kind::Other, 1);
        Counting(-self.0)
    }
}
