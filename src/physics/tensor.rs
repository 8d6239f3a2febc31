//! Small tensor algebra, eight particles at a time. Full tensors are 9 numbers row by row, symmetric ones
//! 6: xx, xy, xz, yy, yz, zz.
//!
//! Loops rather than `map` or `from_fn`, and functions rather than closures: the standard library, and a large closure, may be
//! compiled as functions of their own, without the instruction set of the caller.
use simd::Simd;

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
    let row = |i: usize| a[3 * i].fma(u[0], a[3 * i + 1].fma(u[1], a[3 * i + 2] * u[2]));
    [row(0), row(1), row(2)]
}

/// s A
#[inline(always)]
pub fn scaled<S: Simd>(s: S, mut a: [S; 6]) -> [S; 6] {
    for entry in &mut a {
        *entry = s * *entry;
    }
    a
}

/// u · A u of a symmetric A: xx, xy, xz, yy, yz, zz.
#[inline(always)]
pub fn quadratic<S: Simd>(a: &[S; 6], u: &[S; 3]) -> S {
    let [x, y, z] = *u;
    let normal = (a[0] * x).fma(x, (a[3] * y).fma(y, a[5] * z * z));
    let mixed = (a[1] * x).fma(y, (a[2] * x).fma(z, a[4] * y * z));
    S::splat(2.0).fma(mixed, normal)
}

/// tr A of a symmetric tensor.
#[inline(always)]
pub fn trace<S: Simd>(a: &[S; 6]) -> S {
    a[0] + a[3] + a[5]
}

/// A B
#[inline(always)]
pub fn multiply<S: Simd>(a: &[S; 9], b: &[S; 9]) -> [S; 9] {
    let mut product = *a;
    for i in 0..3 {
        for j in 0..3 {
            product[3 * i + j] = a[3 * i].fma(b[j], a[3 * i + 1].fma(b[3 + j], a[3 * i + 2] * b[6 + j]));
        }
    }
    product
}

/// 1 + Δt L
#[inline(always)]
pub fn increment<S: Simd>(l: &[S; 9], dt: S) -> [S; 9] {
    let mut f = *l;
    for (n, entry) in f.iter_mut().enumerate() {
        *entry = dt.fma(l[n], S::splat(if n % 4 == 0 { 1.0 } else { 0.0 }));
    }
    f
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
    let [xx, xy, xz, yy, yz, zz] = *a;
    let columns = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let [fx, fy, fz] = [apply(f, &columns[0]), apply(f, &columns[1]), apply(f, &columns[2])];
    // (F A)ᵢ · Fₖ
    let dot = |i: usize, k: usize| fx[i].fma(f[3 * k], fy[i].fma(f[3 * k + 1], fz[i] * f[3 * k + 2]));
    [dot(0, 0), dot(0, 1), dot(0, 2), dot(1, 1), dot(1, 2), dot(2, 2)]
}

/// τ : (1 − A⁻¹) of a symmetric τ, the work of a final stress over a step A = 1 + Δt L. Where A crushes to less than a tenth, what would be
/// infinite is not.
#[inline(always)]
pub fn backward_work<S: Simd>(tau: &[S; 6], a: &[S; 9]) -> S {
    let [xx, xy, xz, yy, yz, zz] = *tau;
    let [x, y, z] = [[a[0], a[1], a[2]], [a[3], a[4], a[5]], [a[6], a[7], a[8]]];
    let none = [S::splat(0.0); 3];
    // with rows x, y, z of A: cof A has the rows y × z, z × x, x × y
    let normal = cross_and_add(&x, &y, none);
    let mixed = cross_and_add(&x, &[xy, yy, yz], cross_and_add(&[xx, xy, xz], &y, none));
    let (cofactors, det) = (dot(&[xz, yz, zz], &normal) + dot(&z, &mixed), dot(&z, &normal));
    trace(tau) - cofactors / det.max(S::splat(0.1))
}

/// u · v
#[inline(always)]
fn dot<S: Simd>(u: &[S; 3], v: &[S; 3]) -> S {
    u[0].fma(v[0], u[1].fma(v[1], u[2] * v[2]))
}

/// u × v + w
#[inline(always)]
fn cross_and_add<S: Simd>(u: &[S; 3], v: &[S; 3], w: [S; 3]) -> [S; 3] {
    let mut sum = w;
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        sum[i] = u[k].fnma(v[j], u[j].fma(v[k], sum[i]));
    }
    sum
}

/// A⁻¹ B; infinite or not a number where A is singular.
#[inline(always)]
pub fn solve<S: Simd>(a: &[S; 9], b: &[S; 9]) -> [S; 9] {
    let inverse_det = S::splat(1.0) / determinant(a);
    let mut inverse = *a;
    for (e, entry) in inverse.iter_mut().enumerate() {
        let (row, column) = (e / 3, e % 3);
        // the cofactor of entry (column, row), by cyclic neighbors
        let at = |i: usize, k: usize| a[3 * ((column + i) % 3) + (row + k) % 3];
        *entry = at(1, 1).fms(at(2, 2), at(1, 2) * at(2, 1)) * inverse_det;
    }
    multiply(&inverse, b)
}
