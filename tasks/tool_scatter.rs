use super::contact_scatter::flow_to_rows;
use super::scatter::scatter_rows;
use crate::labels::{ContactFlow, ScatterRows, ToolSums, Weights};
use bytemuck::cast_slice_mut;
use engine::graph::task::{At, Body};
use simd::Simd;

engine::task! {
    /// Particles near tools add to the grid nodes what contact needs to know of their surface.
    pub struct ToolScatter;

    NearParticles task {
        requires new { weights: Weights, flow: ContactFlow }
        computes { nodes: ToolSums @ 3 }
        scratch { rows: ScatterRows }
    }
}

impl Body for ToolScatter {
    #[inline(always)]
    fn run<S: Simd>(&self, at: &At<'_>, mut io: Io<'_>) {
        flow_to_rows::<S>(&io.flow, &mut io.rows);
        scatter_rows::<S>(at, &io.weights, &io.rows, cast_slice_mut(&mut io.nodes));
    }
}
