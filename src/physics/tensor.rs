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

/// (tr A / 3, J₂, J₃) of a symmetric tensor: its mean and the invariants ½ s:s and det s of its deviator s.
#[inline(always)]
pub fn deviator_invariants<S: Simd>(a: &[S; 6]) -> (S, S, S) {
    let mean = trace(a) * S::splat(1.0 / 3.0);
    let (x, y, z) = (a[0] - mean, a[3] - mean, a[5] - mean);
    let [_, xy, xz, _, yz, _] = *a;
    let squares = xy.fma(xy, xz.fma(xz, yz * yz));
    let j2 = S::splat(0.5).fma(x.fma(x, y.fma(y, z * z)), squares);
    (mean, j2, determinant(&[x, xy, xz, xy, y, yz, xz, yz, z]))
}

/// Bounds (lowest, highest) of the principal values of a positive tensor with tr A / 3 = `mean`; the
/// highest is sharp where two principal values are equal and below the third.
#[inline(always)]
pub fn principal_bounds<S: Simd>(mean: S, j2: S) -> (S, S) {
    let radius = (S::splat(4.0 / 3.0) * j2).sqrt();
    ((mean - radius).max(S::splat(0.0)), mean + radius)
}

/// F A Fᵀ of a symmetric A.
#[inline(always)]
pub fn push_forward<S: Simd>(f: &[S; 9], a: &[S; 6]) -> [S; 6] {
    const FULL: [usize; 9] = [0, 1, 2, 1, 3, 4, 2, 4, 5];
    let fa: [S; 9] = std::array::from_fn(|e| {
        let (row, column) = (3 * (e / 3), e % 3);
        let term = |m: usize| (f[row + m], a[FULL[3 * m + column]]);
        let ((f0, a0), (f1, a1), (f2, a2)) = (term(0), term(1), term(2));
        f0.fma(a0, f1.fma(a1, f2 * a2))
    });
    let dot = |i: usize, k: usize| {
        fa[3 * i].fma(f[3 * k], fa[3 * i + 1].fma(f[3 * k + 1], fa[3 * i + 2] * f[3 * k + 2]))
    };
    [dot(0, 0), dot(0, 1), dot(0, 2), dot(1, 1), dot(1, 2), dot(2, 2)]
}

/// A⁻¹ B; infinite or not a number where A is singular.
#[inline(always)]
pub fn solve<S: Simd>(a: &[S; 9], b: &[S; 9]) -> [S; 9] {
    let inverse_det = S::splat(1.0) / determinant(a);
    // the cofactor of entry (column, row), by cyclic neighbors
    let inverse: [S; 9] = std::array::from_fn(|e| {
        let (row, column) = (e / 3, e % 3);
        let at = |i: usize, k: usize| a[3 * ((column + i) % 3) + (row + k) % 3];
        at(1, 1).fms(at(2, 2), at(1, 2) * at(2, 1)) * inverse_det
    });
    std::array::from_fn(|e| {
        let (row, k) = (3 * (e / 3), e % 3);
        inverse[row].fma(b[k], inverse[row + 1].fma(b[3 + k], inverse[row + 2] * b[6 + k]))
    })
}
