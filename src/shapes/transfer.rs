//! Scatter and gather of one particle, sum-factorized: one axis after the other.
//!
//! A node is one line of eight numbers, so that an addition to a node is one vector operation; the middle node
//! of an axis is what the outer two leave.
use super::Stencil;
use grid::STRIDE;
use simd::{Simd, Wide};
use std::ops::{Add, Sub};

/// Lines from node (0,0,0) to node (2,2,2) of a stencil.
const SPAN: usize = 2 * (STRIDE[0] + STRIDE[1] + STRIDE[2]) + 1;

#[inline(always)]
fn outer<S: Simd>(pair: &[Wide; 2], lane: usize) -> [S; 2] {
    [S::splat(pair[0].0[lane & 7]), S::splat(pair[1].0[lane & 7])]
}

/// What the outer nodes leave to the middle one of N.
#[inline(always)]
fn middle<V: Copy + Add<Output = V> + Sub<Output = V>>(all: V, first: V, last: V, n: usize) -> V {
    all - if n == 3 { first + last } else { first }
}

/// `[A f B]_I += S_I [A · B] + ∂x S_I [T_x] + ∂y S_I [T_y] + ∂z S_I [T_z]` on N nodes an axis, where A is lanes
/// 0–3, f lanes 4–6 and B lane 7; `rows` are `[A, T_x, B]` and `[T_z, ·, T_y, ·]` with T_a the a-th column of T.
#[inline(always)]
pub fn scatter<S: Simd, const X: usize, const Y: usize, const Z: usize>(
    buffer: &mut [Wide],
    stencil: &Stencil,
    lane: usize,
    rows: &[Wide; 2],
) {
    let window: &mut [Wide; SPAN] =
        buffer[stencil.first_node(lane)..].first_chunk_mut().expect("a particle stays near its block");
    let zero = S::splat(0.0);
    let (ax, zy) = (S::load(&rows[0]), S::load(&rows[1]));
    let (ty, tz) = (zy.force(), zy.low_to_force());
    let [wx0, wx2] = outer::<S>(&stencil.weight[0], lane);
    let [wy0, wy2] = outer::<S>(&stencil.weight[1], lane);
    let [wz0, wz2] = outer::<S>(&stencil.weight[2], lane);
    let [gx0, gx2] = outer::<S>(&stencil.gradient[0], lane);
    let [gy0, gy2] = outer::<S>(&stencil.gradient[1], lane);
    let [gz0, gz2] = outer::<S>(&stencil.gradient[2], lane);

    let (a0, y0, z0) = (S::blend_force(wx0, gx0) * ax, wx0.times_upper(ty), wx0.times_upper(tz));
    let (a2, y2, z2) = (S::blend_force(wx2, gx2) * ax, wx2.times_upper(ty), wx2.times_upper(tz));
    let on_x = [a0, middle(S::blend_force(ax, zero), a0, a2, X), a2];
    let ty_on_x = [y0, middle(ty, y0, y2, X), y2];
    let tz_on_x = [z0, middle(tz, z0, z2, X), z2];
    for i in 0..X {
        let (a, ty, tz) = (on_x[i], ty_on_x[i], tz_on_x[i]);
        let (a0, a2) = (wy0.fma_upper(a, gy0.times_upper(ty)), wy2.fma_upper(a, gy2.times_upper(ty)));
        let (z0, z2) = (wy0.times_upper(tz), wy2.times_upper(tz));
        let on_y = [a0, middle(a, a0, a2, Y), a2];
        let tz_on_y = [z0, middle(tz, z0, z2, Y), z2];
        for j in 0..Y {
            let (a, tz) = (on_y[j], tz_on_y[j]);
            let (a0, a2) = (wz0.fma_upper(a, gz0.times_upper(tz)), wz2.fma_upper(a, gz2.times_upper(tz)));
            let on_z = [a0, middle(a, a0, a2, Z), a2];
            for k in 0..Z {
                let line = &mut window[i * STRIDE[0] + j * STRIDE[1] + k];
                (S::load(line) + on_z[k]).store(line);
            }
        }
    }
}

/// Rows `[Σ S v, ∂x v_x | Σ S d, ∂x v_y]` and `[∂y v, ∂x v_z | ∂z v, ·]` of one particle, from nodes
/// `[v, 0, d, 0]`.
#[inline(always)]
pub fn gather<S: Simd, const X: usize, const Y: usize, const Z: usize>(
    buffer: &[Wide],
    stencil: &Stencil,
    lane: usize,
    rows: &mut [Wide; 2],
) {
    let window: &[Wide; SPAN] =
        buffer[stencil.first_node(lane)..].first_chunk().expect("a particle stays near its block");
    let zero = S::splat(0.0);
    let [wx0, wx2] = outer::<S>(&stencil.weight[0], lane);
    let [wy0, wy2] = outer::<S>(&stencil.weight[1], lane);
    let [wz0, wz2] = outer::<S>(&stencil.weight[2], lane);
    let [gx0, gx2] = outer::<S>(&stencil.gradient[0], lane);
    let [gy0, gy2] = outer::<S>(&stencil.gradient[1], lane);
    let [gz0, gz2] = outer::<S>(&stencil.gradient[2], lane);
    // Σ w n = n₁ + w₀ (n₀ − n₁) + w₂ (n₂ − n₁), and the same with g for the derivative
    let (mut value, mut across) = ([zero; 3], [zero; 3]);
    for i in 0..X {
        let (mut on_z, mut dz) = ([zero; 3], [zero; 3]);
        for j in 0..Y {
            let node = |k: usize| S::load(&window[i * STRIDE[0] + j * STRIDE[1] + k]);
            let n1 = node(1);
            let d0 = node(0) - n1;
            (on_z[j], dz[j]) = (wz0.fma(d0, n1), gz0 * d0);
            if Z == 3 {
                let d2 = node(2) - n1;
                (on_z[j], dz[j]) = (wz2.fma(d2, on_z[j]), gz2.fma(d2, dz[j]));
            }
        }
        let (d0, e0) = (on_z[0] - on_z[1], dz[0] - dz[1]);
        let (mut v, mut vy, mut vz) = (wy0.fma(d0, on_z[1]), gy0 * d0, wy0.fma(e0, dz[1]));
        if Y == 3 {
            let (d2, e2) = (on_z[2] - on_z[1], dz[2] - dz[1]);
            (v, vy, vz) = (wy2.fma(d2, v), gy2.fma(d2, vy), wy2.fma(e2, vz));
        }
        (value[i], across[i]) = (v, S::join_low(vy, vz));
    }
    let (d0, e0) = (value[0] - value[1], across[0] - across[1]);
    let (mut v, mut vx, mut vyz) = (wx0.fma(d0, value[1]), gx0 * d0, wx0.fma(e0, across[1]));
    if X == 3 {
        let (d2, e2) = (value[2] - value[1], across[2] - across[1]);
        (v, vx, vyz) = (wx2.fma(d2, v), gx2.fma(d2, vx), wx2.fma(e2, vyz));
    }
    v.with_3_7(vx).store(&mut rows[0]);
    vyz.with_3(vx).store(&mut rows[1]);
}
