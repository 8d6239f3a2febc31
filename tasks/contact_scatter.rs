use super::scatter::{scatter_rows, to_rows};
use crate::labels::{ContactFlow, ContactSums, ScatterRows, Weights};
use bytemuck::cast_slice_mut;
use engine::graph::task::{At, Body};
use shapes::NodeRows;
use simd::{Simd, Wide, load};

engine::task! {
    /// Particles near another material add to the grid nodes what contact needs to know of their surface.
    pub struct ContactScatter;

    NearParticles task {
        requires new { weights: Weights, flow: ContactFlow }
        computes { nodes: ContactSums @ 3 }
        scratch { rows: ScatterRows }
    }
}

impl Body for ContactScatter {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        flow_to_rows::<S>(&io.flow, &mut io.rows);
        scatter_rows::<S>(at, &io.weights, &io.rows, cast_slice_mut(&mut io.nodes));
    }
}

/// What S_Ip distributes of the contact flows, and what ∇S_Ip does, as rows of particles.
#[inline(always)]
pub fn flow_to_rows<S: Simd>(flows: &[[Wide; 6]], rows: &mut [NodeRows]) {
    let zero = S::splat(0.0);
    for (flow, rows) in flows.iter().zip(rows) {
        let [m, mx, my, mz, v, b] = load(flow);
        to_rows([m, mx, my, mz], [v, zero, zero, v, zero, v], b, rows);
    }
}
