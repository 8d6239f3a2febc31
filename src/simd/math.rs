//! Elementary functions by polynomials, eight lanes at a time.
use super::Simd;

/// Σ cᵢ xⁱ, by Horner's rule.
#[inline(always)]
pub fn polynomial<S: Simd>(x: S, coefficients: &[f64]) -> S {
    let mut terms = coefficients.iter().rev();
    let last = S::splat(terms.next().copied().unwrap_or(0.0));
    terms.fold(last, |sum, &c| sum.fma(x, S::splat(c)))
}

/// 1/n! for n = 0..=13
const INVERSE_FACTORIALS: [f64; 14] = {
    let mut c = [1.0; 14];
    let mut n = 1;
    while n < 14 {
        c[n] = c[n - 1] / n as f64;
        n += 1;
    }
    c
};

/// 1/(2n+1) for n = 1..=11
const INVERSE_ODDS: [f64; 11] = {
    let mut c = [0.0; 11];
    let mut n = 0;
    while n < 11 {
        c[n] = 1.0 / (2 * n + 3) as f64;
        n += 1;
    }
    c
};

/// ln 2 in two parts: the first has trailing zeros, so that n · high is exact.
const LN2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEE0_0000);
const LN2_LOW: f64 = f64::from_bits(0x3DEA_39EF_3579_3C76);

/// eˣ, relative error below 4e-16 for |x| < 700; x is clamped to that range.
#[inline(always)]
pub fn exp<S: Simd>(x: S) -> S {
    let x = x.min(S::splat(700.0)).max(S::splat(-700.0));
    let n = (x * S::splat(std::f64::consts::LOG2_E)).round();
    let r = n.fnma(S::splat(LN2_HIGH), x);
    let r = n.fnma(S::splat(LN2_LOW), r);
    // the Taylor series in two interleaved halves: two short chains instead of a long one
    let r2 = r * r;
    let even: [f64; 7] = std::array::from_fn(|i| INVERSE_FACTORIALS[2 * i]);
    let odd: [f64; 7] = std::array::from_fn(|i| INVERSE_FACTORIALS[2 * i + 1]);
    r.fma(polynomial(r2, &odd), polynomial(r2, &even)).scale_exponent(n)
}

/// ln x for normal positive x, relative error below 4e-16 away from 1, absolute error below 1e-17 near it.
#[inline(always)]
pub fn ln<S: Simd>(x: S) -> S {
    let (m, e) = x.split_exponent();
    let one = S::splat(1.0);
    // ln m = 2 artanh f = 2 f (1 + f²/3 + f⁴/5 + …), |f| < 0.172
    let f = (m - one) / (m + one);
    let z = f * f;
    let tail = polynomial(z, &INVERSE_ODDS) * z;
    let twice = f + f;
    e.fma(S::splat(LN2_HIGH), e.fma(S::splat(LN2_LOW), twice.fma(tail, twice)))
}
