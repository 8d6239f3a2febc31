//! Elementary functions by polynomials, eight lanes at a time. Polynomials go by Estrin's scheme: short chains, so that the
//! units for multiply-adds are kept busy by one tile alone.
use super::Simd;

/// c₀ + c₁ x
#[inline(always)]
fn two<S: Simd>(x: S, c: [f64; 2]) -> S {
    x.fma(S::splat(c[1]), S::splat(c[0]))
}

/// c₀ + c₁ x + c₂ x² + c₃ x³
#[inline(always)]
fn four<S: Simd>(x: S, x2: S, c: [f64; 4]) -> S {
    x2.fma(two(x, [c[2], c[3]]), two(x, [c[0], c[1]]))
}

/// ln 2 in two parts: the first has trailing zeros, so that n · high is exact.
const LN2_HIGH: f64 = f64::from_bits(0x3FE6_2E42_FEE0_0000);
const LN2_LOW: f64 = f64::from_bits(0x3DEA_39EF_3579_3C76);

/// (eˣ − 1 − x)/x² for |x| ≤ ½ ln 2: the polynomial whose largest error, relative to eˣ, is the smallest, 3.6e-18.
const EXP: [f64; 10] = [
    0.500_000_000_000_001_1,
    0.166_666_666_666_664_13,
    0.041_666_666_666_530_267,
    0.008_333_333_333_494_335,
    0.001_388_888_894_359_795_7,
    0.000_198_412_695_067_767_85,
    2.480_149_313_592_589_5e-5,
    2.755_758_626_820_546_2e-6,
    2.763_023_400_895_679e-7,
    2.500_007_187_181_76e-8,
];

/// eˣ, relative error below 4e-16 for |x| < 700; x is clamped to that range.
#[inline(always)]
pub fn exp<S: Simd>(x: S) -> S {
    let x = x.min(S::splat(700.0)).max(S::splat(-700.0));
    let n = (x * S::splat(std::f64::consts::LOG2_E)).round();
    let r = n.fnma(S::splat(LN2_HIGH), x);
    let r = n.fnma(S::splat(LN2_LOW), r);
    let (r2, [a, b, c, d, e, f, g, h, i, j]) = (r * r, EXP);
    let r4 = r2 * r2;
    let last = r4.fma(two(r, [i, j]), four(r, r2, [e, f, g, h]));
    let tail = r4.fma(last, four(r, r2, [a, b, c, d]));
    (r2.fma(tail, r) + S::splat(1.0)).scale_exponent(n)
}

/// (artanh f − f)/f³ as a polynomial of f² for |f| ≤ (√2 − 1)/(√2 + 1): the one whose largest error, relative to artanh f / f, is
/// the smallest, 1.3e-18.
const LN: [f64; 7] = [
    0.333_333_333_333_336_7,
    0.199_999_999_997_073_4,
    0.142_857_143_711_937_95,
    0.111_110_992_865_919_09,
    0.090_917_821_631_367_69,
    0.076_570_252_731_650_95,
    0.073_979_748_852_369_95,
];

/// ln x for normal positive x, relative error below 4e-16 away from 1, absolute error below 1e-17 near it.
#[inline(always)]
pub fn ln<S: Simd>(x: S) -> S {
    let (m, e) = x.split_exponent();
    let one = S::splat(1.0);
    // ln m = 2 artanh f = 2 f (1 + f²/3 + f⁴/5 + …), |f| < 0.172
    let f = (m - one) / (m + one);
    let (z, [a, b, c, d, p, q, r]) = (f * f, LN);
    let z2 = z * z;
    let last = z2.fma(S::splat(r), two(z, [p, q]));
    let tail = (z2 * z2).fma(last, four(z, z2, [a, b, c, d])) * z;
    let twice = f + f;
    e.fma(S::splat(LN2_HIGH), e.fma(S::splat(LN2_LOW), twice.fma(tail, twice)))
}

/// x^(−1/3) for normal positive x, relative error below 4e-16: cheaper than by `exp` and `ln`.
#[inline(always)]
pub fn inverse_cube_root<S: Simd>(x: S) -> S {
    let mut y = x.guess_inverse_cube_root();
    // with r = 1 − x y³, x^(−1/3) = y (1 − r)^(−1/3) = y (1 + r/3 + 2 r²/9 + 14 r³/81 + …): errors 3e-2, 2e-5, 1e-18
    for _ in 0..2 {
        let r = (x * y).fnma(y * y, S::splat(1.0));
        let series = r.fma(two(r, [2.0 / 9.0, 14.0 / 81.0]), S::splat(1.0 / 3.0));
        y = (y * r).fma(series, y);
    }
    y
}
