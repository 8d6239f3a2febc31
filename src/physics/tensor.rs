//! Small tensor algebra, eight particles at a time. Full tensors are 9 numbers row by row, symmetric ones
//! 6: xx, xy, xz, yy, yz, zz.
use crate::simd::Simd;

/// det A
#[inline(always)]
pub fn determinant<S: Simd>(a: &[S; 9]) -> S {
    let m0 = a[4].fms(a[8], a[5] * a[7]);
    let m1 = a[3].fms(a[8], a[5] * a[6]);
    let m2 = a[3].fms(a[7], a[4] * a[6]);
    a[0].fma(m0, a[2].fms(m2, a[1] * m1))
}

/// A Aᵀ
#[inline(always)]
pub fn times_transpose<S: Simd>(a: &[S; 9]) -> [S; 6] {
    let dot = |i: usize, k: usize| {
        a[3 * i].fma(a[3 * k], a[3 * i + 1].fma(a[3 * k + 1], a[3 * i + 2] * a[3 * k + 2]))
    };
    [dot(0, 0), dot(0, 1), dot(0, 2), dot(1, 1), dot(1, 2), dot(2, 2)]
}

/// A u
#[inline(always)]
pub fn apply<S: Simd>(a: &[S; 9], u: &[S; 3]) -> [S; 3] {
    std::array::from_fn(|i| a[3 * i].fma(u[0], a[3 * i + 1].fma(u[1], a[3 * i + 2] * u[2])))
}

/// tr A of a symmetric tensor.
#[inline(always)]
pub fn trace<S: Simd>(a: &[S; 6]) -> S {
    a[0] + a[3] + a[5]
}

/// A B
#[inline(always)]
pub fn multiply<S: Simd>(a: &[S; 9], b: &[S; 9]) -> [S; 9] {
    std::array::from_fn(|n| {
        let (i, j) = (n / 3, n % 3);
        a[3 * i].fma(b[j], a[3 * i + 1].fma(b[3 + j], a[3 * i + 2] * b[6 + j]))
    })
}

/// 1 + Δt L
#[inline(always)]
pub fn increment<S: Simd>(l: &[S; 9], dt: S) -> [S; 9] {
    std::array::from_fn(|n| dt.fma(l[n], S::splat(if n % 4 == 0 { 1.0 } else { 0.0 })))
}
