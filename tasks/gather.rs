use crate::labels::{GatherRows, GridVelocity, NodeMotion, VelocityChange, VelocityGradient, Weights};
use bytemuck::cast_slice;
use engine::graph::task::{At, Body};
use shapes::for_each_particle_by_class;
use shapes::transfer::gather;
use shapes::{GROUP, NodeRows};
use simd::{Simd, Wide};

engine::task! {
    /// Particles read velocity, its change and its gradient from the grid nodes around them: Σ_I S_Ip v_I, Σ_I S_Ip Δv_I and
    /// L_p = Σ_I v_I ⊗ ∇S_Ip.
    pub struct Gather;

    Particles task {
        requires new { weights: Weights }
        requires now { nodes: NodeMotion @ 3 }
        computes {
            velocity: GridVelocity,
            change: VelocityChange,
            gradient: VelocityGradient,
        }
        scratch { rows: GatherRows }
    }
}

impl Body for Gather {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        let nodes: &[Wide] = cast_slice(&io.nodes);
        let mut results = io.velocity.iter_mut().zip(io.change.iter_mut()).zip(io.gradient.iter_mut());
        for (group, weights) in io.weights.chunks(GROUP).enumerate() {
            let count = at.count.saturating_sub(8 * GROUP * group).min(8 * GROUP);
            // lanes without a particle gather nothing: they stay at rest
            for lane in count..8 * weights.len() {
                io.rows[lane >> 3][lane & 7] = [Wide::default(); 2];
            }
            for_each_particle_by_class!(weights, count, |i, X, Y, Z| gather::<S, X, Y, Z>(
                nodes,
                &weights[i >> 3],
                i & 7,
                &mut io.rows[i >> 3][i & 7]
            ));
            for (rows, ((v, dv), l)) in io.rows[..weights.len()].iter().zip(&mut results) {
                to_columns::<S>(rows, v, dv, l);
            }
        }
    }
}

#[inline(always)]
fn to_columns<S: Simd>(rows: &NodeRows, v: &mut [Wide; 3], dv: &mut [Wide; 3], l: &mut [Wide; 9]) {
    let (mut first, mut second) = ([S::splat(0.0); 8], [S::splat(0.0); 8]);
    for (lane, row) in rows.iter().enumerate() {
        (first[lane], second[lane]) = (S::load(&row[0]), S::load(&row[1]));
    }
    let (first, second) = (S::transpose(first), S::transpose(second));
    let dx = [first[3], first[7], second[3]];
    for i in 0..3 {
        first[i].store(&mut v[i]);
        first[4 + i].store(&mut dv[i]);
        dx[i].store(&mut l[3 * i]);
        second[i].store(&mut l[3 * i + 1]);
        second[4 + i].store(&mut l[3 * i + 2]);
    }
}
